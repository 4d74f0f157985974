"""Which tracker was best, by how much and why, in one sentence."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.metrics.conformance import MISMATCHED
from sim.reporting.text.labels import column, joined, number, split, words
from sim.reporting.tracker_figures.error_curves import Shown

PLACES = {"cross_track_m": "across track", "position_m": "of position", "height_m": "of height"}
MOST_LOST = 0.02  # share of the draws that a winner may lose
TOO_SURE = 1.5  # ANEES beyond which the winner is called too sure of itself


def best_tracker(flight: Flight, trackers: dict[str, Any], followed: list[Shown], short: bool = False) -> str:
    """The best of those that saw the same measurements; empty where nothing was tracked.

    On one line they are compared across it, on a route by position. A tracker with a mismatched law, or one that loses
    draws, does not win while there are others: the first is there to be compared with its twin, the second is no
    tracker to rely on. ``short`` leaves out what a law was worth. ``trackers`` as in metrics.json. Ratios are of root
    mean square errors over common draws; two trackers are alike where the paired 95 % interval of their ratio holds 1.
    """
    channel, rivals = _contest(flight, trackers, followed)
    if not rivals:
        return ""
    best = _best(trackers, rivals)
    others = [one for one in rivals if one is not best]
    parts = [f"{_head(trackers, channel, best, rivals)}"]
    if others:
        parts.append(_behind(flight, trackers, channel, best, others))
    parts += [] if short else _law(trackers, channel, best, others)
    figures = trackers[best.name]
    if (figures.get("anees_low") or 0.0) > TOO_SURE:
        parts.append(f"yet it is too sure of itself (ANEES {number(float(figures['anees']), 1)})")
    if figures.get("lost_fraction"):
        parts.append(f"it lost {number(100.0 * figures['lost_fraction'], 1)} % of the draws")
    if others and best.curves.draws == 1:
        parts.append("one draw does not tell a lead from chance")
    return "; ".join(part for part in parts if part) + "."


def leading(flight: Flight, trackers: dict[str, Any], followed: list[Shown]) -> list[Shown]:
    """The best tracker and the next of another kind, mismatched twins and those that lose draws left out."""
    _, rivals = _contest(flight, trackers, followed)
    if not rivals:
        return []
    best = _best(trackers, rivals)
    kind = trackers[best.name].get("kind")
    fair = [one for one in rivals if one.law_from != MISMATCHED and _lost(trackers, one) <= MOST_LOST]
    return [best, *[one for one in fair if trackers[one.name].get("kind") != kind][:1]]


def _best(trackers: dict[str, Any], rivals: list[Shown]) -> Shown:
    """Of equals the first."""
    return min(rivals, key=lambda one: (one.law_from == MISMATCHED, _lost(trackers, one) > MOST_LOST))


def _lost(trackers: dict[str, Any], one: Shown) -> float:
    """The share of its draws that a tracker lost."""
    return float(trackers[one.name].get("lost_fraction") or 0.0)


def _contest(flight: Flight, trackers: dict[str, Any], followed: list[Shown]) -> tuple[str, list[Shown]]:
    """The channel that is compared and, best first, the trackers that have it from the most used set of sensors."""
    able: list[Shown] = []
    places = sorted(PLACES, key=lambda channel: channel == "cross_track_m") if len(flight.route.legs) > 1 else PLACES
    for channel in (*places, *dict.fromkeys(c for one in followed for c in one.curves.channels)):
        able = [one for one in followed if _rmse(trackers, channel, one) is not None]
        if able:
            break
    groups: dict[frozenset[str], list[Shown]] = {}
    for one in able:
        groups.setdefault(one.curves.sensors, []).append(one)
    rivals = max(groups.values(), key=len, default=[])
    return channel if able else "", sorted(rivals, key=lambda one: _rmse(trackers, channel, one) or np.inf)


def _rmse(trackers: dict[str, Any], channel: str, one: Shown) -> float | None:
    value = ((trackers.get(one.name) or {}).get("overall") or {}).get(channel, {}).get("rmse")
    return float(value) if value is not None and np.isfinite(value) and channel in one.curves.channels else None


def _head(trackers: dict[str, Any], channel: str, best: Shown, rivals: list[Shown]) -> str:
    figures = trackers[best.name]["overall"][channel]
    name, unit = split(channel)
    where = PLACES.get(channel, f"in {name.replace(':', '')}")
    shown = column([figures["rmse"], figures.get("raw")])
    among = f"Of {len(rivals)} trackers of the same measurements {words(best.name)}" if rivals[1:] else words(best.name)
    text = f"{among} was best" if rivals[1:] else f"{among} tracked"
    text = f"{text} {where} with {shown[0]} {unit} RMS"
    gain = figures.get("gain")
    if gain is None:
        return text
    if gain >= 1.0:
        return f"{text}, {number(float(gain), 1)} times better than the raw measurements ({shown[1]} {unit})"
    return f"{text}, worse than the raw measurements ({shown[1]} {unit})"


def _ratio(channel: str, one: Shown, best: Shown) -> tuple[float, bool]:
    """(error of ``one`` over that of ``best``, whether noise explains it), over common draws."""
    from tracking.intervals import gain

    found = gain(one.curves.channels[channel].of_draws, best.curves.channels[channel].of_draws)
    return found.value, bool(found.low <= 1.0 <= found.high)


def _behind(flight: Flight, trackers: dict[str, Any], channel: str, best: Shown, others: list[Shown]) -> str:
    """Trackers as good as the best, and by how much and where the next one is worse."""
    ratios = {one.name: _ratio(channel, one, best) for one in others}
    alike = [words(one.name) for one in others if ratios[one.name][1]]
    told = [one for one in others if not ratios[one.name][1] and np.isfinite(ratios[one.name][0])]
    behind = [one for one in told if ratios[one.name][0] > 1.0]
    parts = [f"{joined(alike)} {'is' if len(alike) == 1 else 'are'} as good within the noise"] if alike else []
    if behind:
        value = ratios[behind[0].name][0]
        where = _where(flight, channel, best, behind[0])
        parts.append(f"next is {words(behind[0].name)} with {number(value, 2)} times the error{where}")
    for one in told:
        if ratios[one.name][0] < 1.0:  # only what does not win although it errs less
            times, lost = number(ratios[one.name][0], 2), number(100.0 * _lost(trackers, one), 1)
            why = "its law is mismatched" if one.law_from == MISMATCHED else f"it loses {lost} % of the draws"
            parts.append(f"yet {words(one.name)} has {times} times the error although {why}")
    return ", ".join(parts)


def _where(flight: Flight, channel: str, best: Shown, other: Shown) -> str:
    """The phase in which most of the excess of squared error was made."""
    if len(best.curves.time) != len(other.curves.time):
        return ""
    excess = other.curves.channels[channel].rmse ** 2 - best.curves.channels[channel].rmse ** 2
    phase = best.curves.phase
    sums = {flight.phases[int(p)]: float(np.nansum(excess[phase == p])) for p in np.unique(phase)}
    worst = max(sums, key=lambda name: sums[name])
    return f", most of it during {words(worst)}" if len(sums) > 1 and sums[worst] > 0.0 else ""


def _law(trackers: dict[str, Any], channel: str, best: Shown, others: list[Shown]) -> list[str]:
    """What the law was worth: against the best tracker without one, and against the same kind with another law."""
    parts = []
    informed = best.law_from is not None
    other = next((one for one in others if (one.law_from is not None) != informed), None)
    if other is not None:
        value, alike = _ratio(channel, other, best)
        if informed:
            parts.append(
                f"knowing a law is worth a factor of {number(value, 2)} over {words(other.name)}, the best without one"
                if not alike
                else f"{words(other.name)}, which assumes no law, is as good"
            )
        else:
            parts.append(f"the best that assumes a law, {words(other.name)}, has {number(value, 2)} times the error")
    kind = trackers[best.name].get("kind")
    twin = next(
        (one for one in others if informed and trackers[one.name].get("kind") == kind and one.law_from != best.law_from
         and one.law_from is not None), None,
    )  # fmt: skip
    if twin is not None:
        value, alike = _ratio(channel, twin, best)
        if alike:
            parts.append("which of the two laws it assumes makes no difference to it")
        elif value > 1.0:
            parts.append(f"with the mismatched law it has {number(value, 2)} times the error")
    return parts
