"""What a short word costs the realisations: every number that a step hands on is rounded.

Products are of double length. A fixed point is set for each number by its largest value on the leg and saturates; a
single precision floats.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sim.claims.angle_channel import SIGMA
from sim.claims.papers.volovyk2018.experiment import FILTERS, LEG_SETTLED, SPREAD, UNIFORM, printed_leg
from sim.randomness import stream
from tracking.intervals import Interval, gain
from tracking.trackers.elevation import PERIOD, Model, full, gain_schedule, stored_gain

FAR = 10e3  # m, to where the leg is followed
ROOM = 5.0  # deviations that an estimate may lie beyond the motion itself before its word saturates
DOUBLE, SINGLE = 64, 24  # bits of the digits of a floating number
WORDS = {"single precision": SINGLE, "24 bits": 23, "16 bits": 15, "12 bits": 11, "8 bits": 7}


class Case(NamedTuple):
    """A filter of the study in one realisation and one word."""

    filter: str
    realisation: int  # 1, the gain computed; 4, the gain stored
    digits: int  # of a fixed point beside its sign, or SINGLE or DOUBLE


CASES = tuple(
    Case(name, realisation, digits)
    for name in ("as published", UNIFORM)
    for realisation in (1, 4)
    for digits in (DOUBLE, *WORDS.values())
)


class Store(NamedTuple):
    """The memory of one kind of number in all cases, which stand in its last axis but one, or its last."""

    unit: Any  # (..., F) of the last digit; 1 where numbers float
    end: Any  # (F,) units
    fixed: Any  # (F,)
    single: Any  # (F,)

    def __call__(self, values: Any, over_runs: bool = False) -> Any:
        unit, end, fixed, single = (part[..., None] if over_runs else part for part in self)
        rounded = unit * np.clip(np.rint(values / unit), -end, end - 1.0)
        return np.where(fixed, rounded, np.where(single, values.astype(np.float32), values))


def store(largest: Any) -> Store:
    """Memory for numbers whose largest values (..., F) are known."""
    digits = np.array([case.digits for case in CASES])
    fixed = digits < SINGLE
    end = 2.0 ** np.where(fixed, digits, 0)
    power = np.ceil(np.log2(np.where(largest > 0.0, largest, 1.0)))
    return Store(np.where(fixed, 2.0**power / end, 1.0), end, fixed, digits == SINGLE)


@lru_cache(maxsize=2)
def squares(seed: int, runs: int) -> dict[Case, Any]:
    """Mean squared errors (runs,), rad^2, of every case from the settled filter to ``FAR``, by the same noise."""
    leg = printed_leg()
    steps = int((leg.distance > FAR).sum())
    angle = leg.angle[:steps, 0]
    A, Q, P = (np.zeros((3, 3, len(CASES))) for _ in range(3))
    for place, case in enumerate(CASES):
        n = FILTERS[case.filter].order
        A[:n, :n, place], Q[:n, :n, place] = FILTERS[case.filter].transition(PERIOD)
        P[:n, :n, place] = np.diag(SPREAD[:n] ** 2)
    model = Model(A, Q, np.eye(1, 3)[..., None], np.array([[[SIGMA**2]]]))
    gains, covariances = gain_schedule(P, model, steps)
    rate = np.gradient(angle, PERIOD)
    motion = np.abs([angle, rate, np.gradient(rate, PERIOD)]).max(axis=1)
    spread = np.maximum(np.abs(covariances).max(axis=0), np.abs(P))
    keep_P, keep_K = store(spread), store(np.abs(gains).max(axis=0))
    keep_x = store(motion[:, None] + ROOM * np.sqrt(np.einsum("iif->if", spread)))
    computed = np.array([case.realisation == 1 for case in CASES])
    z = angle[:, None] + SIGMA * stream(seed, 0, 0, "volovyk2018.word").standard_normal((steps, runs))
    x = np.zeros((3, len(CASES), runs))
    x[0] = angle[0] - PERIOD * leg.rate
    x[1] = leg.rate
    found, none = np.zeros((len(CASES), runs)), np.zeros((3, len(CASES)))
    for k in range(steps):
        _, P, K = full(none, P, none[:1], model)
        P, K = keep_P(P), keep_K(np.where(computed, K, gains[k]))
        x = keep_x(stored_gain(x, z[k][None, None], K[..., None], A[..., None], model.C[..., None]), over_runs=True)
        if k >= LEG_SETTLED:
            found += (x[0] - angle[k]) ** 2
    return dict(zip(CASES, found / (steps - LEG_SETTLED), strict=True))


def cost(filter: str, realisation: int, word: str) -> Any:
    """Measure of the RMS error with a short word over that of double precision."""

    def measured(seed: int, runs: int) -> Interval:
        found = squares(seed, runs)
        return gain(found[Case(filter, realisation, WORDS[word])], found[Case(filter, realisation, DOUBLE)])

    return measured
