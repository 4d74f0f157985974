"""Tracks and errors as they come, some draws after others, to the end of the flight and after it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sim.estimation.many_draws.collected import CollectedTrack
from sim.estimation.setup import height_profile
from sim.estimation.tracked.watch import Watch, between
from sim.flight.record import Flight
from sim.metrics.comparison import Compared
from sim.metrics.tracker import looked_for, plot_errors, tracker_errors
from tracking.track import Measurements, Track

Errors = dict[str, Compared]
"""By comparison channel."""


class Found(NamedTuple):
    """What the parts of the draws gave for one tracker."""

    track: CollectedTrack  # to the end of the flight
    errors: list[Errors]  # of each part
    rolling: CollectedTrack  # after the end of the flight
    rolling_errors: list[Errors]


def collect(found: Found, flight: Flight, sensors: dict[str, Any], made: Track) -> None:
    """Take in the track of some draws, with its errors where a truth is known."""
    if not flight.known:
        found.track.add(made)
        return
    before, rolling = _parted(made, float(flight.time[-1]))
    for part, whole, into, errors in (
        (before, flight, found.track, found.errors),
        (rolling, flight.whole, found.rolling, found.rolling_errors),
    ):
        if part is not None:
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
                errors.append(tracker_errors(whole, sensors, part, {}).estimates)
                # covariances are most of a run's memory, and only maps still read them
                into.add(part._replace(cov=part.cov.astype(np.float32)))


def errors_of_plots(
    watch: Watch, record: Measurements, sensors: dict[str, Any], errors: Errors, rolling: Errors
) -> tuple[Errors, Errors]:
    """Errors of what trackers were given, to the end of the flight and after it, as far as theirs are compared."""
    flight, chart = watch.flight, height_profile(watch.prepared)
    end = float(flight.time[-1])
    until, after = between(record, -math.inf, end), between(record, math.nextafter(end, math.inf), math.inf)
    plots = looked_for(errors, plot_errors(flight, sensors, chart, until))
    return plots, looked_for(rolling, plot_errors(flight.whole, sensors, chart, after)) if rolling else {}


def _parted(track: Track, end: float) -> tuple[Track, Track | None]:
    """A track to the end of the flight, and after it; None where it has nothing after it."""
    if not len(track.time) or track.time[-1] <= end:
        return track, None
    count = int(np.searchsorted(track.time, end, side="right"))
    before, after = ([None if part is None else part[side] for part in track[1:]] for side in (
        slice(None, count), slice(count, None)
    ))  # fmt: skip
    return Track(track.channels, *before), Track(track.channels, *after)
