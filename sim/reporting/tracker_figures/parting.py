"""Where two trackers of one flight part: from when on the error of one is a multiple of the other's, and stays so."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sim.flight.record import runs
from sim.metrics.error_curves import ErrorCurves

FACTORS = (3.0, 1.5)  # of one error over the other: told apart at a glance, else at a closer look
STAYS = 10.0  # s; shorter is a spike of noise


class Parting(NamedTuple):
    """The stretch of a flight in which two trackers are apart."""

    start: float  # s
    end: float  # s; later they may part again
    factor: float  # that one error is of the other there, at least


def parting(one: ErrorCurves, other: ErrorCurves, channel: str) -> Parting | None:
    """Where they part for the first time; None where for 10 s on end neither errs half as much again as the other.

    Errors are root mean squares over the draws in short windows of time; the second tracker's are taken at the times of
    the first.
    """
    first, second = one.channels[channel].rmse, np.interp(one.time, other.time, other.channels[channel].rmse)
    half = 0.5 * float(np.median(np.diff(one.time))) if len(one.time) > 1 else 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.abs(np.log(first / second))
    for factor in FACTORS:
        apart = ratio >= np.log(factor)
        for begin, end in runs(apart):
            stretch = Parting(float(one.time[begin]) - half, float(one.time[end - 1]) + half, factor)
            if apart[begin] and stretch.end - stretch.start >= STAYS:
                return stretch
    return None
