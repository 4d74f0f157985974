"""MADAP, an outside judge: the published errors of operational trackers beside those of ours on the same manoeuvres."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from sim.claims.ledger import Claim, Reading
from sim.claims.papers.madap.experiment import NAMES, SEVERAL, SINGLE, error, share
from sim.claims.verdict import Printed, number

NOTES = {
    "imm": "Radar sites are ours. Default densities; turns at 10, 25, 40 and 55 deg of bank to either side: the "
    "aircraft of the benchmark are of any kind. Sets of four or five banks differ little; with two or three speed is "
    "wrong by 6 to 8 kt, with the turns of a landing pattern, at 15 deg, by 10.",
    "constant_velocity": "Radar sites are ours. Density 10 m2/s3.",
    "intent_imm": "Radar sites are ours. Told the first straight and the nominal law, of which the turn knows nothing.",
    "told_turn": "Radar sites are ours. A filter that is told the rate of each turn, which no radar is: what the sites "
    "leave to be wrong.",
}


def rows_of(name: str, words: str, printed: Printed, unit: str, where: str, measure: Any) -> Iterator[Claim]:
    """The row that is judged, of the improved models, and the one beside it."""
    for tracker in NAMES:
        judged = tracker == "imm"
        yield Claim(
            name if judged else f"{name}_{tracker}",
            words,
            where,
            printed,
            (Reading(tracker.replace("_", " "), measure(tracker)),),
            unit,
            truth="kinematic",
            geometry_by="ours",
            first_runs=10,
            overlooked=not judged,
            note=NOTES[tracker],
        )


def _claims() -> Iterator[Claim]:
    for side, radars, where, figures in (
        ("single", SINGLE, "single radar", ("0.13", "0.13", "12.7", "12.2")),
        ("multi", SEVERAL, "multi-radar", ("0.06", "0.08", "4.4", "9.4")),
    ):
        kinds = (
            ("position", "position", "mean", "NM"),
            ("position_sigma", "position", "sigma", "NM"),
            ("speed", "speed", "rms", "kt"),
            ("heading", "heading", "rms", "deg"),
        )
        for (name, quantity, statistic, unit), printed in zip(kinds, figures, strict=True):
            yield from rows_of(
                f"{side}_{name}",
                f"{quantity} error, {statistic}, {where}",
                number(printed, -1),
                unit,
                where,
                lambda tracker, q=quantity, s=statistic, r=radars: error(q, s, r, tracker),
            )
    for name, quantity, limits, unit, several, single in (
        ("position_shares", "position", (0.25, 1.0), "NM", ("99.5", "100"), ("95.9", "100")),
        ("speed_shares", "speed", (20.0, 70.0), "kt", ("99.6", "100"), ("95.1", "99.4")),
        ("heading_shares", "heading", (10.0, 90.0), "deg", ("98.0", "99.9"), ("95.9", "99.8")),
    ):
        for radars, where, both in ((SEVERAL, "multi-radar", several), (SINGLE, "single radar", single)):
            for turning, limit, printed in zip((False, True), limits, both, strict=True):
                part = "manoeuvres" if turning else "straights"
                suffix = ("" if radars is SEVERAL else "_single") + ("_manoeuvre" if turning else "")
                yield from rows_of(
                    name + suffix,
                    f"{quantity} within {limit:g} {unit} on {part}, {where}",
                    number(printed, 1),
                    "%",
                    where,
                    lambda tracker, q=quantity, m=limit, t=turning, r=radars: share(q, m, t, r, tracker),
                )


CLAIMS: tuple[Claim, ...] = tuple(_claims())
