"""Checks judge one flight: how far from each limit it stayed, when it came nearest, and where the limit comes from.

``sim.metrics.ensemble.verdict`` says what a check comes to over all flights.
"""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from aircraft.units import SUFFIXES
from autopilot import approach
from sim.errors import did_you_mean
from sim.flight.outcomes import ROLLOUT
from sim.flight.record import RECORD_STEP, Flight
from sim.flight.recording import phases as recorded
from sim.metrics import signals, table
from sim.scenario.tables import Check, Runway

PHASES = tuple(dict.fromkeys((*approach.PHASES, *recorded.PHASES)))
EVERYWHERE = ("all", "gate")  # what ``during`` accepts besides the names of phases
OF_TRACKERS, OF_CONTRASTS = "trackers.", "contrasts."  # figures whose names depend on the scenario
RATIOS = ("gain", "gain_low", "gain_high")  # figures of a tracker's channel that are no quantity of the channel


def evaluate_checks(
    checks: tuple[Check, ...], flight: Flight, runway: Runway, metrics: dict[str, Any]
) -> list[dict[str, Any]]:
    """What every check found on one flight: ``value``, ``limit``, ``margin``, ``time_s``, ``passed``.

    A check whose phases were never flown has ``passed`` None; a scalar that the flight does not have fails, but of a
    recorded flight, of which nobody may know it, it is None too. ``metrics`` are the flight's own, with the tables
    ``navigated``, ``trackers`` and ``contrasts``, the latter by pair.
    """
    found = []
    for check in checks:
        signal = signals.find(check.metric)
        found.append(_scalar(check, flight, metrics) if signal is None else _signal(check, signal, flight, runway))
    return found


def unknown_names(tables: dict[str, Any]) -> list[str]:
    """Faults of ``[[checks]]`` that name a metric or a phase that no flight has.

    ``tables`` are those of the file as it was read: any other fault of theirs is reported by the reader.
    """
    entries = tables.get("checks")
    if not entries:
        return []
    metrics, faults = (*signals.names(), *table.names()), []
    for i, entry in enumerate(entries if isinstance(entries, list | tuple) else ()):
        if isinstance(entry, dict):
            faults += [f"[[checks]] entry {i} {fault}" for fault in _unknown(entry, metrics)]
    return faults


def with_names(schema: dict[str, Any]) -> dict[str, Any]:
    """The JSON Schema of a scenario file with the names of metrics and phases that its checks accept."""
    metrics, phases = [*signals.names(), *table.names()], [*EVERYWHERE, *PHASES]
    of_file = "|".join(re.escape(prefix) for prefix in (OF_TRACKERS, OF_CONTRASTS))  # named by the file itself
    phase = {"enum": phases}
    told = {
        "metric": {"anyOf": [{"enum": metrics}, {"type": "string", "pattern": f"^({of_file})"}], "examples": metrics},
        "during": {"anyOf": [phase, {"type": "array", "items": phase, "minItems": 1}], "examples": phases},
    }
    parts = dict(schema["$defs"])
    old = parts["Check"]["properties"]
    more = {key: {**{k: v for k, v in old[key].items() if k != "type"}, **names} for key, names in told.items()}
    parts["Check"] = {**parts["Check"], "properties": {**old, **more}}
    return {**schema, "$defs": parts}


def _unknown(entry: dict[str, Any], metrics: tuple[str, ...]) -> list[str]:
    """The metric or phases of one check that do not exist."""
    faults = []
    during, metric, phases = entry.get("during", ()), entry.get("metric"), (*PHASES, *EVERYWHERE)
    for phase in (during,) if isinstance(during, str) else during if isinstance(during, list | tuple) else ():
        if isinstance(phase, str) and phase not in phases:
            faults.append(f"during: no phase '{phase}'; {did_you_mean(phase, phases)}")
    if isinstance(metric, str) and metric not in metrics and not metric.startswith((OF_TRACKERS, OF_CONTRASTS)):
        faults.append(f"metric: no metric '{metric}'; {did_you_mean(metric, metrics)}")
    return faults


def unit_of(metric: str) -> str:
    """Unit suffix of what a check is about: that of its row, or that of the channel of a tracker or a contrast."""
    row = table.find(metric) or signals.find(metric)
    if row is not None:
        return row.unit
    *channel, own = metric.split(".")[2:] or [""]
    if metric.startswith(OF_CONTRASTS) and own not in ("of", "against"):
        return ""
    if own in RATIOS:
        return RATIOS[0]
    for part in (own, *reversed(channel)):
        endings = [suffix for suffix in SUFFIXES if part.endswith(f"_{suffix}")]
        if endings:
            return max(endings, key=len)
    return ""


