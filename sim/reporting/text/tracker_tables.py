"""The trackers side by side: one table for each channel, one for consistency, one for the look-ahead."""

from __future__ import annotations

from typing import Any, NamedTuple

from sim.metrics.conformance import MISMATCHED
from sim.reporting.text.labels import ABSENT, column, decimals, number, split, words

TIMES = " ×"


class Table(NamedTuple):
    """A table of text: the first ``lefts`` columns are words, the others numbers."""

    caption: str
    header: list[str]
    rows: list[list[str]]
    lefts: int = 1


def tracker_tables(trackers: dict[str, dict[str, Any]]) -> list[Table]:
    """Tables of the summary of every tracker, as in metrics.json."""
    channels = list(dict.fromkeys(channel for t in trackers.values() for channel in t.get("overall") or {}))
    tables = [_channel(trackers, channel) for channel in channels]
    return [*tables, _consistency(trackers), *_look_ahead(trackers)]


def _channel(trackers: dict[str, dict[str, Any]], channel: str) -> Table:
    """RMSE of one channel: overall with its interval, beside the raw measurement, and by phase."""
    name, unit = split(channel)
    chosen = {who: t for who, t in trackers.items() if channel in (t.get("overall") or {})}
    phases = list(
        dict.fromkeys(p for t in chosen.values() for p, by in (t.get("by_phase") or {}).items() if channel in by)
    )
    overall = [t["overall"][channel] for t in chosen.values()]
    rmse = column([f.get("rmse") for f in overall])
    columns = [
        rmse,
        [_interval(f, rmse[i]) for i, f in enumerate(overall)],
        column([f.get("raw") for f in overall]),
        (gain := [_times(f.get("gain")) for f in overall]),
        [
            _interval({"low": f.get("gain_low"), "high": f.get("gain_high")}, like)
            for f, like in zip(overall, gain, strict=True)
        ],
        *(
            column([(t.get("by_phase") or {}).get(p, {}).get(channel, {}).get("rmse") for t in chosen.values()])
            for p in phases
        ),
    ]
    rows = [[who, _law(t), *(values[i] for values in columns)] for i, (who, t) in enumerate(chosen.items())]
    header = ["tracker", "law from", "RMSE", "interval", "raw", "gain", "of the gain", *(words(p) for p in phases)]
    return Table(f"{words(name).capitalize()}, {unit}: root mean square error overall and by phase", header, rows, 2)


def _interval(figure: dict[str, Any], like: str) -> str:
    """Ends of the interval with as many decimals as the figure between them."""
    low, high = figure.get("low"), figure.get("high")
    if low is None or high is None:
        return ABSENT
    places = len(like.removesuffix(TIMES).partition(".")[2])
    return f"{number(float(low), places)} … {number(float(high), places)}"


def _times(gain: float | None) -> str:
    return ABSENT if gain is None else f"{number(float(gain), 2)}{TIMES}"


def _law(tracker: dict[str, Any]) -> str:
    found = tracker.get("law_from")
    return "mismatched law" if found == MISMATCHED else str(found or ABSENT)


def _consistency(trackers: dict[str, dict[str, Any]]) -> Table:
    """Whether the trackers know how good they are, and whether they kept the target."""
    rows = [
        [
            who,
            words(str(t.get("kind", ""))),
            (anees := _share(t.get("anees"))),
            _interval({"low": t.get("anees_low"), "high": t.get("anees_high")}, anees),
            _share(t.get("anis")),
            _percent(t.get("lost_fraction")),
            number(_real(t.get("lost_time_s")), 0),
        ]
        for who, t in trackers.items()
    ]
    header = ["tracker", "kind", "ANEES", "interval", "ANIS", "lost, %", "first lost at, s"]
    return Table(
        "Consistency: 1 where errors are as large as the tracker says, above 1 where it is too sure of itself",
        header,
        rows,
        2,
    )


def _look_ahead(trackers: dict[str, dict[str, Any]]) -> list[Table]:
    """RMSE of the predicted position, where it was asked for."""
    spans = list(dict.fromkeys(span for t in trackers.values() for span in t.get("look_ahead") or {}))
    channels = list(
        dict.fromkeys(c for t in trackers.values() for by in (t.get("look_ahead") or {}).values() for c in by)
    )
    tables = []
    for channel in channels:
        name, unit = split(channel)
        able = {who: t for who, t in trackers.items() if any(_rmse(t, span, channel) is not None for span in spans)}
        columns = [column([_rmse(t, span, channel) for t in able.values()]) for span in spans]
        rows = [[who, *(values[i] for values in columns)] for i, who in enumerate(able)]
        header = ["tracker", *(f"{span.replace('_', ' ')} ahead" for span in spans)]
        tables.append(Table(f"Look-ahead of {words(name)}, {unit}: root mean square error", header, rows))
    return tables


def _rmse(tracker: dict[str, Any], span: str, channel: str) -> float | None:
    figure = (tracker.get("look_ahead") or {}).get(span, {}).get(channel)
    return _real(figure.get("rmse") if isinstance(figure, dict) else figure)


def _share(value: float | None) -> str:
    """A figure that should be 1, to a hundredth; a lost tracker's is large, and its decimals mean nothing."""
    return number(_real(value), min(2, decimals(value)))


def _real(value: Any) -> float | None:
    return None if value is None else float(value)


def _percent(share: float | None) -> str:
    return ABSENT if share is None else number(100.0 * share, 1)
