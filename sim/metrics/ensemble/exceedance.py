"""How often flights go beyond limits: exceedances as probabilities with intervals, and whole distributions.

Intervals are those of Clopper and Pearson (1934), two-sided, at each value by itself. A band that holds everywhere at
once [Dvoretzky, Kiefer and Wolfowitz 1956] is equally wide at every value, 0.043 for a thousand flights, and would say
nothing of tails. Both take the flights for independent, as draws are that are not stratified.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.metrics.ensemble.spread import CONFIDENCE, scalars
from sim.metrics.ensemble.verdict import share_low
from sim.scenario.tables import Check


class Tail(NamedTuple):
    """Probability that a flight goes beyond each of some values, away from the middle; all arrays (m,)."""

    value: np.ndarray  # in the unit of the figure, from the middle outwards
    share: np.ndarray  # of the flights beyond the value
    low: np.ndarray
    high: np.ndarray


class Limit(NamedTuple):
    """Of a check: a value, and the probability with which flights may be beyond it; None = no flight may."""

    value: float
    probability: float | None


class Distribution(NamedTuple):
    """A figure over all flights of a study. A flight that has not the figure is beyond every limit, on both sides."""

    name: str
    flights: int
    without: int  # of them, that have not the figure
    distinct: int  # values of the others
    below: Tail
    above: Tail
    limits_below: tuple[Limit, ...]  # a flight should not be below
    limits_above: tuple[Limit, ...]


def interval(count: Any, flights: int, confidence: float = CONFIDENCE) -> tuple[Any, Any]:
    """Two-sided bounds of a probability of which ``count`` of so many flights are cases; arrays too."""
    one_sided = 0.5 + 0.5 * confidence
    return share_low(count, flights, one_sided), 1.0 - share_low(flights - np.asarray(count), flights, one_sided)


def exceedances(checks: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """How often each check of one cell is broken, as in metrics.json, from its verdicts.

    ``low`` and ``high`` are the two-sided interval at 95 %; ``below`` is the one-sided bound with the confidence of the
    check, 95 % where it has none.
    """
    found = []
    for check in checks:
        flights = check["flights"] - check["not_flown"]
        if flights:
            confidence = CONFIDENCE if check["confidence"] is None else check["confidence"]
            beyond = flights - check["within"]
            low, high = interval(beyond, flights)
            found.append(
                {
                    "name": check["name"],
                    "metric": check["metric"],
                    "beyond": beyond,
                    "flights": flights,
                    "probability": beyond / flights,
                    "low": low,
                    "high": high,
                    "below": 1.0 - share_low(flights - beyond, flights, confidence),
                    "confidence": confidence,
                }
            )
    return found


def any_beyond(records: Sequence[dict[str, Any]]) -> int:
    """How many flights break any check."""
    return sum(not record["checks"] or any(one["passed"] is False for one in record["checks"]) for record in records)


def answer(metrics: dict[str, Any]) -> str:
    """One sentence from metrics.json: how many flights are beyond any limit, what that shows, and which limits."""
    broken, flights = metrics["any_beyond"], metrics["flights"]
    below = 1.0 - share_low(flights - broken, flights, CONFIDENCE)
    sentence = f"{broken} of {flights} flights beyond a limit: "
    sentence += f"{percent(broken / flights)} %, " if broken else ""
    sentence += f"below {percent_above(below)} % with {100 * CONFIDENCE:g} % confidence"
    most = sorted((one for one in metrics["exceedances"] if one["beyond"]), key=lambda one: -one["beyond"])
    which = ", ".join(f"{one['name']} ({one['beyond']})" for one in most)
    return f"{sentence}; broken: {which}" if which else sentence


def percent(probability: float) -> str:
    """A probability as percent, with two figures."""
    return f"{100 * probability:.2g}"


def percent_above(bound: float) -> str:
    """An upper bound as percent, with two figures, never rounded down: it would say more than was shown."""
    if not bound > 0.0:
        return percent(bound)
    unit = 10.0 ** (math.floor(math.log10(100 * bound)) - 1)
    return f"{unit * math.ceil(100 * bound / unit - 1e-9):.2g}"


def distribution(name: str, records: Sequence[dict[str, Any]], checks: Sequence[Check]) -> Distribution:
    """The distribution of a figure, with the limits that the checks of the scenario set it."""
    values = np.sort([value for record in records for key, value in scalars(record["metrics"]) if key == name])
    without = len(records) - len(values)
    below, above = (
        tuple(
            Limit(limit, None if check.required_share is None else 1.0 - check.required_share)
            for check in checks
            if check.metric == name and (limit := getattr(check, side)) is not None
        )
        for side in ("min", "max")
    )
    return Distribution(
        name,
        len(records),
        without,
        len(np.unique(values)),
        _tail(-values[::-1], without, [-limit.value for limit in below], -1.0),
        _tail(values, without, [limit.value for limit in above], 1.0),
        below,
        above,
    )


def _tail(ordered: np.ndarray, without: int, limits: Sequence[float], sign: float) -> Tail:
    """The share beyond each value from the median outwards, and on to the farthest limit.

    ``ordered`` rise outwards; ``sign`` turns them into values of the figure.
    """
    flights = len(ordered) + without
    outer = ordered[len(ordered) // 2 :]
    farthest = max([*limits, *outer[-1:]], default=0.0)
    value = np.append(outer, [farthest] if len(outer) and farthest > outer[-1] else [])
    beyond = len(ordered) - np.searchsorted(ordered, value, side="right") + without
    low, high = interval(beyond, flights)
    return Tail(sign * value, beyond / max(flights, 1), low, high)
