"""What ``shortfinal identify`` does: a survey of the captures, its files, and its table for a terminal."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from autopilot.law_search import NAMES
from sim.errors import OutputError, printable
from sim.files import claim, refuse_foreign, staged, write_json
from sim.studies.identification.law_file import law_text
from sim.studies.identification.page import page
from sim.studies.identification.sources import flights_of
from sim.studies.identification.spread import SHARES
from sim.studies.identification.survey import KEYS, Survey, as_json, cells, digits, scaled, sentence, survey, why

PAGE, LAW, NUMBERS = "identification.html", "law.toml", "identification.json"


def identify_to_folder(
    source: Path,
    runway: Path | None,
    out: Path | None,
    leg: int | None = None,
    plugins: Any = (),
    progress: Callable[..., Any] | None = None,
) -> tuple[Path, Survey]:
    """Identify all captures of a file of recordings or of a run, and write what was found into a folder.

    law.toml is written where the captures that a law explains tell every number of it. Raises ``OutputError`` or
    ``ScenarioError`` in a sentence for what holds no flight.
    """
    folder = out if out is not None else Path("out") / f"identify_{source.stem}"
    refuse_foreign(folder, "identification")
    flights = flights_of(source, runway, plugins)
    if not flights:
        raise OutputError(f"{source}: holds no flight")
    found = survey(printable(source.name), flights, leg, progress)
    law = law_text(found)
    claim(folder, "identification")
    with staged(folder) as place:
        write_json(place / NUMBERS, as_json(found))
        (place / PAGE).write_text(page(found, law), encoding="utf-8")
        if law is not None:
            (place / LAW).write_text(law, encoding="utf-8")
    if law is None:
        (folder / LAW).unlink(missing_ok=True)  # of an earlier survey
    return folder, found


def told(found: Survey) -> list[list[str]]:
    """Rows of the table for a terminal: each capture, then the quantiles of all that are explained."""
    heads = [KEYS[name][0] for name in NAMES]
    rows = [["capture", "", "z_m", "bank_deg", *heads, "why"]]
    for name, fit in found.fits.items():
        residuals = [f"{fit.cross_track_rms:.1f}", f"{math.degrees(fit.bank_rms):.1f}"]
        verdict = "explained" if fit.explained else "not"
        rows.append([printable(name), verdict, *residuals, *cells(fit), "; ".join(why(fit))])
    if found.explained > 1:
        for place, share in enumerate(SHARES):
            numbers = [scaled(name, found.spread[name].quantiles[place]) for name in NAMES]
            shown = ["-" if math.isnan(number) else digits(number) for number in numbers]
            rows.append([f"{100 * share:g} %", "", "", "", *shown, ""])
    return rows


def summary(found: Survey, table: Callable[[list[Any], int], list[str]]) -> str:
    """The text for a terminal; ``table`` aligns rows."""
    lines = [f"{found.source}: {sentence(found)}"]
    if found.fits:
        lines += ["", *table(told(found), 2)]
    return "\n".join([*lines, *(f"{printable(name)}: no capture: {why}" for name, why in found.refused.items())])
