"""globe(): a run as a KMZ, in which a globe shows the flight and what each tracker took for it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from aircraft.runway import Runway as Place
from sim.errors import OutputError
from sim.interchange.views.kmz import Strip, Track, kmz_of
from sim.reporting.figures import style
from sim.reporting.figures.plan_view import RUNWAY_LENGTH
from sim.reporting.replay import nose
from sim.reporting.tracker_figures.error_curves import looks_of
from sim.results.estimates import Estimated, estimated, refuse_draw
from sim.results.result import Result

STEP = 0.25  # s between two places that are shown: half a second of a turn is off its chord by a few centimetres
THICK, THIN = 3.0, 2.0  # pixels, of the flight and of a tracker
TRUTH, RUNWAY = "truth", "runway"


class Globe(NamedTuple):
    """What a globe shows of a run."""

    kmz: bytes
    shown: tuple[str, ...]  # names of the tracks
    left: tuple[str, ...]  # what could not be shown, in sentences


def globe(result: Result, *, begins: float, draw: int = 0) -> Globe:
    """The KMZ of a result: the truth, a track for each tracker in its colour of the report, and the runway.

    A tracker that estimates no height is shown at that of the flight. It heads where its velocity points.

    Parameters
    ----------
    begins : s since 1970 when the flight begins; a flight with a date has its own
    draw : of the noise, whose estimates are shown

    Raises ``OutputError`` in one sentence for a draw that the run has not, and where there is nothing to show.
    """
    if result.tracks:
        refuse_draw(draw, result.scenario.draws)
    begins = begins if result.flight.utc is None else result.flight.utc
    left: list[str] = []
    tracks = [*_truth(result, begins), *_trackers(result, begins, draw, left)]
    if not tracks:
        raise OutputError(f"there is nothing to show on a globe: {left[0] if left else 'the run has no tracker'}")
    return Globe(kmz_of(result.scenario.name, _strip(result), tracks), tuple(one.name for one in tracks), tuple(left))


def _strip(result: Result) -> Strip:
    runway = result.scenario.runway
    north, east = runway.to_local(RUNWAY_LENGTH * 1e3, 0.0)
    latitude, longitude = _threshold(result).geodetic(north, east)
    return Strip(RUNWAY, (runway.latitude, float(latitude)), (runway.longitude, float(longitude)))


def _threshold(result: Result) -> Place:
    runway = result.scenario.runway
    return Place(runway.latitude, runway.longitude, runway.elevation)


def _on_earth(result: Result, place: np.ndarray, height: np.ndarray) -> np.ndarray:
    """(3, k) latitude, longitude and metres above the sea of places (2, k) north and east."""
    north, east = place
    latitude, longitude = _threshold(result).geodetic(north, east, height)
    return np.array((latitude, longitude, result.scenario.runway.elevation + height))


def _thinned(time: np.ndarray) -> np.ndarray:
    """Indices of what is shown: the first of each `STEP`, and the last."""
    first = np.flatnonzero(np.diff(np.floor((time - time[0]) / STEP + 1e-6), prepend=-1.0))
    return np.union1d(first, len(time) - 1)


def _truth(result: Result, begins: float) -> Iterator[Track]:
    """The flight and its roll-out, where a true motion is known."""
    flight = result.flight.whole
    if not flight.known:
        return
    few = _thinned(flight.time)
    state = flight.state
    place = _on_earth(result, np.array((state.north[few], state.east[few])), state.height[few])
    attitude = np.array((nose(flight), state.pitch, state.bank))[:, few]
    yield Track(TRUTH, style.BLACK, THICK, f"flown: {flight.outcome}", begins + flight.time[few], place, attitude)


def _trackers(result: Result, begins: float, draw: int, left: list[str]) -> Iterator[Track]:
    """A track for each tracker; ``left`` is told which cannot be shown."""
    looks = looks_of(result.scenario, dict(result.tracks))
    for name, one in result.tracks.items():
        found = estimated(result, one, draw)
        if found is None:
            left.append(f"tracker '{name}' estimates no place on the ground plane")
            continue
        if not len(found.time):
            left.append(f"tracker '{name}' has no estimate of a place where an aircraft is")
            continue
        if found.lost:
            left.append(f"tracker '{name}': {found.lost} estimates of places where no aircraft is")
        yield _tracker(result, name, looks[name]["colour"], found, _thinned(found.time), begins, draw)


def _tracker(
    result: Result, name: str, colour: str, found: Estimated, few: np.ndarray, begins: float, draw: int
) -> Track:
    time, course = found.time[few], found.course[few]
    height, told = _height(result, found)
    attitude = np.array((course, np.zeros(len(few)), np.zeros(len(few))))
    place = _on_earth(result, found.place[:, few], height[few])
    return Track(name, colour, THIN, f"estimates of draw {draw}, {told}", begins + time, place, attitude)


def _height(result: Result, found: Estimated) -> tuple[np.ndarray, str]:
    """(k,) m above the threshold at which a tracker is shown, and why there."""
    if found.height is not None:
        return found.height, "at the height that it estimates"
    if not result.flight.known:
        return np.zeros(len(found.time)), "at the height of the threshold"
    state = result.flight.whole.state
    return np.interp(found.time, state.time, state.height), "at the height of the flight"
