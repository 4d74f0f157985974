"""The oscillation that is left at the end of a flight: a limit cycle, or nothing."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.flight.loop import Flight

LASTING = 60.0  # s; twice at the end of a flight
WATCHED = 180.0  # s, at the end; for periods of up to two minutes
LEAST = math.radians(1.0)  # of bank; less is no oscillation


def oscillation(flight: Flight) -> dict[str, float | None]:
    """Amplitude of the bank that persisted for the last minute, and its period, null without an oscillation.

    The amplitude is half the way from peak to peak, in that one of the last two minutes in which it is smaller: what
    fades does not persist.
    """
    left, bank = flight.time[-1] - flight.time, flight.state.bank
    minutes = [bank[left < LASTING], bank[(left >= LASTING) & (left <= 2.0 * LASTING)]]
    amplitude = min(0.5 * float(np.ptp(minute)) if minute.size else 0.0 for minute in minutes)
    last = left <= WATCHED
    period = _period(flight.time[last], bank[last]) if amplitude >= LEAST else None
    return {"bank_cycle_deg": math.degrees(amplitude), "bank_cycle_period_s": period}


def _period(time: Any, bank: Any) -> float | None:
    """Mean time between every other passage through the middle; None with less than three of them."""
    level = bank - 0.5 * (bank.max() + bank.min())
    at = np.flatnonzero((level[:-1] < 0.0) != (level[1:] < 0.0))
    if len(at) < 3:
        return None
    passed = time[at] + (time[at + 1] - time[at]) * level[at] / (level[at] - level[at + 1])
    return float((passed[2:] - passed[:-2]).mean())
