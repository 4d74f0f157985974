"""Does each tracker still follow what it measures? Figures of the monitor of its innovations.

The stated rate is that of a tracker whose model holds, with a linear Gaussian measurement. Before anything goes wrong a
tracker may alarm more often: one that knows no turns alarms in each of them, and so do one that is told the wrong law
and one that is lost. That is a figure of the tracker, and where it is large a delay says little: the alarm may have
come for another reason.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.flight.record import Flight
from sim.metrics.alarms.detection import detection, onsets, percentiles
from sim.metrics.error_curves import pooled, windows
from tracking.monitor import MONITOR
from tracking.track import Track


def figures(track: Track, fault: float | None) -> dict[str, Any]:
    """The table ``monitor`` of metrics.json.

    ``fault`` is when something goes wrong that the tracker is not told, s: the law is left, or one of its sensors
    measures worse than it states; None = never. ``alarms_per_1000`` counts the alarmed looks among a thousand before
    it, as the rate is stated; neighbouring windows overlap, so that an alarm lasts: ``onsets_per_1000`` counts each
    once. Delays are over the draws that had no alarm at that time.
    """
    time, looked, alarm = MONITOR.watch(track)
    before = time < (np.inf if fault is None else fault)
    looks = int(looked[before].sum())
    found = detection(alarm, time, fault)
    return {
        "window": MONITOR.window,
        "stated_per_1000": 1000.0 * MONITOR.false_alarm_rate,
        "alarms_per_1000": _per_1000(alarm & looked, before, looks),
        "onsets_per_1000": _per_1000(onsets(alarm), before, looks),
        "fault_s": fault,
        "detected_fraction": found.detected_fraction,
        "delay_s": percentiles(found.delays),
    }


def _per_1000(counted: np.ndarray, before: np.ndarray, looks: int) -> float | None:
    return 1000.0 * float(counted[before].sum()) / looks if looks else None


class AlarmShare(NamedTuple):
    """How large a share of the draws is alarmed, over w short windows of time."""

    time: np.ndarray  # (w,) s
    share: np.ndarray  # (w,)


def alarm_share(flight: Flight, track: Track) -> AlarmShare:
    """The monitor's alarms on a track as a figure can show them."""
    time, _, alarm = MONITOR.watch(track)
    if not len(time):
        return AlarmShare(np.empty(0), np.empty(0))
    edges = windows(time, 0, flight, alarm.shape[1])
    return AlarmShare(pooled(time, edges), pooled(alarm, edges))
