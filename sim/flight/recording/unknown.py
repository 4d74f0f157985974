"""A flight of which nothing is known but when plots of it were made: its motion and its commands are NaN."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aircraft.state import AircraftState, Command
from autopilot.route import Route
from sim.flight.record import UNKNOWN, Flight

NOTHING_KNOWN = (
    "names no file, so there is no flight to see: name one, or give the plots that were made of it, "
    '[sensors.NAME] kind = "recorded"'
)
REASON = "no truth: figures from the plots alone"
FINAL_TAKEN = "trackers that follow one, and ranges without a height, take the extended centreline and its glide path"


def unknown_flight(route: Route, sensors: dict[str, Any]) -> Flight:
    """The flight behind recorded plots, from the whole second before the first to the last of them.

    Its record has two instants, the begin and the end. Where the stamps of any sensor are dates, its time 0 is the
    begin; otherwise its clock is that of the stamps.

    Parameters
    ----------
    route : as it is told to trackers that know one
    sensors : that recorded their looks

    Raises ``ValueError`` where there is no sensor, or one that recorded nothing.
    """
    if not sensors or any(one.recording is None for one in sensors.values()):
        raise ValueError(NOTHING_KNOWN)
    dates = [one.recording.first for one in sensors.values() if one.recording.dated]
    utc = float(_second_before(min(dates))) if dates else None
    found = [one.dated(utc).recording for one in sensors.values()]
    begin = float(_second_before(min(one.first for one in found)))
    end = max(one.last for one in found)
    time = np.array((begin, end))
    unknown = np.full(2, np.nan)
    return Flight(
        route,
        AircraftState(*(unknown for _ in AircraftState._fields))._replace(time=time),
        Command(*(unknown for _ in Command._fields)),
        np.zeros(2, int),
        np.zeros(2, int),
        (UNKNOWN,),
        (),
        UNKNOWN,
        REASON,
        utc=utc,
    )


def _second_before(time: float) -> int:
    return math.ceil(time) - 1