def described(check: Check) -> dict[str, Any]:
    """What a check asks, whatever was flown, as in metrics.json."""
    return {
        "name": check.name or check.metric,
        "metric": check.metric,
        "during": check.during if isinstance(check.during, str) else list(check.during),
        "statistic": check.statistic,
        "for_s": check.for_,
        "limit": check.max if check.max is not None else check.min,
        "unit": unit_of(check.metric),
        "source": check.source,
    }


def _result(limit: float | None, value: float | None, margin: float | None, time: float | None) -> dict[str, Any]:
    return {
        "limit": limit,
        "value": None if value is None else value + 0.0,
        "margin": None if margin is None else margin + 0.0,  # no minus zero
        "time_s": time,
        "passed": None if margin is None else margin >= 0,
    }


def _scalar(check: Check, flight: Flight, metrics: dict[str, Any]) -> dict[str, Any]:
    _, value = find(metrics, check.metric)
    if value is None or not math.isfinite(value):
        unknown = flight.is_recorded and not check.metric.startswith((OF_TRACKERS, OF_CONTRASTS))
        absent = _result(check.max if check.max is not None else check.min, None, None, None)
        return absent if unknown else absent | {"passed": False}
    margins = {
        bound: sign * (bound - float(value)) for bound, sign in ((check.max, 1), (check.min, -1)) if bound is not None
    }
    limit = min(margins, key=lambda bound: margins[bound])
    return _result(limit, float(value), margins[limit], None)


def find(metrics: dict[str, Any], metric: str) -> tuple[bool, Any]:
    """Whether there is a figure of this dotted name, and its value; a key may contain dots itself."""
    return _found(metrics, metric.split("."))


def _found(table: Any, parts: list[str]) -> tuple[bool, Any]:
    if not parts:
        known = isinstance(table, int | float)
        return known or table is None, table if known else None
    for count in range(len(parts), 0, -1) if isinstance(table, dict) else ():
        key = ".".join(parts[:count])
        if key in table:
            found = _found(table[key], parts[count:])
            if found[0]:
                return found
    return False, None


def meant(metric: str, metrics: dict[str, Any]) -> list[str]:
    """Figures of the tracker or contrast that a metric names, for "did you mean"; none where it has no figures."""
    return [
        f"{family}{name}.{own}"
        for family, error in ((OF_TRACKERS, "rmse"), (OF_CONTRASTS, "ratio"))
        for name, figures in metrics.get(family.rstrip("."), {}).items()
        if metric.startswith(f"{family}{name}.")
        for own in (
            *(f"overall.{channel}.{error}" for channel in figures.get("overall", ())),
            *(f"monitor.{key}" for key in figures.get("monitor") or ()),
        )
    ]


def _signal(check: Check, signal: signals.Signal, flight: Flight, runway: Runway) -> dict[str, Any]:
    if ROLLOUT in ((check.during,) if isinstance(check.during, str) else check.during):
        flight = flight.whole  # everything else ends with the landing
    values = signal.of(flight, runway)
    if signal.magnitude and check.min is None:
        values = np.abs(values)
    window = flight.during(check.during) & np.isfinite(values)
    nearest: tuple[float, float, float, float] | None = None  # margin, limit, value, time
    for limit, sign in ((check.max, 1.0), (check.min, -1.0)):
        if limit is None:
            continue
        for run in _runs(window):
            found = _worst(sign, values[run], flight.time[run], check)
            if found is not None:
                value, time = sign * found[0], found[1]
                margin = sign * (limit - value)
                if nearest is None or margin < nearest[0]:
                    nearest = (margin, limit, value, time)
    if nearest is None:
        return _result(check.max if check.max is not None else check.min, None, None, None)
    return _result(nearest[1], nearest[2], nearest[0], nearest[3])


def _runs(window: np.ndarray) -> list[slice]:
    """Unbroken stretches of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], window.astype(np.int8), [0]))))
    return [slice(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _worst(sign: float, signal: np.ndarray, time: np.ndarray, check: Check) -> tuple[float, float] | None:
    """The largest ``sign`` times the signal that lasted ``for_s``, and when; None where nothing lasted that long."""
    if check.statistic == "rms":
        return sign * float(np.sqrt(np.mean(signal**2))), float(time[0])
    signal = sign * signal
    if check.statistic == "p95":
        return float(np.percentile(signal, 95)), float(time[0])
    if check.statistic == "mean_5_s":
        width = round(5.0 / RECORD_STEP)
        if len(signal) < width:
            return None
        total = np.concatenate(([0.0], np.cumsum(signal)))
        signal, time = (total[width:] - total[:-width]) / width, time[width - 1 :]
    lasting = round(check.for_ / RECORD_STEP) + 1
    if len(signal) < lasting:
        return None
    # value that holds over [t, t + for_s] = the minimum over that window; valid windows only
    held = np.lib.stride_tricks.sliding_window_view(signal, lasting).min(axis=1)
    worst = int(np.argmax(held))
    return float(held[worst]), float(time[worst])
