"""Which alarms are false, and how late the others are."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

PERCENTILES = (5, 50, 95)


class Detection(NamedTuple):
    """What a test said before and after a fault, in each noise draw; NaN = no alarm."""

    fault: float  # s, when what is tested ceased to hold; infinite = never
    early: np.ndarray  # (draws,) s of the first alarm before it, a false one
    late: np.ndarray  # (draws,) s of the first alarm from then on, whatever raised it
    standing: np.ndarray  # (draws,) bool, whether there was an alarm at the last epoch before it

    @property
    def detected_fraction(self) -> float | None:
        """Share of the draws with an alarm from the fault on; None without one."""
        return None if math.isinf(self.fault) else float(np.isfinite(self.late).mean())

    @property
    def delays(self) -> np.ndarray:
        """(n,) s from the fault to the first alarm, of the draws that have one and had none when it came."""
        return np.asarray((self.late - self.fault)[np.isfinite(self.late) & ~self.standing])

    @property
    def median_delay(self) -> float:
        """s, over the draws that had no alarm when it came; one that is never noticed is infinitely late."""
        waiting = self.late[~self.standing] - self.fault
        return float(np.median(np.where(np.isnan(waiting), math.inf, waiting))) if waiting.size else math.nan


def detection(alarm: np.ndarray, time: np.ndarray, fault: float | None) -> Detection:
    """Part the alarms (k, draws) at the times (k,) by a fault at that time, s; None = nothing goes wrong."""
    since = math.inf if fault is None else fault
    early, late = (_first(alarm & during[:, None], time) for during in (time < since, time >= since))
    before = int(np.searchsorted(time, since))
    return Detection(since, early, late, alarm[before - 1] if before else np.zeros(alarm.shape[1], bool))


def _first(alarm: np.ndarray, time: np.ndarray) -> np.ndarray:
    """(draws,) s of the first alarm, NaN = none."""
    if not len(time):
        return np.full(alarm.shape[1], np.nan)
    return np.where(alarm.any(axis=0), time[np.argmax(alarm, axis=0)], np.nan)


def onsets(alarm: np.ndarray) -> np.ndarray:
    """(k, draws) bool: an alarm at an epoch, and none at the one before."""
    begun = alarm.copy()
    begun[1:] &= ~alarm[:-1]
    return begun


def percentiles(values: np.ndarray) -> dict[str, float] | None:
    """p5, p50 and p95; None of no values."""
    return {f"p{p}": float(np.percentile(values, p)) for p in PERCENTILES} if values.size else None
