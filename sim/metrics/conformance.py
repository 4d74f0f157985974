"""Does the aircraft follow the law that its tracker is told? Page's test on the mode probabilities of `intent_imm`.

At every look the tracker weighs its hypotheses anew, and the ratio of what the look did to those that follow the told
law and to all others is a likelihood ratio. Page's test sums its logarithm since the sum was last in favour of the told
law, and alarms where the sum exceeds the logarithm of the number of looks that shall at least pass between two false
alarms on average: while the told law is flown as the tracker models it, they are that rare (Lorden 1971), and the bound
is a wide one. An alarm stands until the told law is more probable than not; then the sum begins anew.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tracking.conformance import CONFORMANCE, Watched

PERCENTILES = (5, 50, 95)


def foremost(tracked: dict[str, Any]) -> tuple[str, Watched] | None:
    """The first tracker that has intents, one that is told the law that flies before others, with its test."""
    for told_wrong in (False, True):
        for name, one in tracked.items():
            if (one.law_from == "told wrong") is told_wrong:
                watched = CONFORMANCE.watch(one.tracker, one.track)
                if watched is not None:
                    return name, watched
    return None


def figures(watched: Watched | None, departure: float | None) -> dict[str, Any] | None:
    """As in metrics.json; ``departure`` is when the told law was left, s, None = it was flown to the end.

    An alarm before the departure is a false one; delays are those of the draws in which there was no alarm then.
    """
    if watched is None:
        return None
    alarm, time = watched.alarm, watched.time
    since = math.inf if departure is None else departure
    early, late = (_first(alarm & during[:, None], time) for during in (time < since, time >= since))
    standing = alarm[max(int(np.searchsorted(time, since)) - 1, 0)] if (time < since).any() else alarm[0] & False
    answered = np.isfinite(late) & ~standing
    first = np.fmin(early, late)
    raised = np.isfinite(first)
    rows = np.searchsorted(time, first[raised])
    return {
        "told": watched.told,
        "looks_between_false_alarms": math.exp(watched.limit),
        "alarm_fraction": float(raised.mean()),
        "alarm_time_s": _percentiles(first[raised]),
        "false_alarm_fraction": float(np.isfinite(early).mean()),
        "departure_s": departure,
        "detected_fraction": None if departure is None else float(np.isfinite(late).mean()),
        "delay_s": None if departure is None else _percentiles(late[answered] - departure),
        "believed_at_alarm": {
            name: float(belief[rows, np.flatnonzero(raised)].mean()) for name, belief in watched.belief.items()
        }
        if raised.any()
        else None,
    }


def _first(alarm: np.ndarray, time: np.ndarray) -> np.ndarray:
    """(draws,) s of the first alarm, NaN = none."""
    return np.where(alarm.any(axis=0), time[np.argmax(alarm, axis=0)], np.nan)


def _percentiles(values: np.ndarray) -> dict[str, float] | None:
    if not values.size:
        return None
    return {f"p{p}": float(np.percentile(values, p)) for p in PERCENTILES}


def told_in_words(name: str, found: dict[str, Any]) -> str:
    """One sentence on what a tracker's test found; ``found`` as in metrics.json."""
    told = f"Conformance by {name}:"
    share, time = found["alarm_fraction"], found["alarm_time_s"]
    if time is None:
        missed = "" if found["departure_s"] is None else f", although it was left at {found['departure_s']:.0f} s"
        return f"{told} the {found['told']} is followed, no alarm{missed}"
    believed = max(found["believed_at_alarm"].items(), key=lambda item: item[1] * (item[0] != found["told"]))[0]
    if found["departure_s"] is None:
        return f"{told} the {found['told']} is followed; false alarms in {share:.1%} of the draws"
    false = f", {found['false_alarm_fraction']:.1%} before" if found["false_alarm_fraction"] else ""
    delay = f"after {found['delay_s']['p50']:.0f} s (median)" if found["delay_s"] else "at once"
    return (
        f"{told} the {found['told']} was left at {found['departure_s']:.0f} s; alarm {delay} in "
        f"{found['detected_fraction']:.0%} of the draws{false}; most likely: {believed}"
    )
