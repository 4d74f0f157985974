"""Trackers side by side where no truth is known: what their innovations, later plots and the other trackers say."""

from __future__ import annotations

from typing import Any

from sim.reporting.text.labels import ABSENT, column, number, words
from sim.reporting.text.tracker_tables import Table

ALONE = "No truth: figures from the plots alone"


def plot_tables(trackers: dict[str, dict[str, Any]]) -> list[Table]:
    """Tables of the trackers that have figures from plots alone; none where a truth is known."""
    known = {who: its["plots"] for who, its in trackers.items() if its.get("plots")}
    if not known:
        return []
    return [_innovations(trackers, known), *_look_ahead(known), *_agreement(known)]


def _innovations(trackers: dict[str, dict[str, Any]], known: dict[str, dict[str, Any]]) -> Table:
    header = ["tracker", "kind", "ANIS", "if consistent", "correlation", "if white", "plots", "longest gap, s"]
    header += ["track, s", "of the time, %", "lost at, s"]
    rows = [
        [
            words(who),
            words(str(trackers[who]["kind"])),
            number(trackers[who]["anis"], 2),
            f"{number(its['anis_low'], 2)} … {number(its['anis_high'], 2)}",
            number(its["whiteness"], 2),
            f"± {number(its['whiteness_limit'], 2)}",
            str(its["looks"]),
            number(its["gap_max_s"], 1),
            number(its["length_s"], 0),
            ABSENT if its["continuity"] is None else number(100.0 * its["continuity"], 1),
            number(its["lost_time_s"], 0),
        ]
        for who, its in known.items()
    ]
    caption = (
        f"{ALONE}: innovations, their ANIS 1 where they are as large as the tracker says, the correlation of "
        "neighbouring ones 0 where they are white; how long each track lasted, of the time of the plots"
    )
    return Table(caption, header, rows, 2)


def _look_ahead(known: dict[str, dict[str, Any]]) -> list[Table]:
    spans = list(dict.fromkeys(span for its in known.values() for span in its["look_ahead"]))
    if not spans:
        return []
    columns, header = [], ["tracker"]
    for span in spans:
        found = [its["look_ahead"].get(span, {}) for its in known.values()]
        columns += [
            column([one.get("rmse_m") for one in found]),
            [number(one.get("normalised"), 2) for one in found],
        ]
        header += [f"{span.replace('_', ' ')} ahead, m", "normalised"]
    rows = [[words(who), *(values[i] for values in columns)] for i, who in enumerate(known)]
    caption = (
        "Look-ahead: root mean square distance of later plots, whose own errors are in it, from their prediction; "
        "normalised by both covariances it is 1 where they are right"
    )
    return [Table(caption, header, rows)]


def _agreement(known: dict[str, dict[str, Any]]) -> list[Table]:
    names = [who for who, its in known.items() if its["agreement_m"]]
    if len(names) < 2:
        return []
    rows = [[words(who), *column([known[who]["agreement_m"].get(other) for other in names])] for who in names]
    return [
        Table("Agreement, m: root mean square distance between two trackers", ["tracker", *map(words, names)], rows)
    ]
