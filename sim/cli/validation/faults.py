"""What every layer says of a scenario file: TOML, tables and keys, values, names, aircraft, preparation.

A layer goes on with what those before it left sound, so that one fault does not hide the others.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

from sim.cli.validation.lines import line_of, lines
from sim.cli.validation.sound import Rest
from sim.errors import OutputError, ScenarioError
from sim.estimation.setup import check
from sim.experiment import read, refuse_unfit_run
from sim.flight.preparation import prepare
from sim.scenario import reading
from sim.scenario.messages import MOST_FAULTS
from sim.scenario.plugins import Catalogue
from sim.studies.plan import plan

STDIN = "-"
FLOWN = ("aircraft", "route", "runway", "record")  # tables without which another flight is judged
WITH_ROUTE = ("start", "autopilot")  # tables that make no sense with another one
ASKED = ("[trackers", "[[contrasts]]", "[[checks]]")  # what holds whatever flies
MOST_ROUNDS = 6  # of taking out what is at fault, and asking again
MORE = re.compile(r"and \d+ more faults")
OPEN_HEADER = re.compile(r"\s*(\[\[?)\s*([\w.-]+)\s*\]?\s*$")
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
        tables, text, syntax = _recovered(text, str(error).removeprefix(f"{origin}: "))
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
        at, number = AT_LINE.search(fault), line_of(fault, text, found)
        if (given := _of_command_line(fault, overrides)) is not None:
            told.append((0.0, f"{origin}: {given}"))
            continue
        number = int(at[1]) if at is not None else number
        number = 0 if number is None else number
        order = math.inf if MORE.fullmatch(fault) else number
        told.append((order, f"{origin}:{number}: {fault}" if number else f"{origin}: {fault}"))
    return Verdict(name, [fault for _, fault in sorted(told, key=lambda one: one[0])], warnings)


def _of_command_line(fault: str, overrides: Iterable[str]) -> str | None:
    """A fault of a value that ``--set`` gave, as that; None of all others."""
    for address in overrides:
        table, _, key = address.rpartition(".")
        head = f"[{table}] {key}: " if table else f"{key}: "
        if fault.startswith(head):
            return f"--set {address}: {fault.removeprefix(head)}"
    return None


def _standard_input() -> tuple[str, bytes, Path | None]:
    try:
        content = sys.stdin.buffer.read(reading.LARGEST_FILE + 1)
    except OSError as error:
        raise OutputError(f"standard input: cannot be read: {error.strerror}") from None
    if len(content) > reading.LARGEST_FILE:
        raise ScenarioError(f"standard input: larger than {reading.LARGEST_FILE} bytes, which no scenario is")
    return "stdin", content, Path("stdin.toml")


def _recovered(text: str, first: str) -> tuple[dict[str, Any], str, list[str]]:
    """The tables of a text without the lines that are no TOML, what is left of it, and what is wrong with those.

    The header of a table is closed where it is open: what follows it belongs to that table.
    """
    rows, faults, last = text.splitlines(), [first], 0
    while len(faults) <= MOST_FAULTS:
        at = AT_LINE.search(faults[-1])
        number = int(at[1]) if at is not None else 0
        if last and number in (last, last + 1):  # it follows from the one before
            return {}, text, faults[:-1]
        mended = _closed(rows[number - 1]) if 0 < number <= len(rows) else None
        if mended is None:
            break
        rows[number - 1], last = mended, number
        try:
            return reading.parsed("", "\n".join(rows).encode()), "\n".join(rows), faults
        except ScenarioError as error:
            faults.append(str(error).removeprefix(": "))
    return {}, text, faults


def _closed(line: str) -> str | None:
    """What a line that is no TOML becomes: nothing, or the header that it is meant to be; None = nobody knows which."""
    header = OPEN_HEADER.match(line)
    if header is None:
        return None if line.lstrip().startswith("[") else ""
    return f"{header[1]}{header[2]}{']' * len(header[1])}"


def _of_tables(
    tables: dict[str, Any], path: Path | None, overrides: dict[str, Any], catalogue: Catalogue
) -> tuple[list[str], tuple[str, ...], str]:
    """Faults and warnings of the tables of a file, and the name of their scenario."""
    tables = reading.placed(tables, path)
    name = str(tables.get("name"))
    try:
        for address, value in overrides.items():
            tables = reading.override(tables, address, value)
    except ScenarioError as error:
        return [str(error)], (), name
    rest, told = Rest(tables), list[str]()
    for _ in range(MOST_ROUNDS):
        found, warnings = _of_layers(rest, catalogue)
        if not found:
            return told, () if told else warnings, name
        told += [fault for fault in map(rest.numbered, found) if fault not in told and not rest.is_echo(fault)]
        if any(MORE.fullmatch(fault) for fault in found):
            break
        before = rest.gone.copy()
        rest.without(found)
        if rest.gone == before:
            break
    return told, (), name


def _of_layers(rest: Rest, catalogue: Catalogue) -> tuple[list[str], tuple[str, ...]]:
    """Faults, and warnings, of the first layer that has any.

    Where what is flown was taken out, a default flies in its place: of that only trackers, checks and such are asked.
    """
    faults: list[str] = []
    flown = [name for name in FLOWN if rest.lacks((name,))]

    def said(layer: Callable[[], Any]) -> Any:
        try:
            return layer()
        except ScenarioError as error:
            faults.extend(_without_origin(line) for line in str(error).splitlines())
            return None

    tables = {key: own for key, own in rest.tables.items() if not flown or key not in WITH_ROUTE}
    scenario = said(lambda: read(tables, plugins=catalogue))
    if scenario is None:
        return faults, ()
    prepared = said(lambda: prepare(scenario))
    if prepared is not None and not rest.lacks(("sensors",)):
        said(lambda: check(prepared))
    if flown:
        asked = ASKED if "aircraft" in flown else (*ASKED, "[aircraft]")
        return [fault for fault in faults if fault.startswith(asked)], ()
    said(lambda: refuse_unfit_run(scenario) if scenario.study is None else plan(scenario, catalogue))
    return faults, () if prepared is None else prepared.warnings


def _without_origin(line: str) -> str:
    """A fault without the scenario that it is about, which the file stands for."""
    head, _, rest = line.partition(": ")
    named = re.fullmatch(r"[A-Za-z][\w-]*", head) is not None and rest.startswith("[")
    return rest if named or head == "scenario" else line
