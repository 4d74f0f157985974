"""The ledger's rows on Glistin and Panasyuk: directions of the axes, flights of one length."""

from __future__ import annotations

import numpy as np
import pytest

from sim.claims.papers.glistin.cases import (
    AXES,
    COARSE,
    CONDITIONS,
    JSBSIM,
    MEASURED,
    RADAR,
    SETTLED,
    built,
    case,
    errors,
    turned,
)
from sim.claims.papers.glistin.experiment import ratio
from sim.claims.papers.glistin.tuning import KINDS, TUNED
from tracking.trackers.load_factor import LoadFactor

SEED = 4


def among_the_first(data, scans):
    """The start of a case: the turn is in it."""
    seen = data.measurements
    few = type(seen)(seen.channels, seen.time[:scans], seen.arrival[:scans], seen.z[:scans], seen.R[:scans])
    return data._replace(measurements=few, azimuth=data.azimuth[:scans], turning=data.turning[:scans])


@pytest.fixture(scope="module")
def base_turn():
    return among_the_first(case(SEED, 3, "base turn", COARSE), 90)


def found(data, formula, zero):
    tuned = TUNED["base turn", COARSE]["corrected" if formula == "corrected" else "published"]
    return errors(LoadFactor(MEASURED, zero, azimuth_acceleration=formula, **tuned), data, True)


def test_the_published_formula_depends_on_the_direction_of_its_axes_and_the_corrected_does_not(base_turn):
    right = np.radians(90.0)
    assert found(base_turn, "corrected", right) == pytest.approx(found(base_turn, "corrected", 0.0), abs=1e-9)
    published = found(base_turn, "published", 0.0)
    assert np.abs(found(base_turn, "published", right) - published).max() > 0.05
    # both components change their signs together
    assert found(base_turn, "published", np.pi) == pytest.approx(published, abs=1e-9)


def test_a_turned_radar_sees_the_same_from_its_own_zero(base_turn):
    other = turned(base_turn, 0.5)
    azimuth = RADAR.index("azimuth")
    assert other.measurements.z[:, azimuth] + 0.5 == pytest.approx(base_turn.measurements.z[:, azimuth])
    assert other.azimuth + 0.5 == pytest.approx(base_turn.azimuth)
    unmoved = [row for row in range(9) if row != azimuth]
    assert np.array_equal(other.measurements.z[:, unmoved], base_turn.measurements.z[:, unmoved], equal_nan=True)


def test_every_direction_is_tuned_for_itself():
    for flight in ("base turn", JSBSIM):
        for condition in CONDITIONS:
            assert set(KINDS) == set(TUNED[flight, condition])
    assert len({tuple(TUNED["base turn", COARSE][kind].values()) for kind in AXES}) == len(AXES)
    for kind, zero in AXES.items():
        tracker = built(kind, TUNED["base turn", COARSE][kind])
        assert (tracker.zero_azimuth, tracker.azimuth_acceleration) == (zero, "published")


def test_parts_of_flights_that_turn_at_different_times(base_turn):
    scans, runs = base_turn.turning.shape
    turning = np.zeros((scans, runs), dtype=bool)
    for run, first in enumerate((30, 40, 50)):
        turning[first : first + 20, run] = True
    data = base_turn._replace(turning=turning)
    rows = np.arange(scans)[:, None]
    first, last = turning.argmax(axis=0), turning.argmax(axis=0) + 19
    one = {"before": (rows < first) & (rows >= SETTLED), "turn": turning, "behind": rows > last}
    for part, chosen in one.items():
        plain = np.where(chosen, 4.0, 1e6)
        assert ratio(data, part, plain, np.ones_like(plain), runs).value == pytest.approx(2.0)
    everything = np.where(rows >= SETTLED, 4.0, 1e6) * np.ones(runs)
    assert ratio(data, "all", everything, np.ones_like(everything), runs).value == pytest.approx(2.0)
