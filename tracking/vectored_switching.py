"""How an aircraft that a controller leads to its path changes what it follows: rarely but where its law is met.

A law is engaged where its path is met, and an aircraft that has come onto its path stays there. So the switching of
models [Volovyk 2022, eq. (6)] has two sets of rates, and the place of the estimate says which of them holds.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from tracking.reference_path import Law, ReferencePath
from tracking.trackers.imm import ModelSet

MANOEUVRE_STAY = 20.0  # s, of a change of speed under a law, 8 m/s, and of a law away from its path
# s, in which what is rare comes about once: an established aircraft leaves its law, or one takes it up away from its
# path. Of approaches of 200 s one in 18 would be broken off, where one to three in a thousand are: rather too wary.
RARELY = 3600.0

Rates = tuple[tuple[float, ...], ...]  # (M, M) 1/s; rows are "from"


class VectoredSwitching(NamedTuple):
    """Rates where the law is met, and away from there.

    The hypotheses are in the order of `IntentImm.modes`: the law by its limits at an even speed, slowing down, armed,
    other laws, free flight.
    """

    met: Rates
    away: Rates


def vectored_switching(limits: int, others: int, free: ModelSet, mean_stay: float) -> VectoredSwitching:
    """The rates for so many limits of the assumed law and so many other laws; ``mean_stay`` in s.

    - Free flight changes among its models as their set says.
    - The law is armed, and no longer armed, after ``mean_stay`` on average; what free flight follows is open.
    - Any law is taken up from free flight after ``mean_stay``, the assumed one also from being armed; where it is met,
      else after `RARELY`. Of its hypotheses none is preferred. It is left for free flight after `RARELY`, away from
      where it is met after `MANOEUVRE_STAY`.
    - Under the assumed law an even speed ends after ``mean_stay``, slowing down after `MANOEUVRE_STAY`; its limit stays
      what it is.
    """
    armed = 2 * limits
    count = armed + 1 + others + len(free.models)
    assumed, laws = slice(armed), slice(armed + 1, armed + 1 + others)
    manual = slice(armed + 1 + others, count)
    always = np.zeros((count, count))
    if free.period is None:
        raise ValueError("free flight needs a set whose switching holds over a period")
    among = np.array(free.switching) / free.period
    always[manual, manual] = among - np.diag(np.diag(among))
    always[manual, armed] = 1.0 / mean_stay
    always[armed, manual] = 1.0 / mean_stay / len(free.models)
    for even, slowing in enumerate(range(limits, armed)):
        always[even, slowing], always[slowing, even] = 1.0 / mean_stay, 1.0 / MANOEUVRE_STAY

    def with_laws(taken_up: float, left: float) -> Rates:
        rates = always.copy()
        rates[armed, assumed] = rates[manual, assumed] = 1.0 / taken_up / armed
        rates[manual, laws] = 1.0 / taken_up
        for law in (assumed, laws):
            rates[law, manual] = 1.0 / left / len(free.models)
        return tuple(map(tuple, rates - np.diag(rates.sum(axis=1))))

    return VectoredSwitching(with_laws(mean_stay, RARELY), with_laws(RARELY, MANOEUVRE_STAY))


def law_is_met(law: Law, intercept: tuple[str, ...], path: ReferencePath, place: Any, mean: Any) -> Any:
    """(*B) bool: whether the law, with no limit on its intercept, asks at the mean (n, *B) for less than all its bank.

    Of [Vasylyev 2003, eq. (4)] this is the strip ``|k1 z + k2 z'| < bank limit``: an aircraft on a heading crosses it
    where the law would turn it onto the path, and one that is established never leaves it.
    """
    unlimited: Any = replace(law, **dict.fromkeys(intercept, math.inf))  # type: ignore[type-var]
    return np.abs(unlimited(path.deviation(place, mean))) < unlimited.bank_limit
