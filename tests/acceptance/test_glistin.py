"""Glistin, Panasyuk at full size: what load factors gain over a tuned filter without them, and what they cost."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tracking.gaussian import Gaussian
from tracking.measurement import DebiasedPolar
from tracking.motion import GRAVITY
from tracking.track import Measurements, follow
from tracking.trackers.load_factor import DOWNLINK, LoadFactor
from tracking.trackers.load_factor_cartesian import LoadFactorCartesian

pytestmark = pytest.mark.acceptance

DEGREE = np.pi / 180
RADAR = ("range", "azimuth", "elevation")
MEASURED = (*("radar." + name for name in RADAR), *("link." + name for name in DOWNLINK))
FINE = 0.01  # s, grid of the truths
BANK = 15 * DEGREE
TUNING, REPORT = 1, 2  # seeds


def ramp(time, start, stop, rise=5.0):
    def smooth(x):
        x = np.clip(x, 0.0, 1.0)
        return x**3 * (10 - 15 * x + 6 * x * x)

    return smooth((time - start) / rise) - smooth((time - stop) / rise)


def fly(duration, north, east, course, bank, speed=72.0, height=400.0):
    """Coordinated level flight of a point past a radar at the origin that looks north."""

    def integral(values, step):  # Simpson's rule over pairs of steps, at every second point
        parts = (values[:-2:2] + 4 * values[1:-1:2] + values[2::2]) * step / 3
        return np.concatenate([[0.0], np.cumsum(parts)])

    quarter = np.arange(round(duration / FINE) * 4 + 1) * FINE / 4
    courses = course + integral(GRAVITY * np.tan(bank(quarter)) / speed, FINE / 4)
    n = north + integral(speed * np.cos(courses), FINE / 2)
    e = east + integral(speed * np.sin(courses), FINE / 2)
    time, chi = quarter[::4], courses[::2]
    turn = GRAVITY * np.tan(bank(time)) / speed
    vn, ve = speed * np.cos(chi), speed * np.sin(chi)
    square = n * n + e * e
    rho, slant, radial = np.sqrt(square), np.sqrt(square + height**2), n * vn + e * ve
    return {
        "time": time,
        "north": n,
        "east": e,
        "north_rate": vn,
        "east_rate": ve,
        "range": slant,
        "range_rate": radial / slant,
        "azimuth": np.arctan2(e, n),
        "azimuth_rate": (n * ve - e * vn) / square,
        "elevation": np.arctan2(height, rho),
        "elevation_rate": -height * radial / rho / slant**2,
        "load_factor_forward": np.zeros_like(time),
        "load_factor_up": np.hypot(1.0, speed * turn / GRAVITY),
        "load_factor_right": np.zeros_like(time),
        "aerodynamic_bank": np.arctan(speed * turn / GRAVITY),
        "flight_path_angle": np.zeros_like(time),
        "air_course": chi,
        "turning": np.abs(bank(time)) > DEGREE,
    }


FLIGHTS = {
    "base": fly(120, 8500, 4950, -np.pi / 2, lambda t: -BANK * ramp(t, 40, 84.5)),
    "S-turn": fly(100, 9800, 300, np.pi, lambda t: -BANK * (ramp(t, 10, 30) - ramp(t, 35, 75) + ramp(t, 80, 100))),
    "near": fly(75, 3300, -900, 130 * DEGREE, lambda t: -BANK * (ramp(t, 15, 35) - ramp(t, 40, 60)), height=300.0),
    "straight": fly(90, 9000, -1000, np.pi - 3 * DEGREE, lambda t: 0.0 * t),
}
SIGMAS = {"range": 30.0, "aerodynamic_bank": 0.5 * DEGREE, "flight_path_angle": 0.25 * DEGREE,
          "air_course": 0.5 * DEGREE}  # fmt: skip
CONDITIONS = {".7 s, 1 deg": (0.7, DEGREE), ".5 s, .15 deg": (0.5, 0.15 * DEGREE)}
SETTLED = 15  # epochs


def observed(flight, period, angle, runs, seed, latency=0.0, bias=None, load_factor=0.01):
    """Epochs of the truth and noisy measurements; the downlink ``latency`` seconds old and biased."""
    rng = np.random.default_rng(seed)
    stride, late = round(period / FINE), round(latency / FINE)
    rows = np.arange(stride, len(flight["time"]), stride)
    names = [name.split(".")[1] for name in MEASURED]
    sigmas = np.array([SIGMAS.get(name, angle if name in RADAR else load_factor) for name in names])
    exact = np.stack(
        [flight[name][rows if name in RADAR else np.maximum(rows - late, 0)] + (bias or {}).get(name, 0.0)
         for name in names], axis=1,
    )[..., None]  # fmt: skip
    z = exact + sigmas[:, None] * rng.standard_normal((len(rows), len(names), runs))
    R = np.broadcast_to(np.diag(sigmas**2), (len(rows), 9, 9))
    return rows, Measurements(MEASURED, flight["time"][rows], flight["time"][rows], z, R)


def deaf(measurements, chosen=slice(None)):
    z = np.array(measurements.z)
    z[chosen, 3:] = np.nan
    return Measurements(measurements.channels, measurements.time, measurements.arrival, z, measurements.R)


def prior_of(flight, tracker, angle, runs, seed):
    rng = np.random.default_rng([seed, 1])
    if isinstance(tracker, LoadFactor):
        sigmas = np.array([100.0, 5.0, 2 * angle, 0.002, 2 * angle, 5e-4])
    else:
        sigmas = np.array([100.0, 5.0, 100.0, 5.0])
    names = [name.removeprefix("radar.") for name in tracker.channels]
    mean = np.array([flight[name][0] for name in names])[:, None]
    return Gaussian(mean + sigmas[:, None] * rng.standard_normal((len(mean), runs)), np.diag(sigmas**2))


def errors(tracker, flight, seen, angle, seed):
    """Azimuth errors (k, runs), deg."""
    rows, measurements = seen
    polar = isinstance(tracker, LoadFactor)
    found = []
    prior = prior_of(flight, tracker, angle, measurements.z.shape[2], seed)
    for epoch in follow(tracker, measurements, prior, start=0.0):
        mean = epoch.estimate.mean
        azimuth = mean[2] if polar else np.arctan2(mean[2], mean[0])
        found.append(azimuth - flight["azimuth"][rows[epoch.row]])
    return ((np.array(found) + np.pi) % (2 * np.pi) - np.pi) / DEGREE


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def turn_of(flight, rows):
    """Epochs of the turn after the start, or all of them on a straight leg."""
    chosen = np.array(flight["turning"][rows])
    chosen[:SETTLED] = False
    return chosen if chosen.any() else np.arange(len(rows)) >= SETTLED


POLAR = LoadFactor(MEASURED, 0.0)
CARTESIAN = LoadFactorCartesian(DebiasedPolar((0.0, 0.0), 0.0, None), MEASURED)


def candidates(name):
    """The grid of each filter; those named CA are given no downlink.

    The Coriolis term takes its range rate from the range block, so the range's noise belongs to the grid of the
    corrected filters: near the radar a slow range block costs them all they gain.
    """
    densities = (1e-8, 1e-7, 1e-6, 1e-5)
    if name == "CA":
        grid = itertools.product((1e-7, 3e-7, 1e-6, 3e-6, 1e-5), (10.0, 40.0))
        return [replace(POLAR, kinematic_density=q, kinematic_correlation_time=t) for q, t in grid]
    if name in ("published", "intended"):
        return [replace(POLAR, azimuth_acceleration=name, azimuth_density=q) for q in densities]
    if name == "corrected":
        grid = itertools.product((3e-10, 3e-9, 3e-8, 1e-7), RANGES)
        return [replace(POLAR, azimuth_acceleration=name, azimuth_density=q, range_density=r) for q, r in grid]
    if name == "corrected + residual":
        grid = itertools.product((1e-10, 1e-9, 1e-8), (5.0, 20.0), RANGES)
        return [replace(POLAR, azimuth_density=q, azimuth_correlation_time=t, range_density=r) for q, t, r in grid]
    if name == "cartesian CA":
        grid = itertools.product((10.0, 60.0, 300.0), (10.0, 40.0))
        return [replace(CARTESIAN, kinematic_density=q, kinematic_correlation_time=t) for q, t in grid]
    return [replace(CARTESIAN, residual_density=q) for q in (0.003, 0.03, 0.3)]


RANGES = (100.0, 1e4, 1e5)  # m2/s3
FILTERS = ("CA", "published", "intended", "corrected", "corrected + residual", "cartesian CA", "cartesian + input")


@pytest.mark.parametrize("condition", list(CONDITIONS))
@pytest.mark.parametrize("name", list(FLIGHTS))
def test_gain_over_the_tuned_filter_without_aid(name, condition, row):
    """C7: every filter tuned by its grid on one seed (30 runs), all reported on another (200 runs)."""
    flight, (period, angle) = FLIGHTS[name], CONDITIONS[condition]
    tuning, report = (observed(flight, period, angle, runs, seed) for runs, seed in ((30, TUNING), (200, REPORT)))
    turn = turn_of(flight, report[0])
    whole, turning = {}, {}
    for kind in FILTERS:
        listen = (lambda seen: (seen[0], deaf(seen[1]))) if kind.endswith("CA") else (lambda seen: seen)
        best = min(candidates(kind), key=lambda t: rms(errors(t, flight, listen(tuning), angle, TUNING)[SETTLED:]))
        found = errors(best, flight, listen(report), angle, REPORT)
        whole[kind], turning[kind] = rms(found[SETTLED:]), rms(found[turn])
        text = f"{whole[kind]:.4f} / {turning[kind]:.4f} deg"
        print(kind, best)
        gain = f"{whole['CA'] / whole[kind]:.2f} / {turning['CA'] / turning[kind]:.2f}"
        row(f"{name} {condition}, {kind}: all / turn", "reported", f"{text}, gain {gain}", True)
    gain = {kind: turning["CA"] / turning[kind] for kind in FILTERS}
    row(f"{name} {condition}: gain in the turn of the printed formula", ".85 .. 1.25", f"{gain['published']:.2f}",
        0.85 < gain["published"] < 1.25)  # fmt: skip
    assert 0.8 < gain["published"] < 1.25  # no reliable benefit
    if name == "straight":
        assert gain["corrected + residual"] > 1.0  # the Coriolis term pays on straight legs too
        return
    for kind in ("corrected", "corrected + residual"):
        row(f"{name} {condition}: gain in the turn, {kind}", "1.3 .. 2.2", f"{gain[kind]:.2f}", 1.3 < gain[kind] < 2.2)
    assert 1.2 < gain["corrected"] < 2.2  # near the radar the printed step of delay leaves it short of 1.3
    assert 1.3 < gain["corrected + residual"] < 2.2
    assert 1.3 < gain["cartesian + input"] < 2.5


def test_trusting_the_print_is_worse_than_doing_without(row):
    for name in ("base", "S-turn"):
        flight, (period, angle) = FLIGHTS[name], CONDITIONS[".5 s, .15 deg"]
        seen = observed(flight, period, angle, 100, REPORT)
        turn = turn_of(flight, seen[0])
        plain = rms(errors(POLAR, flight, (seen[0], deaf(seen[1])), angle, REPORT)[turn])
        trusted = replace(POLAR, azimuth_acceleration="published", azimuth_density=1e-10)
        ratio = rms(errors(trusted, flight, seen, angle, REPORT)[turn]) / plain
        row(f"printed formula trusted, {name}: RMSE over no aid, turn", "> 2", f"{ratio:.1f}", ratio > 2)
        assert ratio > 2


@pytest.mark.parametrize("name", ["base", "S-turn"])
def test_latency_of_the_downlink(name, row):
    """C10: half a second still pays in a base turn; a second does not in an S-turn."""
    flight, (period, angle) = FLIGHTS[name], CONDITIONS[".5 s, .15 deg"]
    gains = {}
    for latency in (0.0, 0.25, 0.5, 1.0, 2.0, 4.0):
        seen = observed(flight, period, angle, 200, REPORT, latency)
        turn = turn_of(flight, seen[0])
        plain = rms(errors(POLAR, flight, (seen[0], deaf(seen[1])), angle, REPORT)[turn])
        gains[latency] = plain / rms(errors(POLAR, flight, seen, angle, REPORT)[turn])
    text = ", ".join(f"{latency:g} s {gain:.2f}" for latency, gain in gains.items())
    met = gains[0.5] > 1.5 if name == "base" else gains[1.0] < 1.1
    row(f"latency of the downlink, {name}: gain in the turn", "base .5 s > 1.5, S-turn 1 s < 1.1", text, met)
    assert met
    assert gains[4.0] < gains[1.0] < gains[0.0]


def test_sensitivity_to_what_the_downlink_gets_wrong(row):
    """Base turn, .5 s and .15 deg, fixed tuning: gain in the turn and on the straight legs."""
    flight, (period, angle) = FLIGHTS["base"], CONDITIONS[".5 s, .15 deg"]
    gains = {}
    for text, fields in {
        "nominal": {},
        "load factors to .03": {"load_factor": 0.03},
        "load factors to .1": {"load_factor": 0.1},
        "bank biased 1 deg": {"bias": {"aerodynamic_bank": DEGREE}},
        "bank biased 3 deg": {"bias": {"aerodynamic_bank": 3 * DEGREE}},
        "right load factor biased .02": {"bias": {"load_factor_right": 0.02}},
        "forward load factor biased .05": {"bias": {"load_factor_forward": 0.05}},
        "course biased 5 deg": {"bias": {"air_course": 5 * DEGREE}},
    }.items():
        seen = observed(flight, period, angle, 100, REPORT, **fields)
        turn = turn_of(flight, seen[0])
        straight = ~turn
        straight[:SETTLED] = False
        plain = errors(POLAR, flight, (seen[0], deaf(seen[1])), angle, REPORT)
        aided = errors(POLAR, flight, seen, angle, REPORT)
        gains[text] = rms(plain[turn]) / rms(aided[turn]), rms(plain[straight]) / rms(aided[straight])
        row(f"downlink, {text}: gain turn / straight", "reported", "{:.2f} / {:.2f}".format(*gains[text]), True)
    nominal = gains.pop("nominal")
    assert all(gain[0] < nominal[0] * 1.02 for gain in gains.values())
    assert gains["bank biased 3 deg"][0] < gains["bank biased 1 deg"][0]


def test_downlink_lost_for_half_a_minute(row):
    """C11: with the switch to kinematic noise the gap costs no more than flying without aid."""
    flight, (period, angle) = FLIGHTS["base"], CONDITIONS[".5 s, .15 deg"]
    rows, measurements = observed(flight, period, angle, 200, REPORT)
    gap = (measurements.time >= 45.0) & (measurements.time < 75.0)
    lost = (rows, deaf(measurements, gap))
    for text, tracker in {"polar": POLAR, "cartesian": CARTESIAN}.items():
        plain = rms(errors(tracker, flight, (rows, deaf(measurements)), angle, REPORT)[gap])
        switched = rms(errors(tracker, flight, lost, angle, REPORT)[gap]) / plain
        kept = rms(errors(replace(tracker, dropout=1e3), flight, lost, angle, REPORT)[gap]) / plain
        row(f"downlink lost for 30 s, {text}: RMSE over no aid, switched / kept", "<= 1.05 / > 1.5",
            f"{switched:.2f} / {kept:.1f}", switched <= 1.05)  # fmt: skip
        assert switched <= 1.05
        assert kept > 1.5


@pytest.mark.parametrize("period", [0.1, 0.35, 0.7])
@pytest.mark.parametrize("name", ["base", "S-turn"])
def test_dead_reckoning(name, period, row):
    """C8: exact start and inputs, no azimuth measured, trapezoid rule: at most 0.2 deg."""
    flight = FLIGHTS[name]
    rows, measurements = observed(flight, period, DEGREE, 1, REPORT)
    names = [channel.split(".")[1] for channel in MEASURED]
    z = np.stack([flight[channel][rows] for channel in names], axis=1)[..., None]
    z[:, 1] = np.nan
    blind = Measurements(MEASURED, measurements.time, measurements.time, z, 1e-6 * measurements.R)
    exact = prior_of(flight, POLAR, DEGREE, 1, REPORT)
    start = np.array([flight[channel.removeprefix("radar.")][0] for channel in POLAR.channels])[:, None]
    found = [
        epoch.estimate.mean[2, 0] - flight["azimuth"][rows[epoch.row]]
        for epoch in follow(POLAR, blind, Gaussian(start, exact.cov), start=0.0)
    ]
    worst = np.abs(found).max() / DEGREE
    row(f"dead reckoning, {name}, {period:g} s: largest error deg", "<= 0.2", f"{worst:.3f}", worst <= 0.2)
    assert worst <= 0.2
