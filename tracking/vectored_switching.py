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

TAKEN_UP = 25.0  # s, in which a law is taken up where it is met: 17 s from the path (k2 / k1), and crews are late
OVERDUE = 10.0  # s, for which an armed law is waited for where it should turn the aircraft: crews are some seconds late
MANOEUVRE_STAY = 20.0  # s, of a change of speed under a law, 8 m/s, and of a law away from its path
# s, in which what is rare comes about once: an established aircraft leaves its law, or one takes it up away from its
# path. One approach of 200 s in 18 would be broken off so; one to three in a thousand are [Flight Safety Foundation,
# Go-Around Safety Forum, 2013, finding 1]. A tracker has to be warier, as it has to see those.
RARELY = 3600.0

Rates = tuple[tuple[float, ...], ...]  # (M, M) 1/s; rows are "from"


class VectoredSwitching(NamedTuple):
    """Rates where the law is met, and away from there.

    The hypotheses are in the order of `IntentImm.modes`: the law by its limits at an even speed, slowing down, armed at
    an even speed and slowing down, other laws, free flight.
    """

    met: Rates
    away: Rates


def vectored_switching(limits: int, others: int, free: ModelSet, mean_stay: float) -> VectoredSwitching:
    """The rates for so many limits of the assumed law and so many other laws; ``mean_stay`` in s.

    - Free flight, whose first models are straight at an even speed and slowing down, changes among its models as their
      set says. So does armed flight, which is straight flight at first, and ends in the same turns.
    - From free flight the law is armed after ``mean_stay`` on average, and any law is taken up: where the law is met
      after `TAKEN_UP`, else after `RARELY`. None of a law's hypotheses is preferred.
    - An armed law is taken up likewise. Else it is given up: where it is met after `OVERDUE`, as the aircraft flies
      anything else, elsewhere after ``mean_stay``, as it flies on.
    - A law is left for free flight: where it is met after `RARELY`, else after `MANOEUVRE_STAY`.
    - Under the assumed law an even speed ends after ``mean_stay``, slowing down after `MANOEUVRE_STAY`; its limit stays
      what it is.
    """
    if free.period is None:
        raise ValueError("free flight needs a set whose switching holds over a period")
    first = 2 * limits + 2 + others  # of free flight
    assumed, armed = slice(2 * limits), slice(2 * limits, 2 * limits + 2)
    laws, manual = slice(armed.stop, first), slice(first, None)
    straight, turns = slice(first, first + 2), slice(first + 2, None)
    always = np.zeros((first + len(free.models),) * 2)
    among = np.array(free.switching) / free.period
    always[manual, manual] = among
    always[armed, armed] = among[:2, :2]
    always[straight, armed] = np.eye(2) / mean_stay
    always[turns, armed.start] = 1.0 / mean_stay
    for even, slowing in zip(range(limits), range(limits, 2 * limits), strict=True):
        always[even, slowing], always[slowing, even] = 1.0 / mean_stay, 1.0 / MANOEUVRE_STAY
    met, away = always.copy(), always
    for rates, taken_up, left in ((met, TAKEN_UP, RARELY), (away, RARELY, MANOEUVRE_STAY)):
        rates[armed, assumed] = rates[manual, assumed] = 1.0 / taken_up / (2 * limits)
        rates[manual, laws] = 1.0 / taken_up
        rates[assumed, manual] = rates[laws, manual] = 1.0 / left / len(free.models)
    met[armed, manual] = 1.0 / OVERDUE / len(free.models)
    away[armed, straight] = np.eye(2) / mean_stay
    away[armed, turns] = among[:2, 2:]
    for rates in (met, away):
        np.fill_diagonal(rates, 0.0)
    return VectoredSwitching(*(tuple(map(tuple, rates - np.diag(rates.sum(axis=1)))) for rates in (met, away)))


def unlimited(law: Any) -> Law:
    """A law with no limit on its intercept."""
    found: Law = replace(law, **dict.fromkeys(law.intercept, math.inf))
    return found


def law_is_met(law: Law, path: ReferencePath, place: Any, mean: Any) -> Any:
    """(*B) bool: whether a law with no limit on its intercept asks at the mean (n, *B) for less than all its bank.

    Of [Vasylyev 2003, eq. (4)] this is the strip ``|k1 z + k2 z'| < bank limit``: an aircraft on a heading crosses it
    where the law would turn it onto the path, and one that is established never leaves it.
    """
    return np.abs(law(path.deviation(place, mean))) < law.bank_limit
