"""Judge: the spectra and intensities of MIL-F-8785C, and JSBSim's own turbulence as measured."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from aircraft.turbulence import ROOT_THREE, Turbulence, _second_order, across_spectrum, along_spectrum
from aircraft.turbulence_intensity import INTENSITIES, intensity
from aircraft.wind import SteadyWind, steady_wind

MODERATE = INTENSITIES["moderate"]


def test_three_intensities_are_15_30_45_knots():
    assert list(INTENSITIES.values()) == pytest.approx([knots * 1852.0 / 3600.0 for knots in (15, 30, 45)])


@pytest.mark.parametrize(
    ("height", "along", "up"),
    [(30.0, 2.66, 1.53), (100.0, 2.17, 1.50), (300.0, 1.59, 1.50)],  # JSBSim's Milspec, measured at 50 ft/s at 20 ft
)
def test_intensity_agrees_with_jsbsims_turbulence(height, along, up):
    now = intensity(height, 15.24)
    assert now.sigma_along == pytest.approx(along, rel=0.05)
    assert now.sigma_up == pytest.approx(up, rel=0.05)


def test_scale_lengths_at_1000_ft_are_1000_ft():
    assert intensity(304.8, MODERATE).length_along == pytest.approx(304.8)
    assert intensity(304.8, MODERATE).length_up == pytest.approx(304.8)
    assert intensity(304.8, MODERATE).sigma_along == pytest.approx(0.1 * MODERATE)


def test_intensity_at_100_ft_by_hand():
    # 0.177 + 0.0823 = 0.2593; 0.2593^-0.4 = 1.7159; 100 ft / 0.2593^1.2 = 505.2 ft
    now = intensity(30.48, 10.0)
    assert now.sigma_along == pytest.approx(1.7159, abs=1e-4)
    assert now.length_along == pytest.approx(505.2 * 0.3048, rel=1e-4)
    assert (now.sigma_up, now.length_up) == pytest.approx((1.0, 30.48))


@pytest.fixture(scope="module")
def records():
    """800 independent gusts of 6 s each at three heights, moderate, 72 m/s: (run, time, axis)."""
    # independent short runs, because an hour of one run at 300 m holds only a few hundred independent gusts
    times = [step / 20.0 for step in range(120)]

    def run(generator, height):
        turbulence = Turbulence(MODERATE, generator, course=0.0, rate=20.0)
        return [turbulence.velocity(time, (0.0, 0.0, height), 72.0) for time in times]

    generators = np.random.default_rng(7).spawn(800)
    return {height: np.array([run(generator, height) for generator in generators]) for height in (30.0, 100.0, 300.0)}


@pytest.mark.parametrize("height", [30.0, 100.0, 300.0])
def test_sigmas_are_those_of_the_specification_from_the_first_step(records, height):
    now = intensity(height, MODERATE)
    wanted = [now.sigma_along, now.sigma_along, now.sigma_up]
    gusts = records[height]
    # over all steps 5 %, as required; of the first step alone 800 samples: 2.5 % standard error, 4 of them
    assert np.sqrt((gusts**2).mean(axis=(0, 1))) == pytest.approx(wanted, rel=0.05)
    assert np.sqrt((gusts[:, 0] ** 2).mean(axis=0)) == pytest.approx(wanted, rel=0.1)


@pytest.mark.parametrize("height", [30.0, 100.0, 300.0])
def test_autocorrelation_is_the_transform_of_the_dryden_spectrum(records, height):
    """exp(-|r|/L) along, exp(-|r|/L) (1 - |r|/2L) across and up."""
    now = intensity(height, MODERATE)
    gusts = records[height]
    lag = 20  # 1 s
    for axis, length in ((0, now.length_along), (1, now.length_along), (2, now.length_up)):
        shift = 72.0 * lag / 20.0 / length
        wanted = math.exp(-shift) * (1.0 if axis == 0 else 1.0 - shift / 2.0)
        product = (gusts[:, lag:, axis] * gusts[:, :-lag, axis]).mean() / (gusts[..., axis] ** 2).mean()
        assert product == pytest.approx(wanted, abs=0.05)  # 800 runs of about two correlation times


@pytest.mark.parametrize("step", [1e-3, 0.01, 0.2, 2.0])
def test_discretisation_keeps_the_stationary_covariance(step):
    """Phi P Phi' + Q = P for the P of the continuous filter, from its Lyapunov equation."""
    f, h, q11, q21, q22 = _second_order(step)
    drift = np.array([[-1.0, 0.0], [1.0, -1.0]])
    stationary = np.array([[0.5, 0.25], [0.25, 0.25]])
    noise = np.array([[1.0, 0.0], [0.0, 0.0]])
    assert drift @ stationary + stationary @ drift.T + noise == pytest.approx(np.zeros((2, 2)), abs=1e-15)
    transition = f * np.array([[1.0, 0.0], [h, 1.0]])
    root = np.array([[q11, 0.0], [q21, q22]])
    assert transition @ stationary @ transition.T + root @ root.T == pytest.approx(stationary, abs=1e-12)
    output = np.array([ROOT_THREE, 1.0 - ROOT_THREE])
    assert output @ stationary @ output == pytest.approx(1.0, abs=1e-12)


def test_a_row_of_noise_belongs_to_a_step_however_the_time_is_asked():
    def make():
        return Turbulence(MODERATE, np.random.default_rng(1))

    place = (0.0, 0.0, 100.0)
    often, seldom = make(), make()
    every = [often.velocity(step / 120.0, place, 72.0) for step in range(2000)]
    assert [seldom.velocity(step / 120.0, place, 72.0) for step in range(0, 2000, 4)] == every[::4]
    assert seldom.velocity(1996 / 120.0, place, 72.0) == every[1996]  # the same time again is the same gust


