"""Checks judge a flight: how far from each limit it stayed, when it came nearest, and where the limit comes from."""

from __future__ import annotations

from typing import Any

import numpy as np

from aircraft.units import SUFFIXES
from autopilot.approach import PHASES
from sim.errors import ScenarioError, did_you_mean
from sim.flight.outcomes import ROLLOUT
from sim.flight.record import RECORD_STEP, Flight
from sim.metrics import signals, table
from sim.scenario.tables import Check, Runway

EVERYWHERE = ("all", "gate")  # what ``during`` accepts besides the names of phases
OF_TRACKERS = "trackers."  # figures whose names depend on the scenario
RATIOS = ("gain", "gain_low", "gain_high")  # figures of a tracker's channel that are no quantity of the channel


def evaluate_checks(
    checks: tuple[Check, ...], flight: Flight, runway: Runway, metrics: dict[str, Any]
) -> list[dict[str, Any]]:
    """The result of every check, as in metrics.json.

    A check whose phases were never flown has ``passed`` None; a scalar that the flight does not have fails.
    """
    found = []
    for check in checks:
        signal = signals.find(check.metric)
        found.append(_scalar(check, metrics) if signal is None else _signal(check, signal, flight, runway))
    return found


def unknown_names(tables: dict[str, Any]) -> list[str]:
    """Faults of ``[[checks]]`` and ``[[study.checks]]`` that name a metric or a phase that no flight has.

    ``tables`` are those of the file as it was read: any other fault of theirs is reported by the reader.
    """
    figures, study = table.names(), tables.get("study")
    faults = []
    for place, entries, metrics in (
        ("[[checks]]", tables.get("checks"), (*signals.names(), *figures)),
        ("[[study.checks]]", study.get("checks") if isinstance(study, dict) else None, figures),
    ):
        for i, entry in enumerate(entries if isinstance(entries, list | tuple) else ()):
            if isinstance(entry, dict):
                faults += [f"{place} entry {i} {fault}" for fault in _unknown(entry, metrics)]
    return faults


def with_examples(schema: dict[str, Any]) -> dict[str, Any]:
    """The JSON Schema of a scenario file with the names that checks accept as examples, which editors offer."""
    figures = table.names()
    offered = {"Check": {"metric": (*signals.names(), *figures), "during": (*EVERYWHERE, *PHASES)}}
    offered |= {"StudyCheck": {"metric": figures}}
    parts = dict(schema["$defs"])
    for part, keys in offered.items():
        old = parts[part]["properties"]
        more = {key: {**old[key], "examples": list(examples)} for key, examples in keys.items()}
        parts[part] = {**parts[part], "properties": {**old, **more}}
    return {**schema, "$defs": parts}


def _unknown(entry: dict[str, Any], metrics: tuple[str, ...]) -> list[str]:
    """The metric or phases of one check that do not exist."""
    faults = []
    during, metric, phases = entry.get("during", ()), entry.get("metric"), (*PHASES, *EVERYWHERE)
    for phase in (during,) if isinstance(during, str) else during if isinstance(during, list | tuple) else ():
        if isinstance(phase, str) and phase not in phases:
            faults.append(f"during: no phase '{phase}'; {did_you_mean(phase, phases)}")
    if isinstance(metric, str) and metric not in metrics and not metric.startswith(OF_TRACKERS):
        faults.append(f"metric: no metric '{metric}'; {did_you_mean(metric, metrics)}")
    return faults


def unit_of(metric: str) -> str:
    """Unit suffix of what a check is about: that of its row, or that of a tracker's channel."""
    row = table.find(metric) or signals.find(metric)
    if row is not None:
        return row.unit
    *channel, own = metric.split(".")[2:] or [""]
    if own in RATIOS:
        return RATIOS[0]
    for part in (own, *reversed(channel)):
        endings = [suffix for suffix in SUFFIXES if part.endswith(f"_{suffix}")]
        if endings:
            return max(endings, key=len)
    return ""


