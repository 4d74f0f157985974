"""Why a tracker errs, read off the flight: what acted on the aircraft that the tracker's model may not hold.

This is said of a flight that is over, so it may look at the truth, which no tracker sees.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from autopilot.mode import Mode
from sim.flight.departures import in_words
from sim.flight.record import Flight
from sim.metrics.conformance import MISMATCHED
from sim.reporting.figures.deviations import acting_limits
from sim.reporting.text.labels import joined, number, words
from sim.reporting.tracker_figures.error_curves import FIRST
from sim.reporting.tracker_figures.parting import Parting, parting
from tracking.consistency import LOST_EPOCHS
from tracking.motion import CARTESIAN
from tracking.track import Track

SHORT = 1.0  # s; a limit that acts no longer explains nothing
LOOKS = 2  # before the first that finds the aircraft outside: what acts needs a while to show
ONSET = 20.0  # s, after the parting of two trackers, in which its cause is looked for
FOLLOWS = np.radians(0.5)  # between the bank command and that of the law: what rounding and a step of lag leave
BANKED = np.radians(5.0)  # from which on a flight is no longer called straight
CHANGING = 0.1  # m/s2, from which on a speed is no longer called steady


class Flown(NamedTuple):
    """A flight with the law that flew it and those that watched."""

    scenario: Any
    law: Mode
    flight: Flight
    tracked: dict[str, Any]  # name -> Tracked


class Loss(NamedTuple):
    """When the first draw of a tracker was lost on a flight, where it had gone astray, and what acted there."""

    time: float  # s
    astray: float  # s, the first of the looks in a row for which it counts as lost
    phase: str  # in words, then
    cause: str  # a clause


class Apart(NamedTuple):
    """Where two trackers of a flight part, and what acted there."""

    stretch: Parting
    phase: str  # in words
    cause: str  # a clause


def loss(flown: Flown, name: str, lost_time: float | None) -> Loss | None:
    """Why a tracker was lost on a flight, ``lost_time`` (s) being that of metrics.json; None where it was not.

    It is lost at the last of several looks in a row that find the aircraft outside its ellipse; what put it there acted
    before the first of them.
    """
    if lost_time is None or name not in flown.tracked:
        return None
    epochs = flown.tracked[name].track.time
    last = int(np.searchsorted(epochs, lost_time))
    first = max(last - LOST_EPOCHS + 1, 0)
    since, astray = float(epochs[max(first - 1 - LOOKS, 0)]), float(epochs[first])
    return Loss(lost_time, astray, _phase(flown.flight, astray), cause(flown, name, since, astray))


def apart(flown: Flown, of: str, against: str) -> Apart | None:
    """Where two trackers part, and what of the flight the worse one's model may not hold; None where they do not."""
    one, other = (flown.tracked[name].curves if name in flown.tracked else None for name in (of, against))
    if one is None or other is None:
        return None
    channel = next((c for c in (*FIRST, *one.channels) if c in one.channels and c in other.channels), None)
    stretch = None if channel is None else parting(one, other, channel)
    if channel is None or stretch is None:
        return None
    during = (one.time >= stretch.start) & (one.time <= stretch.end)
    rival = np.interp(one.time, other.time, other.channels[channel].rmse)
    worse = of if np.nansum(np.log(one.channels[channel].rmse[during] / rival[during])) > 0.0 else against
    until = min(stretch.start + ONSET, stretch.end)
    return Apart(stretch, _phase(flown.flight, stretch.start), cause(flown, worse, stretch.start, until))


def cause(flown: Flown, name: str, since: float, until: float) -> str:
    """What acted on the aircraft between two instants, s, that a tracker may not know: a clause.

    Another law than the tracker assumes, else a bank that does not follow the law, else limits of the law, else a turn
    that the tracker flies too early, else a change of speed. Of a tracker that assumes no law: the turn, else the
    change of speed.
    """
    scenario, law, flight, tracked = flown
    law_from = tracked[name].law_from
    during = (flight.time >= since) & (flight.time <= until)
    if not during.any():
        return "the record has nothing of it"
    if law_from is None or flight.is_recorded:  # nobody recorded which law was flown
        return _manoeuvre(flight, during)
    left = [one for one in scenario.departures if one.at <= until]
    if left:
        return f"another law is flown than it assumes ({in_words(max(left, key=lambda one: one.at))})"
    if law_from == MISMATCHED:
        return "it assumes another law than the one that flies"
    if scenario.autopilot.navigation == "truth":  # else the law is flown on an estimate, which may say something else
        off = np.abs(flight.command.bank - law(flight.deviation)) > FOLLOWS
        if np.mean(off[during]) > 0.5:
            return "the law is not engaged there, another bank is commanded than it asks for"
    step = float(np.median(np.diff(flight.time[during]))) if during.sum() > 1 else 0.0
    acting = acting_limits(flight, law, float(law.bank_limit))
    lasting = {name: float(np.sum(mask[during])) * step for name, mask in acting.items()}
    limits = [words(name) for name in sorted(lasting, key=lambda name: -lasting[name]) if lasting[name] >= SHORT]
    if limits:
        return f"the law is at its {joined(limits)} limit{'s' if limits[1:] else ''} there"
    if _turns_early(flown, tracked[name].track, since, until):
        return "its estimate turns onto the next leg before the aircraft does"
    changing = _change_of_speed(flight, during)
    if changing:
        return f"the law is flown there within its limits, but {changing}"
    return "the law is flown there within its limits, so its model errs otherwise"


def _turns_early(flown: Flown, track: Track, since: float, until: float) -> bool:
    """Whether the route, asked by the estimate of any draw, gives the next leg while the aircraft flies its own."""
    if not {*CARTESIAN} <= {*track.channels}:
        return False
    flight, looks = flown.flight, np.flatnonzero((track.time >= since) & (track.time <= until))
    north, north_rate, east, east_rate = (track.mean[looks, track.channels.index(name)] for name in CARTESIAN)
    leg = flight.leg[np.clip(np.searchsorted(flight.time, track.time[looks]), 0, len(flight.time) - 1), None]
    leg = np.broadcast_to(leg, north.shape)
    taken = flight.route.sequence(leg, (north, east), (north_rate, east_rate), float(flown.law.bank_limit))
    return bool(np.any(taken > leg))


def _manoeuvre(flight: Flight, during: np.ndarray) -> str:
    """What a model of uniform motion does not hold."""
    bank = float(np.max(np.abs(flight.state.bank[during])))
    if bank > BANKED:
        return f"the aircraft turns there, banked up to {number(float(np.degrees(bank)), 0)} deg"
    return _change_of_speed(flight, during) or "the aircraft flies straight there at a steady speed"


def _change_of_speed(flight: Flight, during: np.ndarray) -> str:
    speed, time = flight.state.ground_speed[during], flight.time[during]
    change = float(speed[-1] - speed[0]) / max(float(time[-1] - time[0]), 1e-6)
    if abs(change) <= CHANGING:
        return ""
    return f"the aircraft {'slows down' if change < 0.0 else 'speeds up'} there at {number(abs(change), 1)} m/s²"


def _phase(flight: Flight, time: float) -> str:
    at = min(int(np.searchsorted(flight.time, time)), len(flight.time) - 1)
    return words(flight.phases[int(flight.phase[at])])
