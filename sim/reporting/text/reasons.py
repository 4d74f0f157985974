"""Why a tracker errs, read off the flight: what acted on the aircraft that the tracker's model may not hold.

This is said of a flight that is over, so it may look at the truth, which no tracker sees.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from autopilot.mode import Mode
from sim.flight.departures import in_words
from sim.flight.law_limits import acting_limits
from sim.flight.record import Flight
from sim.metrics.conformance import MISMATCHED
from sim.reporting.text.labels import joined, number, words
from sim.reporting.tracker_figures.error_curves import FIRST
from sim.reporting.tracker_figures.parting import Parting, parting
from tracking.consistency import LOST_EPOCHS

SHORT = 2.0  # s; a limit that acts no longer explains nothing
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
    """When and where the first draw of a tracker was lost on a flight, and what acted there."""

    time: float  # s
    phase: str  # in words
    cause: str  # a clause


class Apart(NamedTuple):
    """Where two trackers of a flight part, and what acted there."""

    stretch: Parting
    phase: str  # in words
    cause: str  # a clause


def loss(flown: Flown, name: str, lost_time: float | None) -> Loss | None:
    """Why a tracker was lost on a flight, ``lost_time`` (s) being that of metrics.json; None where it was not.

    It is lost at the last of several looks in a row that find the aircraft outside its ellipse; what put it there acted
    between the look before the first of them and the last.
    """
    if lost_time is None or name not in flown.tracked:
        return None
    epochs = flown.tracked[name].track.time
    last = int(np.searchsorted(epochs, lost_time))
    since = float(epochs[max(last - LOST_EPOCHS, 0)])
    return Loss(lost_time, _phase(flown.flight, lost_time), cause(flown, name, since, lost_time))


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

    Another law than the tracker assumes, else a bank that does not follow the law, else limits of the law. Of a tracker
    that assumes no law: the turn or the change of speed.
    """
    scenario, law, flight, tracked = flown
    law_from = tracked[name].law_from
    during = (flight.time >= since) & (flight.time <= until)
    if not during.any():
        return "the record has nothing of it"
    if law_from is None:
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
    return "the law is flown there within its limits, so its model errs otherwise"


def _manoeuvre(flight: Flight, during: np.ndarray) -> str:
    """What a model of uniform motion does not hold."""
    bank = float(np.max(np.abs(flight.state.bank[during])))
    if bank > BANKED:
        return f"the aircraft turns there, banked up to {number(float(np.degrees(bank)), 0)} deg"
    speed, time = flight.state.ground_speed[during], flight.time[during]
    change = float(speed[-1] - speed[0]) / max(float(time[-1] - time[0]), 1e-6)
    if abs(change) > CHANGING:
        return f"the aircraft {'slows down' if change < 0.0 else 'speeds up'} there at {number(abs(change), 1)} m/s²"
    return "the aircraft flies straight there at a steady speed"


def _phase(flight: Flight, time: float) -> str:
    at = min(int(np.searchsorted(flight.time, time)), len(flight.time) - 1)
    return words(flight.phases[int(flight.phase[at])])
