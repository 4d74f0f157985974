"""A recorded track against the formula that it was made by: place, bank, phases, and what was wrong with its rows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aircraft.air import Air
from aircraft.runway import Runway as Place
from sim.errors import ScenarioError
from sim.flight.recording.cleaning import LONGEST_GAP
from sim.flight.recording.flight import recorded_flight
from sim.flight.recording.smoothing import Path, WhiteJerk, resampled
from sim.interchange.track_record import TrackRecord
from sim.scenario.tables import Runway
from tests import recordings

RUNWAY = Runway(
    recordings.RUNWAY.latitude,
    recordings.RUNWAY.longitude,
    recordings.RUNWAY.elevation,
    recordings.RUNWAY.heading,
    glide_path=math.radians(3.0),
)


def made(time=None):
    """The track of the formula at times (k,) s."""
    time = np.arange(0.0, recordings.LENGTH) if time is None else time
    past, right, height, _, _ = recordings.motion(time)
    latitude, longitude = recordings.RUNWAY.geodetic(*RUNWAY.to_local(past, right), height)
    altitude = Air(RUNWAY.elevation).pressure_altitude(height)
    return TrackRecord("made", recordings.BEGUN + time, latitude, longitude, altitude)


def remarks(flight):
    return [event.detail for event in flight.events if event.name == "remark"]


@pytest.fixture(scope="module")
def flight():
    return recorded_flight(made(), RUNWAY)


def test_the_motion_is_that_of_the_formula(flight):
    past, right, height, _, bank = recordings.motion(flight.time)
    found = RUNWAY.from_local(flight.state.north, flight.state.east)
    assert math.sqrt(np.mean((found[0] - past) ** 2 + (found[1] - right) ** 2)) < 0.1
    assert math.sqrt(np.mean((flight.state.height - height) ** 2)) < 1.0
    off = np.degrees(flight.state.bank - bank)  # a bank that jumps is smoothed: it is off for a second or two
    assert np.median(np.abs(off)) < 0.01
    assert np.mean(np.abs(off) > 1.0) < 0.02
    assert flight.utc == recordings.BEGUN
    np.testing.assert_allclose(np.diff(flight.time), 1.0 / 30.0)


def test_phases_begin_where_the_formula_turns_descends_and_lands(flight):
    begins = {event.name: event.time for event in flight.events if event.name in flight.phases}
    arc = recordings.STRAIGHT / recordings.SPEED
    assert list(begins) == ["vectors", "capture", "established", "glide", "ground"]
    assert begins["capture"] == pytest.approx(arc, abs=3.0)
    assert arc < begins["established"] <= arc + recordings.RADIUS * recordings.ANGLE / recordings.SPEED
    foot = (recordings.LENGTH * recordings.SPEED - recordings.ROLL) / recordings.SPEED
    entry = foot - recordings.HEIGHT / math.tan(math.radians(3.0)) / recordings.SPEED
    assert begins["established"] < begins["glide"] == pytest.approx(entry, abs=5.0)
    assert begins["ground"] == pytest.approx(foot, abs=4.0)
    assert flight.outcome == "landed"
    assert flight.time[-1] == begins["ground"]  # what follows is the roll-out, which no approach is judged by
    assert flight.rollout.time[0] == pytest.approx(flight.time[-1] + 1 / 30)
    assert len(flight.whole.time) == len(flight.time) + len(flight.rollout.time)


def test_what_nobody_recorded_is_absent(flight):
    known = {"time", "north", "east", "height", "velocity_north", "velocity_east", "velocity_up", "bank"}
    state = flight.state._asdict()
    assert all(np.isfinite(state[name]).all() for name in known)
    assert all(np.isnan(column).all() for name, column in state.items() if name not in known)
    assert all(np.isnan(column).all() for column in flight.command)
    assert flight.is_recorded


def test_a_pressure_altitude_becomes_a_height_by_the_pressure_of_the_day():
    high = Air(RUNWAY.elevation, qnh=103000.0)
    time = np.arange(0.0, recordings.LENGTH)
    height = recordings.motion(time)[2]
    track = made()._replace(pressure_altitude=high.pressure_altitude(height))
    known, unknown = recorded_flight(track, RUNWAY, high), recorded_flight(track, RUNWAY)
    np.testing.assert_allclose(known.state.height[:3000], recordings.HEIGHT, atol=0.5)
    assert unknown.state.height[:3000].mean() == pytest.approx(recordings.HEIGHT - 140.0, abs=5.0)
    (told,) = remarks(unknown)
    assert "below it" in told
    assert "QNH of 1030 hPa would mend" in told
    assert remarks(known) == []


def test_stale_rows_repeated_stamps_and_wild_places_are_left_out_and_told(flight):
    track = made()
    latitude, longitude, time = track.latitude.copy(), track.longitude.copy(), track.time.copy()
    latitude[51:53], longitude[51:53] = latitude[50], longitude[50]  # stale
    time[100] = time[99]
    latitude[200] += 0.1  # 600 km
    latitude[300] += 2e-5  # 130 m: nothing wild for an aircraft, but for its neighbours
    found = recorded_flight(track._replace(latitude=latitude, longitude=longitude, time=time), RUNWAY)
    told = " ".join(remarks(found))
    assert "2 of 461 rows are stale" in told
    assert "1 of 461 rows repeat a time stamp" in told
    assert "1 of 461 rows lie where nothing flies to" in told
    assert "rows lie far off the line of their neighbours" in told
    for name in ("north", "east"):
        np.testing.assert_allclose(getattr(found.state, name), getattr(flight.state, name), atol=2.0)


def test_a_wild_first_row_does_not_move_the_date(flight):
    track = made()
    latitude = track.latitude.copy()
    latitude[0] += 1e-4  # 637 m
    found = recorded_flight(track._replace(latitude=latitude), RUNWAY)
    assert found.utc == recordings.BEGUN + 3.0
    np.testing.assert_allclose(found.state.north[:300], flight.state.north[90:390], atol=0.5)


def test_of_pieces_the_one_that_ends_nearest_the_threshold_is_the_flight():
    time = np.arange(0.0, recordings.LENGTH)
    kept = (time < 100.0) | (time >= 125.0)
    found = recorded_flight(made(time[kept]), RUNWAY)
    assert found.utc == recordings.BEGUN + 125.0
    assert "leave 2 pieces" in remarks(found)[0]
    short = (time < 100.0) | (time >= 115.0)
    assert recorded_flight(made(time[short]), RUNWAY).utc == recordings.BEGUN


def test_stamps_that_jitter_are_smoothed_along_and_not_across_the_track():
    generator = np.random.Generator(np.random.PCG64(5))
    track = made()
    found = recorded_flight(track._replace(time=track.time + 0.2 * generator.standard_normal(len(track.time))), RUNWAY)
    past, right, *_ = recordings.motion(found.time + found.utc - recordings.BEGUN)
    along, across = (
        a - b for a, b in zip(RUNWAY.from_local(found.state.north, found.state.east), (past, right), strict=True)
    )
    on_final = found.during(("established", "glide"))
    assert 0.1 * 15.0 < math.sqrt(np.mean(along[on_final] ** 2)) < 0.6 * 15.0  # 15 m by row
    assert math.sqrt(np.mean(across[on_final] ** 2)) < 0.5


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"pressure_altitude": None}, "has no altitude"),
        ({"latitude": np.full(461, np.nan)}, "none of its 461 rows has a time and a place"),
        ({"latitude": made().latitude + 0.3}, "never comes nearer to the threshold than 1... km"),
        ({"time": np.full(461, 1.77e9)}, "are no flight"),
        ({"height": made().pressure_altitude / 0.3048}, "as with m for ft"),
    ],
)
def test_what_is_no_flight_to_the_runway_is_one_sentence(changes, told):
    with pytest.raises(ScenarioError, match=told):
        recorded_flight(made()._replace(**changes), RUNWAY)


def test_another_runway_is_told():
    (told,) = remarks(recorded_flight(made(), Runway(RUNWAY.latitude + 0.002, RUNWAY.longitude, 300.0, RUNWAY.heading)))
    assert "never established" in told


def test_between_rows_the_motion_is_the_polynomial_through_both():
    """A motion that is a polynomial of fifth degree is found again, with its first two derivatives."""
    polynomial = np.polynomial.Polynomial([3.0, -2.0, 0.5, 0.3, -0.07, 0.01])
    time, between = np.array([0.0, 1.5, 4.0]), np.linspace(0.0, 4.0, 17)
    knots = [np.stack([one(time)] * 3) for one in (polynomial, polynomial.deriv(), polynomial.deriv(2))]
    found = resampled(Path(time, *knots), between)
    for part, one in zip(found[1:], (polynomial, polynomial.deriv(), polynomial.deriv(2)), strict=True):
        np.testing.assert_allclose(part, np.stack([one(between)] * 3), atol=1e-9)


def test_in_the_middle_of_the_longest_gap_a_place_is_known_to_seven_metres():
    """By the covariance of a motion whose place, velocity and acceleration are known at both ends."""
    F, Q, _ = WhiteJerk().transition(LONGEST_GAP / 2.0, None)
    F, Q = F[:3, :3], Q[:3, :3]
    both = np.linalg.inv(Q) + F.T @ np.linalg.inv(Q) @ F
    assert math.sqrt(np.linalg.inv(both)[0, 0]) == pytest.approx(7.0, abs=0.5)


@pytest.mark.parametrize("height", [0.0, 3000.0])
def test_places_of_the_runway_frame_are_found_again(height):
    north, east = np.array([0.0, 4e4, -2e4]), np.array([0.0, 1e4, -5e4])
    place = Place(math.radians(-70.0), math.radians(170.0), 250.0)
    np.testing.assert_allclose(place.local(*place.geodetic(north, east, height), height), (north, east), atol=1e-6)


def test_distances_in_the_runway_frame_are_those_through_the_earth():
    """Against the distance between two points of the ellipsoid, whose axes are a and b."""
    place, a, b = Place(math.radians(57.0)), 6378137.0, 6378137.0 * (1.0 - 1.0 / 298.257223563)
    course = np.radians(np.arange(0.0, 360.0, 7.0))
    latitude, longitude = place.geodetic(4e4 * np.cos(course), 4e4 * np.sin(course))

    def centred(latitude, longitude):
        reduced = np.arctan(b / a * np.tan(latitude))
        ring = a * np.cos(reduced)
        return np.array((ring * np.cos(longitude), ring * np.sin(longitude), b * np.sin(reduced)))

    straight = np.linalg.norm(centred(latitude, longitude) - centred(np.full(52, place.latitude), np.zeros(52)), axis=0)
    drop = 4e4**2 / (2.0 * 6.37e6)  # below the plane; half a per cent of it is 3 mm of distance
    np.testing.assert_allclose(np.sqrt(straight**2 - drop**2), 4e4, atol=0.01)
