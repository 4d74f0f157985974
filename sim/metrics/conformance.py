"""Does the aircraft follow the law that its tracker assumes? Page's test on the mode probabilities of `intent_imm`.

Each look multiplies the odds of the hypotheses that do not follow the assumed law, against those that do, by a
likelihood ratio. Page's test sums the logarithm of that ratio, never below zero, and raises an alarm where the sum
exceeds the logarithm of the least mean number of looks between false alarms. While the assumed law is flown as the
tracker models it, false alarms are at least that rare (Lorden 1971); the bound is a loose one. The alarm lasts until
the assumed law is more probable than not; then the sum starts again from zero. For a vectored aircraft, whose law is
only armed at first, the test begins once that law has been more probable than not for 40 s on end.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.metrics.alarms.detection import detection, percentiles
from tracking.conformance import CONFORMANCE, Watched

MISMATCHED = "told wrong"  # `law_from` in metrics.json of a tracker whose assumed law is not the one that flies


def foremost(tracked: dict[str, Any]) -> tuple[str, Watched] | None:
    """Name and test of the first tracker with intents, those that assume the law that flies before mismatched ones."""
    for mismatched in (False, True):
        for name, one in tracked.items():
            if (one.law_from == MISMATCHED) is mismatched:
                watched = CONFORMANCE.watch(one.tracker, one.track)
                if watched is not None:
                    return name, watched
    return None


def figures(watched: Watched | None, departure: float | None, recorded: bool = False) -> dict[str, Any] | None:
    """The table ``conformance`` of metrics.json; None where there was no test.

    ``departure`` is when the assumed law was left, s, None = it was flown to the end. An alarm before it is a false
    one; delays are over the draws that had no alarm at that time. Of a recorded flight nobody knows which law was
    flown, and so which alarm is false.
    """
    if watched is None:
        return None
    found = detection(watched.alarm, watched.time, departure)
    first = np.fmin(found.early, found.late)
    raised = np.isfinite(first)
    rows = np.searchsorted(watched.time, first[raised])
    return {
        "told": watched.assumed,
        "looks_between_false_alarms": math.exp(watched.limit),
        "alarm_fraction": float(raised.mean()),
        "alarm_time_s": percentiles(first[raised]),
        "false_alarm_fraction": None if recorded else float(np.isfinite(found.early).mean()),
        "departure_s": departure,
        "detected_fraction": found.detected_fraction,
        "delay_s": percentiles(found.delays),
        "believed_at_alarm": {
            name: float(belief[rows, np.flatnonzero(raised)].mean()) for name, belief in watched.belief.items()
        }
        if raised.any()
        else None,
    }


def conformance_sentence(name: str, found: dict[str, Any]) -> str:
    """One sentence on what a tracker's test found; ``found`` as in metrics.json."""
    head = f"Conformance by {name}:"
    share, time = found["alarm_fraction"], found["alarm_time_s"]
    if found["false_alarm_fraction"] is None:
        since = "" if time is None else f", the first at {time['p50']:.0f} s (median)"
        return (
            f"{head} alarms in {share:.1%} of the draws{since}; whether the {found['told']} was flown is not recorded"
        )
    if time is None:
        missed = "" if found["departure_s"] is None else f", although it was left at {found['departure_s']:.0f} s"
        return f"{head} the {found['told']} is followed, no alarm{missed}"
    believed = max(found["believed_at_alarm"].items(), key=lambda item: item[1] * (item[0] != found["told"]))[0]
    if found["departure_s"] is None:
        return f"{head} the {found['told']} is followed; false alarms in {share:.1%} of the draws"
    false = f", {found['false_alarm_fraction']:.1%} before" if found["false_alarm_fraction"] else ""
    delay = f"after {found['delay_s']['p50']:.0f} s (median)" if found["delay_s"] else "at once"
    return (
        f"{head} the {found['told']} was left at {found['departure_s']:.0f} s; alarm {delay} in "
        f"{found['detected_fraction']:.0%} of the draws{false}; most likely: {believed}"
    )