def _result(
    check: Check, limit: float, value: float | None, margin: float | None, time: float | None
) -> dict[str, Any]:
    return {
        "name": check.name or check.metric,
        "metric": check.metric,
        "during": check.during if isinstance(check.during, str) else list(check.during),
        "statistic": check.statistic,
        "for_s": check.for_,
        "limit": limit,
        "value": None if value is None else value + 0.0,
        "unit": unit_of(check.metric),
        "margin": None if margin is None else margin + 0.0,  # no minus zero
        "time_s": time,
        "passed": None if margin is None else margin >= 0,
        "source": check.source,
    }


def _scalar(check: Check, metrics: dict[str, Any]) -> dict[str, Any]:
    value = _found(metrics, check.metric.split("."))
    if value is None and check.metric.startswith(OF_TRACKERS):
        raise ScenarioError(f"check of '{check.metric}': no such figure; {_figures(check.metric, metrics)}")
    limit = check.max if check.max is not None else check.min
    assert limit is not None
    if value is None:
        return _result(check, limit, None, None, None) | {"passed": False}
    margins = {
        bound: sign * (bound - float(value)) for bound, sign in ((check.max, 1), (check.min, -1)) if bound is not None
    }
    limit = min(margins, key=lambda bound: margins[bound])
    return _result(check, limit, float(value), margins[limit], None)


def _found(table: Any, parts: list[str]) -> Any:
    """The value at a path of keys, which may contain dots themselves (``radar.azimuth_deg``); None = nothing."""
    if not parts:
        return table
    for count in range(len(parts), 0, -1) if isinstance(table, dict) else ():
        found = _found(table.get(".".join(parts[:count])), parts[count:])
        if found is not None:
            return found
    return None


def _figures(metric: str, metrics: dict[str, Any]) -> str:
    """Figures of a tracker that may have been meant, for "did you mean"."""
    trackers = metrics.get("trackers", {})
    name = metric.split(".")[1]
    if name not in trackers:
        return did_you_mean(name, trackers)
    overall = [f"trackers.{name}.overall.{channel}.rmse" for channel in trackers[name]["overall"]]
    return did_you_mean(metric, overall) if overall else f"tracker '{name}' never saw the aircraft"


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
        limit = check.max if check.max is not None else check.min
        assert limit is not None
        return _result(check, limit, None, None, None)
    return _result(check, nearest[1], nearest[2], nearest[0], nearest[3])


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


UNIT_WORDS = {"mps": "m/s", "mps2": "m/s2", "degps": "deg/s", "": ""}


def phases(check: dict[str, Any]) -> str:
    """The phases of a check in words."""
    during = check["during"]
    return during if isinstance(during, str) else " or ".join(during)


def broken(check: dict[str, Any]) -> str:
    """A check that one flight failed."""
    limit = with_unit(check["limit"], check)
    source = f"; source: {check['source'] or 'not given'}"
    if check["value"] is None:
        return f"{check['name']}: the flight has no {check['metric']}, limit {limit}{source}"
    when = "" if check["time_s"] is None else f" at {check['time_s']:.1f} s"
    statistic = "" if check["statistic"] == "max" else f" ({check['statistic']})"
    lasting = f" for {check['for_s']:g} s" if check["for_s"] else ""
    return (
        f"{check['name']}: {check['metric']}{statistic} = {with_unit(check['value'], check)}{lasting}{when}, "
        f"limit {limit}, beyond it by {with_unit(-check['margin'], check)}{source}"
    )


def broken_in_study(check: dict[str, Any]) -> str:
    """A check that a study failed: how many flights passed it, and which was the worst."""
    limit = with_unit(check["limit"], check)
    kept = f"{check['name']}: {check['within']} of {check['flights']} flights keep {check['metric']}, limit {limit}"
    worst = None if check["value"] is None else with_unit(check["value"], check)
    if check["share"] < 1.0:
        asked = f"{100 * check['share']:g} % with {100 * check['confidence']:g} % confidence"
        kept += f"; {asked} are shown to keep {worst or 'no limit'}"
    elif worst is not None:
        where = ", ".join(f"{name} = {_value(value)}" for name, value in check["at"].items())
        kept += f"; the worst has {worst} with {where}"
    return f"{kept}; source: {check['source'] or 'not given'}"


def with_unit(value: float, check: dict[str, Any]) -> str:
    """Four figures of a value and the unit of its check."""
    return f"{value:.4g} {UNIT_WORDS.get(check['unit'], check['unit'])}".rstrip()


def _value(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
