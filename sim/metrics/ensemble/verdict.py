"""The verdict on a check over all flights.

Every flight must keep it, unless it says ``share`` and ``confidence``: then the one-sided lower bound of Clopper and
Pearson (1934) on the share of all such flights that keep it must reach the share. In a study that is asked of every
cell: its flights are independent, and those of another cell are the same draws again.

A flight that crashed, or has not the figure, does not keep a check. One in which the phases of a check were not flown
is neither kept nor broken, and counts in no share; where that is so of every flight, there is no verdict. A cell whose
values were refused flew nothing either, but a share is asked of all that was drawn.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from sim.errors import ScenarioError, did_you_mean
from sim.metrics.checks import OF_CONTRASTS, OF_TRACKERS, described, find, meant
from sim.metrics.navigation import GOOD
from sim.scenario.tables import Check, Contrast

CRASHED = "crashed"  # the outcome of a flight that could not be flown to any end
REFUSED = "refused"  # of one that could not begin: its values make no flight, and the reason says why
LOST = {"value": None, "limit": None, "margin": None, "time_s": None, "passed": False}  # any check of it


def verdicts(checks: Sequence[Check], records: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The verdict on each check, as in metrics.json.

    ``records`` are those of all flights, in order: ``flight`` (its number), ``metrics``, ``checks``, and of a study the
    ``values`` of its axes. Raises ``ScenarioError`` for a figure of a tracker or a contrast that no flight has.
    """
    found = [verdict(check, number, records) for number, check in enumerate(checks)]
    for check, one in zip(checks, found, strict=True):
        if one["value"] is None and check.metric.startswith((OF_TRACKERS, OF_CONTRASTS)):
            _refuse_misspelt(check.metric, records)
    return found