def test_the_gust_is_frozen_in_the_air_that_is_flown_through():
    """Twice the airspeed at twice the rate meets the same gusts at the same places."""
    slow = Turbulence(MODERATE, np.random.default_rng(1), rate=60.0)
    fast = Turbulence(MODERATE, np.random.default_rng(1), rate=120.0)
    for step in range(100):
        met = fast.velocity(step / 120.0, (0.0, 0.0, 50.0), 80.0)
        assert slow.velocity(step / 60.0, (0.0, 0.0, 50.0), 40.0) == pytest.approx(met, abs=1e-12)
    other = Turbulence(MODERATE, np.random.default_rng(1), rate=120.0)
    assert other.velocity(99 / 120.0, (0.0, 0.0, 50.0), 40.0) != pytest.approx(met, abs=1e-3)


def test_turbulence_does_not_depend_on_the_wind_but_turns_with_it():
    place = (0.0, 0.0, 100.0)
    calm = Turbulence(MODERATE, np.random.default_rng(1))
    windy = Turbulence(MODERATE, np.random.default_rng(1), SteadyWind(0.0, 10.0, 0.0))
    for step in range(100):
        along, across, up = calm.velocity(step / 120.0, place, 72.0)
        north, east, rising = windy.velocity(step / 120.0, place, 72.0)
        assert (north, east - 10.0, rising) == pytest.approx((-across, along, up), abs=1e-12)


def test_no_turbulence_is_the_steady_wind():
    still = Turbulence(0.0, np.random.default_rng(1), SteadyWind(1.0, 2.0, 0.0))
    assert still.velocity(3.0, (0.0, 0.0, 50.0), 60.0) == pytest.approx((1.0, 2.0, 0.0))


def test_wind_from_the_west_moves_east():
    wind = steady_wind(math.radians(270.0), 10.0)
    assert wind == pytest.approx((0.0, 10.0, 0.0), abs=1e-12)
    assert wind.velocity(5.0, (1.0, 2.0, 3.0), 70.0) == wind


@pytest.mark.parametrize(("wind_at_20_ft", "rate"), [(-1.0, 120.0), (math.nan, 120.0), (7.0, 0.0)])
def test_impossible_turbulence_is_refused(wind_at_20_ft, rate):
    with pytest.raises(ValueError, match="must"):
        Turbulence(wind_at_20_ft, np.random.default_rng(1), rate=rate)


@pytest.mark.parametrize(("height", "sigma"), [(500.0, 2.42), (800.0, 3.07), (2000.0, 3.13)])
def test_intensity_aloft_agrees_with_jsbsims_turbulence(height, sigma):
    """Its Milspec at severity 4, moderate, as tests/acceptance/test_weather.py measures it over 8000 s."""
    now = intensity(height, MODERATE)
    assert (now.sigma_along, now.sigma_up) == pytest.approx((sigma, sigma), rel=0.05)


# ---- aloft, and the spectra --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("severity", "feet", "printed"),
    [("light", 3750.0, 7.4), ("moderate", 7500.0, 10.1), ("severe", 15000.0, 22.1), ("light", 60000.0, 0.0)],
)
def test_aloft_the_intensity_is_that_of_the_figure_and_the_same_in_every_direction(severity, feet, printed):
    now = intensity(feet * 0.3048, INTENSITIES[severity])
    assert (now.sigma_along, now.sigma_up) == pytest.approx((printed * 0.3048, printed * 0.3048))
    assert (now.length_along, now.length_up) == pytest.approx((1750.0 * 0.3048, 1750.0 * 0.3048))


@pytest.mark.parametrize("severity", list(INTENSITIES))
def test_from_1000_to_2000_ft_all_four_values_go_linearly(severity):
    below, middle, above = (intensity(feet * 0.3048, INTENSITIES[severity]) for feet in (1000.0, 1500.0, 2000.0))
    assert middle == pytest.approx([(low + high) / 2.0 for low, high in zip(below, above, strict=True)])
    for feet, there in ((1000.0, below), (2000.0, above)):
        assert intensity(feet * 0.3048 + 1e-6, INTENSITIES[severity]) == pytest.approx(there, rel=1e-6)


def test_more_wind_near_the_ground_is_more_turbulence_aloft():
    sigmas = [intensity(1000.0, wind).sigma_up for wind in (0.0, 4.0, 7.7, 12.0, 15.4, 20.0, 23.2, 40.0)]
    assert sigmas[0] == 0.0
    assert sigmas == sorted(sigmas)


@pytest.mark.parametrize(
    ("spectrum", "correlation"),
    [(along_spectrum, lambda x: math.exp(-x)), (across_spectrum, lambda x: math.exp(-x) * (1.0 - x / 2.0))],
)
def test_a_spectrum_is_the_transform_of_its_autocorrelation(spectrum, correlation):
    """The integral of density times cosine over all frequencies; at lag zero it is the variance."""
    airspeed, sigma, length = 60.0, 2.0, 300.0
    for lag in (0.0, 2.0, 8.0):
        weight = {"weight": "cos", "wvar": lag} if lag else {}
        density, _ = quad(spectrum, 0.0, math.inf, args=(airspeed, sigma, length), **weight)
        assert density == pytest.approx(sigma**2 * correlation(airspeed * lag / length), abs=1e-6)


def test_spectra_fall_with_the_square_of_the_frequency():
    for spectrum in (along_spectrum, across_spectrum):
        assert spectrum(200.0, 60.0, 2.0, 300.0) / spectrum(100.0, 60.0, 2.0, 300.0) == pytest.approx(0.25, rel=1e-3)
