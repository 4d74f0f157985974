"""Laws side by side over an axis of hypotheses: one call for the assumed law at all its limits, armed, and others."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from tracking.reference_path import Law

# natural frequency of the laws that aircraft under vectors are captured by, over that of the law that is designed for
# them: k1 of captures by airliners is a 2.7th of it in the median (docs/arrivals.md)
SOFTER = 0.6
MISSED = 60.0  # s since an aircraft met its path on the course that it has: the law will not take it back any more
LARGEST_INTERCEPT = math.radians(120.0)  # of the course from the leg's: beyond it an aircraft flies away, and waits


class LawBank(NamedTuple):
    """The assumed law with its limits over an axis of hypotheses; in the last ones it is armed, or others fly.

    An armed law is not yet flown: the heading is held until the law, which is a softer one, turns the aircraft towards
    the course of the leg.
    From there on it is followed wherever it does that, unless the path has long been missed: one who flies beside it or
    away from it, as to another runway, waits for no law.
    """

    assumed: Law
    armed: tuple[Law, ...]  # of the hypotheses before those of the others, with no limit on their intercept
    others: tuple[Law, ...]
    batch: int  # axes of runs behind that of the hypotheses

    @property
    def bank_limit(self) -> Any:
        """rad."""
        return self.assumed.bank_limit

    def __call__(self, deviation: Any) -> Any:
        """Bank, rad, of every hypothesis."""
        banks = self.assumed(deviation)
        first = banks.shape[-1 - self.batch] - len(self.others)
        for number, law in enumerate(self.armed, first - len(self.armed)):
            which, own = self._one(number, deviation)
            error, wanted = own.track_error, law(own.softened(SOFTER))
            beyond = own.cross_track * np.sign(own.cross_track_rate)  # m, below 0 before the path is met
            may_be = beyond < MISSED * np.abs(own.cross_track_rate)
            engages = (wanted * error < 0.0) & (np.abs(error) < LARGEST_INTERCEPT) & may_be
            banks[which] = np.where(engages, wanted, 0.0)
        for number, law in enumerate(self.others, first):
            which, own = self._one(number, deviation)
            banks[which] = law(own)
        return banks

    def _one(self, number: int, deviation: Any) -> tuple[Any, Any]:
        """Where the banks of one hypothesis are, and its deviation."""
        one = slice(number, number + 1)
        return (..., one, *(slice(None),) * self.batch), deviation.of_hypotheses(one, self.batch)