def verdict(check: Check, number: int, records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The verdict on one check, the ``number``-th of each record.

    Value, limit, margin and time are those of the flight that decides: the one that comes nearest to breaking the
    check, or is farthest beyond it. With a share it is the best of those flights that must keep it, since fewer would
    not show the share; its margin is negative where the check fails, unless the flights were too few. The counts are
    then those of the cell that decides.
    """
    if check.required_share is None:
        return _of_group(check, number, records)
    cells: dict[int, list[dict[str, Any]]] = {}
    for record in records:
        cells.setdefault(record.get("cell", 0), []).append(record)
    found = [_of_group(check, number, cell) for cell in cells.values()]
    return min(found, key=lambda one: ((False, True, None).index(one["passed"]), _margin(one)))


def _of_group(check: Check, number: int, records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The verdict over flights that are judged together."""
    every = [(record, _result(check, number, record)) for record in records]
    judged = [(record, result) for record, result in every if result["passed"] is not None]
    judged.sort(key=lambda pair: _margin(pair[1]))  # stable: of equals the first flight
    kept = sum(result["passed"] is True for _, result in judged)
    share, allowed, bound = check.required_share, 0, None
    if share is not None and check.confidence is not None and judged:
        allowed = failures_allowed(len(judged), share, check.confidence)
        bound = share_low(kept, len(judged), check.confidence)
    asked = described(check)
    record, result = judged[max(allowed, 0)] if judged else every[0]
    return {
        **asked,
        **result,
        "limit": asked["limit"] if result["limit"] is None else result["limit"],
        "passed": len(judged) - kept <= allowed if judged else None,
        "flight": record["flight"],
        "at": record.get("values", {}),
        "outcome": record["metrics"]["outcome"],
        "flights": len(records),
        "within": kept,
        "not_flown": len(records) - len(judged),
        "share": 1.0 if share is None else share,
        "confidence": check.confidence,
        "share_low": bound,
    }


def _result(check: Check, number: int, record: dict[str, Any]) -> dict[str, Any]:
    """What a flight says of a check."""
    if record["checks"]:
        result: dict[str, Any] = record["checks"][number]
        return result
    refused = record["metrics"]["outcome"] == REFUSED and check.required_share is None
    return LOST | {"passed": None} if refused else LOST


def _margin(result: dict[str, Any]) -> float:
    return -math.inf if result["margin"] is None else float(result["margin"])


def share_low(kept: Any, flights: int, confidence: float) -> Any:
    """Lower bound of the share of all such flights that keep a check, where ``kept`` of so many did; arrays too."""
    from scipy.stats import beta

    kept = np.asarray(kept)
    bound = np.where(kept > 0, beta.ppf(1.0 - confidence, np.maximum(kept, 1), flights - kept + 1), 0.0)
    return bound if bound.ndim else float(bound)


def failures_allowed(flights: int, share: float, confidence: float) -> int:
    """How many of the flights may fail so that the others show the share; -1 = too few flights even if none does."""
    kept = flights - np.arange(flights + 1)
    return int((share_low(kept, flights, confidence) >= share).sum()) - 1


def fewest_flights(share: float, confidence: float) -> int:
    """How many good flights show a share with a confidence: the least n with share^n <= 1 - confidence."""
    few = max(1, math.floor(math.log(1 - confidence) / math.log(share)) - 1)  # the bound itself decides about rounding
    return next(count for count in range(few, few + 4) if share_low(count, count, confidence) >= share)


def refuse_unfit(
    name: str,
    checks: Sequence[Check],
    flights: int,
    trackers: Iterable[str],
    more: str = "",
    contrasts: Sequence[Contrast] = (),
) -> None:
    """Raise ``ScenarioError`` for contrasts and checks that cannot be answered, before anything is flown.

    A share needs so many flights, a contrast two trackers, and a figure of one of these what it names. ``more`` says
    where there are more flights.
    """
    known, pairs = [*trackers], [one.pair for one in contrasts]
    faults = _strangers(contrasts, known)
    for number, check in enumerate(checks):
        place = f"[[checks]] entry {number} ('{check.name or check.metric}')"
        own = check.metric.removeprefix(OF_TRACKERS).partition(".")[0]
        if check.metric.startswith(OF_TRACKERS) and own not in known:
            faults.append(f"{place} metric: no tracker '{own}'; {did_you_mean(own, known)}")
        pair = check.metric.removeprefix(OF_CONTRASTS).partition(".")[0]
        if check.metric.startswith(OF_CONTRASTS) and pair not in pairs:
            hint = did_you_mean(pair, pairs) if pairs else "the scenario has no [[contrasts]]"
            faults.append(f"{place} metric: no contrast '{pair}'; {hint}")
        share, confidence = check.required_share, check.confidence
        if share is None or confidence is None or flights >= (needed := fewest_flights(share, confidence)):
            continue
        below = 1.0 - share_low(flights, flights, confidence)
        faults.append(
            f"{place}: {100 * share:g} % with {100 * confidence:g} % confidence needs at least {needed} flights, "
            f"there {'is' if flights == 1 else 'are'} {flights}: none broken of {flights} says only below "
            f"{100 * below:.2g} %{more}"
        )
    if faults:
        raise ScenarioError("\n".join(f"{name}: {fault}" for fault in faults))


def _strangers(contrasts: Sequence[Contrast], trackers: Sequence[str]) -> list[str]:
    """Faults of contrasts that name a tracker that there is not; where nobody tracks, there is a warning in the end."""
    return [
        f"[[contrasts]] entry {number} {side}: no tracker '{name}'; {did_you_mean(name, trackers)}"
        for number, one in enumerate(contrasts)
        for side, name in (("of", one.of), ("against", one.against))
        if trackers and name not in trackers
    ]


def _refuse_misspelt(metric: str, records: Sequence[dict[str, Any]]) -> None:
    """A figure that no flight has although its tracker, or its contrast, has others is a fault of the file."""
    flown = [record["metrics"] for record in records]
    figures = next(filter(None, (meant(metric, metrics) for metrics in flown)), None)
    if figures and not any(find(metrics, metric)[0] for metrics in flown):
        raise ScenarioError(f"check of '{metric}': no such figure; {did_you_mean(metric, figures)}")


def worst_first(records: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The records, those with most broken checks first, then those that ended badly, then the nearest to a limit.

    Nearness is the margin over the size of the limit, so that checks of different units can be compared; a limit of
    zero has no size, and a margin of exactly zero is that of a yes or no.
    """

    def badness(record: dict[str, Any]) -> tuple[Any, ...]:
        results = record["checks"]
        crashed = record["metrics"]["outcome"] in (CRASHED, REFUSED)
        broken = sum(result["passed"] is False for result in results)
        margins = [one["margin"] / abs(one["limit"]) for one in results if one["margin"] and one["limit"]]
        return not crashed, -broken, record["metrics"]["outcome"] in GOOD, min(margins, default=0.0), record["flight"]

    return sorted(records, key=badness)
