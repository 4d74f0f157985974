"""Draws go through a tracker in parts: what memory needs, and no byte of the result.

Where all parts are whole vectors of the processor: numpy multiplies and adds at once within a vector and one after the
other in what is left of an array, which rounds its last digit otherwise.
"""

from __future__ import annotations

import numpy as np
import pytest

from sim.estimation import tracking_run
from sim.estimation.many_draws.filed_array import FiledArray
from sim.estimation.tracked import watch
from sim.experiment import fly
from sim.flight.preparation import prepare
from sim.observation.record import observe
from sim.scenario.reading import read
from tests.capture import CAPTURE

DRAWS = 96  # more than look ahead
TRACKERS = {
    "plain": {"kind": "kalman", "sensors": ["radar"]},
    "pair": {"kind": "linear_feedback", "sensors": ["radar"]},
    "pair_told_wrong": {"kind": "linear_feedback", "sensors": ["radar"], "law": {"k1_factor": 1.5}},
    "limited": {"kind": "saturated_control"},
    "many": {"kind": "imm", "sensors": ["radar"]},
    "handed": {"kind": "imm", "handover": "plain"},
}
SENSORS = {
    "radar": {"kind": "surveillance_radar"},
    "precision": {
        "kind": "precision_radar",
        "sector_deg": 360,
        "coverage_m": 100000,
        "period_s": 4,
    },  # its R differs from draw to draw
}


@pytest.fixture(scope="module")
def flown():
    tables = {**CAPTURE, "aircraft": {"model": "point_mass"}, "until_s": 90, "draws": DRAWS}
    prepared = prepare(read({**tables, "sensors": SENSORS, "trackers": TRACKERS}))
    flight = fly(prepared)
    return prepared, flight, observe(flight, prepared.scenario.sensors, 1, 0, DRAWS)


@pytest.fixture(scope="module")
def whole(flown):
    return tracking_run.track(*flown, {})


@pytest.mark.parametrize("size", [32, 64])
def test_parts_leave_the_same_bytes(flown, whole, monkeypatch, size):
    monkeypatch.setattr(watch, "TOGETHER", size)
    tracks, figures = tracking_run.track(*flown, {})
    assert all(isinstance(one.track.mean, FiledArray) for one in tracks.values())
    assert figures == whole[1]
    for name in TRACKERS:
        part, alone = tracks[name].track._asdict(), whole[0][name].track._asdict()
        # a channel that one run missed is left out, or weighed with nothing, by whether other runs heard it
        np.testing.assert_allclose(part.pop("log_likelihood"), alone.pop("log_likelihood"), rtol=1e-14)
        assert part.pop("channels") == alone.pop("channels")
        for field, values in part.items():
            np.testing.assert_array_equal(np.asarray(values), alone[field])


def test_a_last_part_of_one_draw_is_that_draw(flown, whole, monkeypatch):
    """An array of one run looks like one that all runs share; vectors are not whole here, so digits may differ."""
    monkeypatch.setattr(watch, "TOGETHER", DRAWS - 1)
    tracks, _ = tracking_run.track(*flown, {})
    for name in TRACKERS:
        part, alone = tracks[name].track, whole[0][name].track
        np.testing.assert_allclose(np.asarray(part.mean), alone.mean, rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(np.asarray(part.cov), alone.cov, rtol=1e-5, atol=1e-9)  # single precision
