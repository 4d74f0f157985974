"""ADS-B against what recorded tables of it show: ages of position and velocity, gaps, altitude by pressure."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from aircraft.air import Air
from aircraft.state import AircraftState
from sim.observation.sensors.adsb import Adsb
from sim.randomness import Streams

DRAWS, ROWS = 400, 60
SPEED = 100.0  # m/s
COURSE = math.radians(60.0)


def rows(sensor, climb=0.0):
    """(rows, channels, draws) of straight flight, their covariances, and the truth at the stamps."""
    north, east = SPEED * math.cos(COURSE), SPEED * math.sin(COURSE)
    still = AircraftState(*(0.0,) * len(AircraftState._fields))
    moving = still._replace(velocity_north=north, velocity_east=east, velocity_up=climb)
    states = [
        moving._replace(time=t, north=north * t, east=east * t, height=500.0 + climb * t)
        for t in np.arange(0.0, ROWS + 0.5, 0.5).tolist()
    ]
    state, looks = sensor.begin(0.0, Streams(7, 0, DRAWS, "adsb")), []
    for before, after in pairwise(states):
        state, seen = sensor.step(state, before, after)
        looks += seen
    exact = np.stack([sensor.truth(one) for one in states[2::2]])
    return np.stack([look.z for look in looks]), np.stack([look.R for look in looks]), exact


def test_an_error_without_stale_rows_is_as_stated_and_lies_along_the_track():
    sensor = Adsb(stale_share=0.0, gap_share=0.0)
    z, R, exact = rows(sensor)
    error = z[:, :2] - exact[:, :2, None]
    along = math.cos(COURSE) * error[:, 0] + math.sin(COURSE) * error[:, 1]
    across = math.cos(COURSE) * error[:, 1] - math.sin(COURSE) * error[:, 0]
    assert along.std() == pytest.approx(math.hypot(0.2 * SPEED, 2.0), rel=0.03)  # 4 standard errors of 24,000
    assert across.std() == pytest.approx(2.0, rel=0.03)
    inverse = np.linalg.inv(np.moveaxis(R[:, :2, :2], -1, 1))
    normalised = np.einsum("kin,knij,kjn->kn", error, inverse, error)
    # the direction is that of a measured velocity, wrong by 0.3 / 100 rad: 0.06 m of 20 across a sigma of 2
    assert normalised.mean() == pytest.approx(2.0, rel=0.03)


def test_the_stated_error_counts_rows_that_repeat_the_one_before():
    sensor = Adsb(gap_share=0.0, stale_share=0.2)
    z, R, exact = rows(sensor)
    error = z[10:, :2] - exact[10:, :2, None]
    stated = np.einsum("kiin->kin", R[10:, :2, :2]).sum(axis=1)
    assert (error**2).sum(axis=1).mean() == pytest.approx(stated.mean(), rel=0.05)  # 24,000 rows, few of them long runs


def test_shares_are_those_of_the_fields():
    z, _, _ = rows(Adsb(gap_share=0.0))
    repeated = (np.diff(z[:, 0], axis=0) == 0.0) & (np.diff(z[:, 1], axis=0) == 0.0)
    assert repeated.mean() == pytest.approx(0.03, abs=0.005)  # 4 standard errors
    held = np.diff(z[:, 3], axis=0) == 0.0
    assert held.mean() == pytest.approx(1.0 - 1.0 / 2.5, abs=0.015)
    z, _, _ = rows(Adsb(gap_share=0.1, gap_length=3.0))
    silent = np.isnan(z)
    assert (silent.all(axis=1) == silent.any(axis=1)).all()
    gone = silent[30:, 0]
    assert gone.mean() == pytest.approx(0.1, abs=0.02)
    assert (gone[1:] & gone[:-1]).sum() / gone[:-1].sum() == pytest.approx(1.0 - 1.0 / 3.0, abs=0.05)


def test_the_altitude_is_by_pressure_and_in_steps():
    """On a day of 1030 hPa it is 27 ft for each hPa lower, as pilots reckon near the ground."""
    plain, high = (rows(Adsb(air=Air(qnh=qnh), gap_share=0.0))[0][:, 2] for qnh in (101_325.0, 103_000.0))
    assert (plain - high).mean() / 0.3048 == pytest.approx(16.75 * 27.0, rel=0.03)
    steps = high / (25.0 * 0.3048)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_a_held_velocity_is_that_of_an_earlier_row():
    z, _, exact = rows(Adsb(gap_share=0.0, velocity_sigma=1e-3), climb=-3.0)
    assert np.abs(z[:, 3] - SPEED).max() < 0.01
    assert np.abs(z[:, 4] - exact[:, 4, None]).max() < 1e-3
    step = 64.0 * 0.3048 / 60.0
    assert set(np.unique(np.round(z[:, 5] / step).astype(int))) == {round(-3.0 / step)}


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"stale_share": 0.95}, "at most 0.9"),
        ({"velocity_period": 0.5}, "velocity_period"),
        ({"stamp_sigma": -0.1}, "stamp_sigma"),
        ({"altitude_step": 10.0}, "25 ft or 100 ft"),
    ],
)
def test_what_no_receiver_has_is_refused(fields, words):
    with pytest.raises(ValueError, match=words):
        Adsb(**fields)
