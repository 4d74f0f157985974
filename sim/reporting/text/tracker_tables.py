"""The trackers side by side: one table for each channel, one for consistency, one for the look-ahead."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from sim.metrics.conformance import MISMATCHED
from sim.reporting.text.best_tracker import MOST_LOST
from sim.reporting.text.labels import ABSENT, column, decimals, number, split, words

TIMES = " ×"


class Table(NamedTuple):
    """A table of text: the first ``lefts`` columns are words, the others numbers."""

    caption: str
    header: list[str]
    rows: list[list[str]]
    lefts: int = 1
    best: frozenset[tuple[int, int]] = frozenset()  # (row, column) of the best values of their columns
    lost: frozenset[int] = frozenset()  # rows of trackers that lost the target


def tracker_tables(trackers: dict[str, dict[str, Any]]) -> list[Table]:
    """Tables of the summary of every tracker, as in metrics.json."""
    trackers = beside_twins(trackers)
    channels = list(dict.fromkeys(channel for t in trackers.values() for channel in t.get("overall") or {}))
    tables = [_channel(trackers, channel) for channel in channels]
    return [*tables, _consistency(trackers), *_recorded(trackers), *_look_ahead(trackers)]


def beside_twins(trackers: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """The trackers in their order, those with a mismatched law behind the first of their kind that has its own."""
    first: dict[Any, str] = {}
    for who, t in trackers.items():
        if t.get("law_from") != MISMATCHED:
            first.setdefault(t.get("kind"), who)
    names = list(trackers)

    def place(who: str) -> tuple[int, bool]:
        t = trackers[who]
        twin = t.get("law_from") == MISMATCHED
        return names.index(first.get(t.get("kind"), who) if twin else who), twin

    return {who: trackers[who] for who in sorted(names, key=place)}


def _marked(table: Table, trackers: dict[str, dict[str, Any]], aims: Sequence[str]) -> Table:
    """The table with its best values and lost trackers.

    ``aims`` says of each column what is best: "least", "most", "one" (as near 1 as can be) or nothing. A lost tracker
    is not best, and where all are alike none is.
    """
    lost = frozenset(i for i, t in enumerate(trackers.values()) if (t.get("lost_fraction") or 0.0) > MOST_LOST)
    best: set[tuple[int, int]] = set()
    for place, aim in enumerate(aims):
        read = {i: _read(row[place]) for i, row in enumerate(table.rows) if i not in lost}
        known = {i: value for i, value in read.items() if value is not None}
        if not aim or len(known) < 2 or len(set(known.values())) < 2:
            continue
        keys = {i: _AIMS[aim](value) for i, value in known.items()}
        best |= {(i, place) for i, key in keys.items() if key == min(keys.values())}
    return table._replace(best=frozenset(best), lost=lost)


_AIMS: dict[str, Callable[[float], float]] = {
    "least": lambda value: value,
    "most": lambda value: -value,
    "one": lambda value: abs(math.log(value)) if value > 0.0 else math.inf,
}


def _read(cell: str) -> float | None:
    """The number that a cell prints; None where it prints none."""
    text = cell.removesuffix(TIMES).replace("−", "-")
    try:
        return float(text)
    except ValueError:
        return None


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
    rows = [[words(who), _law(t), *(values[i] for values in columns)] for i, (who, t) in enumerate(chosen.items())]
    header = ["tracker", "law from", "RMSE", "interval", "raw", "gain", "of the gain", *(words(p) for p in phases)]
    table = Table(f"{words(name).capitalize()}, {unit}: root mean square error overall and by phase", header, rows, 2)
    return _marked(table, chosen, ["", "", "least", "", "", "most", "", *("least" for _ in phases)])


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
            words(who),
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
    caption = "Consistency: 1 where errors are as large as the tracker says, above 1 where it is too sure of itself"
    return _marked(Table(caption, header, rows, 2), trackers, ["", "", "one", "", "one", "least", ""])


def _recorded(trackers: dict[str, dict[str, Any]]) -> list[Table]:
    """How whole the tracks are that were made elsewhere."""
    made = {who: t["track"] for who, t in trackers.items() if t.get("track")}
    rows = [
        [
            words(who),
            _percent(t["completeness"]),
            _percent(t["begun_fraction"]),
            number(_real(t["initiation_s"]), 1),
            number(_real(t["longest_gap_s"]), 1),
            number(_real(t["number_changes"]), 2),
            _percent(t["redundant_fraction"]),
        ]
        for who, t in made.items()
    ]
    header = [
        "tracker", "looks taken up, %", "draws begun, %", "first estimate after, s", "longest gap, s",
        "changes of number", "with two tracks, %",
    ]  # fmt: skip
    return [Table("Recorded tracks: how whole they are", header, rows)] if rows else []


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
        rows = [[words(who), *(values[i] for values in columns)] for i, who in enumerate(able)]
        header = ["tracker", *(f"{span.replace('_', ' ')} ahead" for span in spans)]
        table = Table(f"Look-ahead of {words(name)}, {unit}: root mean square error", header, rows)
        tables.append(_marked(table, able, ["", *("least" for _ in spans)]))
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
