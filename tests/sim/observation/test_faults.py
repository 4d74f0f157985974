"""Sensors that err more than they state: the same noise, larger, in a record and in the loop."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import sim
from aircraft.state import AircraftState
from sim.cli.explain import explain
from sim.errors import ScenarioError
from sim.estimation.navigator import navigator
from sim.observation.faults import faulty, in_words
from sim.observation.record import observe
from sim.observation.sensor import Look
from sim.observation.sensors.precision_radar import PrecisionRadar
from sim.observation.sensors.surveillance_radar import SurveillanceRadar
from sim.scenario.reading import read
from sim.scenario.tables import SensorFault
from tests.capture import CAPTURE
from tracking.gaussian import merge
from tracking.measurement import wrap

FAULTS = (SensorFault(30.0, "radar", 2.0), SensorFault(60.0, "radar", 1.0))


@pytest.fixture
def westwards(make_flight):
    """Across the line behind a radar."""
    time = np.arange(0.0, 90.0, 1 / 30)
    return make_flight(time, ["final"] * len(time), north=np.full(len(time), -9000.0), east=3500.0 - 70.0 * time)


@pytest.mark.parametrize(
    "sensor",
    [
        SurveillanceRadar(period=1.0, position=(0.0, 0.0, 10.0)),
        PrecisionRadar(sector=2 * np.pi, clutter=2.0, detection=0.8),
    ],
)
def test_errors_are_scaled_between_the_times_and_bit_equal_outside(sensor, westwards):
    stated, faulty = (observe(westwards, {"radar": sensor}, 3, draws=20, faults=f)["radar"] for f in ((), FAULTS))
    during = (stated.time >= 30.0) & (stated.time < 60.0)
    assert during.sum() > 25
    np.testing.assert_array_equal(faulty.z[~during], stated.z[~during])
    np.testing.assert_array_equal(faulty.R, stated.R)
    s = westwards.state
    exact = sensor.truth(AircraftState(*(np.interp(stated.time, s.time, column) for column in s))).T[..., None]
    once, twice = stated.z - exact, faulty.z - exact
    once[:, 1], twice[:, 1] = wrap(once[:, 1]), wrap(twice[:, 1])
    np.testing.assert_allclose(twice[during], 2.0 * once[during], rtol=1e-6, atol=1e-6)
    if stated.candidates is not None:
        np.testing.assert_array_equal(faulty.candidates[:, 0], faulty.z)
        np.testing.assert_array_equal(faulty.candidates[:, 1:], stated.candidates[:, 1:])


def test_the_error_of_an_angle_is_the_shorter_way_round(westwards):
    """A sensor may say 359 degrees as -1: 0.01 rad beyond 180 degrees is no error of almost a turn."""
    radar = SurveillanceRadar(position=(0.0, 0.0, 10.0))
    before, after = (AircraftState(*(float(column[i]) for column in westwards.state)) for i in (1500, 1501))
    slant, azimuth = radar.truth(after)
    z = np.array([[slant + 50.0], [azimuth + 0.01 - 2 * np.pi]])
    made = faulty(
        Look(after.time, after.time, z, radar.covariance()), radar, [SensorFault(0.0, "x", 3.0)], before, after
    )
    np.testing.assert_allclose(made.z[:, 0], (slant + 150.0, azimuth + 0.03), rtol=1e-9)


def test_a_fault_belongs_to_its_sensor(westwards):
    sensors = {"radar": SurveillanceRadar(), "other": SurveillanceRadar()}
    stated, faulty = (observe(westwards, sensors, 3, faults=f) for f in ((), FAULTS))
    np.testing.assert_array_equal(faulty["other"].z, stated["other"].z)
    assert not np.array_equal(faulty["radar"].z, stated["radar"].z)


FLOWN = {
    **CAPTURE,
    "aircraft": {"model": "point_mass"},
    "autopilot": {"navigation": "mine"},
    "until_s": 8,
    "sensors": {"radar": {"kind": "surveillance_radar", "period_s": 1}},
    "trackers": {"mine": {"kind": "imm"}},
}


def test_in_the_loop_a_sensor_errs_as_on_the_record():
    """The aircraft flies on the tracker: the same until the fault, then by the looks that the record has too."""
    faults = [{"at_s": 4, "sensor": "radar", "error_factor": 30}]
    stated, faulty = (sim.run({**FLOWN, "sensor_faults": given}) for given in ([], faults))
    before = stated.flight.time < 4.0
    np.testing.assert_array_equal(faulty.flight.state.east[before], stated.flight.state.east[before])
    assert np.abs(faulty.flight.state.bank - stated.flight.state.bank).max() > 0.01
    records = [AircraftState(*row) for row in np.column_stack(faulty.flight.state).tolist()]
    own = navigator(faulty.prepared, 0)
    state, _ = own.begin(records[0])
    for first, last in pairwise(records):
        state, _ = own.step(state, first, last)
    followed = faulty.tracks["mine"].track
    assert state.time == followed.time[-1]
    seen = merge(own.tracker.estimate(state.tracker)).mean[:, 0]
    np.testing.assert_allclose(seen, followed.mean[-1, :, 0], atol=0.1)  # priors from half a second and from a record
    assert np.abs(followed.mean[-1, :, 0] - stated.tracks["mine"].track.mean[-1, :, 0]).max() > 50.0


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ({"at_s": 5, "sensor": "rada", "error_factor": 2}, "no sensor 'rada'; did you mean 'radar'"),
        (
            {"at_s": -5, "sensor": "radar", "error_factor": 2},
            r"at_s: must be at least 0: a flight begins at 0 s \(got -5\)",
        ),
        ({"at_s": 5, "sensor": "radar", "error_factor": 0}, r"error_factor: must be above 0 \(got 0\)"),
        ({"at_s": 5, "sensor": "radar", "error_factor": float("nan")}, "error_factor"),
        ({"at_s": 5, "sensor": "radar"}, "error_factor"),
        ({"at_s": 5, "sensor": "radar", "error_factr": 2, "error_factor": 2}, "error_factr"),
    ],
)
def test_a_fault_that_cannot_be_is_refused_in_one_sentence(fault, said):
    with pytest.raises(ScenarioError, match=said) as caught:
        read({**FLOWN, "sensor_faults": [fault]})
    assert str(caught.value).count("\n") == 0
    assert "[[sensor_faults]]" in str(caught.value)
    assert "entry 0" in str(caught.value)


def test_explain_and_events_say_what_no_tracker_is_told():
    told = explain(read({**FLOWN, "sensor_faults": [{"at_s": 20, "sensor": "radar", "error_factor": 1.5}]}))
    assert "radar errs 1.5 times as much as it states" in told
    assert in_words(FAULTS[1]) == "radar errs as it states"
