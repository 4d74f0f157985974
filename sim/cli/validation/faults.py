"""What every layer says of a scenario file: TOML, tables and keys, values, names, aircraft, preparation.

A layer goes on with what those before it left sound, so that one fault does not hide the others.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from sim.cli.validation.lines import line_of, lines
from sim.errors import OutputError, ScenarioError, did_you_mean
from sim.estimation.setup import check
from sim.experiment import read, refuse_unfit_run
from sim.flight.preparation import prepare
from sim.scenario import reading
from sim.scenario.messages import MOST_FAULTS
from sim.scenario.plugins import Catalogue
from sim.studies.plan import plan

STDIN = "-"
MORE = re.compile(r"and \d+ more faults")
AT_LINE = re.compile(r" \(at line (\d+), column \d+\)")


class Verdict(NamedTuple):
    """What is said of one file."""

    name: str
    faults: list[str]  # each with its place; empty = it can be flown
    warnings: tuple[str, ...] = ()


def validate(source: str, overrides: dict[str, Any], catalogue: Catalogue) -> Verdict:
    """All faults of a scenario file, of a bundled scenario, or of standard input, ``-``."""
    try:
        origin, content, path = reading.content_of(source) if source != STDIN else _standard_input()
    except ScenarioError as error:
        return Verdict(source, str(error).splitlines())
    text = content.decode("utf-8-sig", errors="replace")
    try:
        tables, syntax = reading.parsed(origin, content), list[str]()
    except ScenarioError as error:
        tables, syntax = _recovered(text, str(error).removeprefix(f"{origin}: "))
    faults: list[str] = []
    warnings: tuple[str, ...] = ()
    name = origin
    if tables:
        faults, warnings, name = _of_tables(tables, path, overrides, catalogue)
        if syntax:  # what is missing may stand on a line that cannot be read
            faults = [fault for fault in faults if "is missing" not in fault]
    elif not syntax:
        faults = ["says nothing; 'shortfinal new FILE.toml' writes a scenario to start from"]
    found = lines(text)
    told = []
    for fault in dict.fromkeys([*syntax, *faults]):
        at, number = AT_LINE.search(fault), line_of(fault, found)
        number = int(at[1]) if at is not None else number
        number = 0 if number is None else number
        order = math.inf if MORE.fullmatch(fault) else number
        told.append((order, f"{origin}:{number}: {fault}" if number else f"{origin}: {fault}"))
    return Verdict(name, [fault for _, fault in sorted(told, key=lambda one: one[0])], warnings)


def _standard_input() -> tuple[str, bytes, Path | None]:
    try:
        content = sys.stdin.buffer.read(reading.LARGEST_FILE + 1)
    except OSError as error:
        raise OutputError(f"standard input: cannot be read: {error.strerror}") from None
    if len(content) > reading.LARGEST_FILE:
        raise ScenarioError(f"standard input: larger than {reading.LARGEST_FILE} bytes, which no scenario is")
    return "stdin", content, Path("stdin.toml")


def _recovered(text: str, first: str) -> tuple[dict[str, Any], list[str]]:
    """The tables of a text without the lines that are no TOML, and what is wrong with those; none where a header is."""
    rows, faults, last = text.splitlines(), [first], 0
    while len(faults) <= MOST_FAULTS:
        at = AT_LINE.search(faults[-1])
        number = int(at[1]) if at is not None else 0
        if not 0 < number <= len(rows) or (last and number <= last + 1) or rows[number - 1].lstrip().startswith("["):
            return {}, faults[:-1] if last and number in (
                last,
                last + 1,
            ) else faults  # what follows from the one before
        rows[number - 1], last = "", number
        try:
            return reading.parsed("", "\n".join(rows).encode()), faults
        except ScenarioError as error:
            faults.append(str(error).removeprefix(": "))
    return {}, faults


def _of_tables(
    tables: dict[str, Any], path: Path | None, overrides: dict[str, Any], catalogue: Catalogue
) -> tuple[list[str], tuple[str, ...], str]:
    """Faults and warnings of the tables of a file, and the name of their scenario."""
    faults: list[str] = []
    tables = reading.placed(tables, path)

    def said(layer: Callable[[], Any]) -> Any:
        try:
            return layer()
        except ScenarioError as error:
            faults.extend(_without_origin(line) for line in str(error).splitlines())
            return None

    scenario = said(lambda: read(tables, overrides, plugins=catalogue))
    if scenario is None:
        faults += [*_contrasted(tables), *_aircraft(tables, faults)]
        return faults, (), str(tables.get("name"))
    prepared = said(lambda: prepare(scenario))
    if prepared is not None:
        said(lambda: check(prepared))
    said(lambda: refuse_unfit_run(scenario) if scenario.study is None else plan(scenario, catalogue))
    return faults, () if prepared is None else prepared.warnings, scenario.name


def _without_origin(line: str) -> str:
    """A fault without the scenario that it is about, which the file stands for."""
    head, _, rest = line.partition(": ")
    named = re.fullmatch(r"[A-Za-z][\w-]*", head) is not None and rest.startswith("[")
    return rest if named or head == "scenario" else line


def _contrasted(tables: dict[str, Any]) -> list[str]:
    """Contrasts of trackers that a file with other faults does not have."""
    trackers, contrasts = tables.get("trackers"), tables.get("contrasts")
    if not isinstance(trackers, dict) or not trackers or not isinstance(contrasts, list):
        return []
    return [
        f"[[contrasts]] entry {number} {side}: no tracker '{one[side]}'; {did_you_mean(one[side], trackers)}"
        for number, one in enumerate(contrasts)
        for side in ("of", "against")
        if isinstance(one, dict) and isinstance(one.get(side), str) and one[side] not in trackers
    ]


def _aircraft(tables: dict[str, Any], faults: list[str]) -> list[str]:
    """What is wrong with the aircraft of a file that cannot be prepared for its other faults."""
    own = tables.get("aircraft")
    if not isinstance(own, dict) or any(fault.startswith("[aircraft]") for fault in faults):
        return []
    try:
        prepare(read({"name": "scenario", "aircraft": own}))
    except ScenarioError as error:  # of its route it is not asked here
        told = [_without_origin(line) for line in str(error).splitlines()]
        return [fault for fault in told if fault.startswith("[aircraft]")]
    return []
