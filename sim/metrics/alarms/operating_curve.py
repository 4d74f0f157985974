"""Delay over false alarms of what watches a tracker, while the threshold is swept.

A test is not judged by one threshold: a lower one is sooner, and more often wrong. Both are counted on one flight, the
false alarms before its fault, the delay from it on. Which alarm is counted is its onset, since an alarm lasts.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.metrics.alarms.detection import detection, onsets
from tracking.conformance import ConformanceTest
from tracking.monitor import NisMonitor
from tracking.track import Track

WINDOWS = (5, 10, 20)  # looks
STATED = tuple(10.0 ** (-0.5 * half) for half in range(1, 13))  # false alarms a look, from one in three to one in 1e6


class OperatingCurve(NamedTuple):
    """What one test does at each of p thresholds, the lowest first."""

    test: str
    stated: np.ndarray  # (p,) false alarms in 1000 looks that the threshold promises
    false_alarms: np.ndarray  # (p,) onsets in 1000 looks before the fault
    delay: np.ndarray  # (p,) s, median over the draws without an alarm at the fault; infinite = half of them miss it
    detected: np.ndarray  # (p,) share of the draws with an alarm from the fault on
    looks: int  # in all draws before the fault: one onset is 1000 / looks


def operating_curves(tracker: Any, track: Track, fault: float) -> list[OperatingCurve]:
    """Curves of the monitor for each of `WINDOWS`, and of the conformance alert where the tracker has intents.

    ``fault`` is when something goes wrong that the tracker is not told, s.
    """
    looked = NisMonitor().watch(track)
    looks = int(looked.looked[looked.time < fault].sum())
    curves = []
    for window in WINDOWS:
        alarms = [NisMonitor(window, rate).watch(track) for rate in STATED]
        curves.append(_curve(f"NIS of {window} looks", [one.alarm for one in alarms], looked.time, fault, looks))
    watched = [ConformanceTest(1.0 / rate).watch(tracker, track) for rate in STATED]
    raised = [one.alarm for one in watched if one is not None]
    if raised:
        curves.append(_curve("conformance alert", raised, np.asarray(track.time), fault, looks))
    return curves


def _curve(test: str, alarms: list[np.ndarray], time: np.ndarray, fault: float, looks: int) -> OperatingCurve:
    found = [detection(alarm, time, fault) for alarm in alarms]
    false = np.array([onsets(alarm)[time < fault].sum() for alarm in alarms])
    return OperatingCurve(
        test,
        1000.0 * np.array(STATED),
        1000.0 * false / looks if looks else np.full(len(false), np.nan),
        np.array([one.median_delay for one in found]),
        np.array([np.nan if one.detected_fraction is None else one.detected_fraction for one in found]),
        looks,
    )
