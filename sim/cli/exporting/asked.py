"""What ``export`` is asked for: one format a command, with the options that it takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from sim.cli.endings import FLIGHTS_CRASHED, GOOD
from sim.errors import OutputError, printable


class Asked(NamedTuple):
    """One export: of what, and how."""

    folder: Path
    given: Mapping[str, Any]  # options that were given, by their names on the command line
    plugins: Any
    progress: Any


class Answer(NamedTuple):
    """What there is to say, and the exit code."""

    lines: list[str]
    code: int = GOOD


def export(kinds: Mapping[str, bool], asked: Asked) -> Answer:
    """Write one of `KINDS`; ``kinds`` says which were asked for.

    Raises ``OutputError`` in one sentence for none, for several, and for an option that goes with others.
    """
    wanted = [kind for kind, said in kinds.items() if said]
    if not wanted:
        *first, last = (f"--{kind}" for kind in KINDS)
        raise OutputError(f"say what: {', '.join(first)} or {last}")
    if len(wanted) > 1:
        raise OutputError(f"say --{wanted[0]} or --{wanted[1]}, not both: one format a command")
    kind = KINDS[wanted[0]]
    for option in asked.given:
        if option not in kind.takes:
            others = [f"--{name}" for name, one in KINDS.items() if option in one.takes]
            raise OutputError(f"{option} goes with {' and '.join(others)}, not with --{wanted[0]}")
    return kind.write(asked)


def _csv(asked: Asked) -> Answer:
    from sim.cli.exporting.spreadsheet import export_spreadsheet

    given = asked.given
    if "--draw" in given and "--draws" in given:
        raise OutputError("say --draw K or --draws all, not both")
    if given.get("--draws", "all") != "all":
        raise OutputError(f"--draws {given['--draws']}: say --draws all, or --draw K for one of them")
    tables = None if "--tables" not in given else given["--tables"].split(",")
    draw = None if "--draws" in given else given.get("--draw")
    found = export_spreadsheet(asked.folder, given.get("-o"), draw, "--draws" in given, tables, asked.plugins)
    return Answer([*(f"wrote {file}" for file in found.files), *(f"note: {remark}" for remark in found.remarks)])


def _parquet(asked: Asked) -> Answer:
    from sim.cli.exporting.records import export_records

    return Answer([f"wrote {path}" for path in export_records(asked.folder)])


def _tracks(asked: Asked) -> Answer:
    from sim.cli.exporting.others import export_tracks

    given = asked.given
    workers = given.get("-j", 1)
    found = export_tracks(asked.folder, given.get("-o"), given.get("--date"), workers, asked.plugins, asked.progress)
    lines = [f"wrote {found.files[0]}: {found.flights} flights, {found.rows} rows", f"wrote {found.files[1]}"]
    if not found.lost:
        return Answer(lines)
    lost = printable(f"warning: {len(found.lost)} flights are not there; {found.lost[0]}")
    return Answer([*lines, lost], FLIGHTS_CRASHED)


def _asterix(asked: Asked) -> Answer:
    from sim.cli.exporting.others import export_asterix

    given = asked.given
    capture = given.get("--pcap", False)
    files, left = export_asterix(asked.folder, given.get("--date"), given.get("--draw"), capture, asked.plugins)
    return Answer([*(f"wrote {asked.folder / file}" for file in files), *_left(left)])


def _kmz(asked: Asked) -> Answer:
    from sim.cli.exporting.others import export_kmz

    given = asked.given
    draw = given.get("--draw", 0)
    file, left = export_kmz(asked.folder, given.get("-o"), given.get("--date"), draw, asked.plugins)
    return Answer([f"wrote {printable(file)}", *_left(left)])


def _left(sentences: Any) -> list[str]:
    return [printable(f"left out: {sentence}") for sentence in sentences]


def _jsbsim(asked: Asked) -> Answer:
    from sim.cli.exporting.others import export_jsbsim

    root, overrides = asked.given["--jsbsim"], asked.given.get("--set", {})
    return Answer([*map(printable, export_jsbsim(str(asked.folder), root, overrides, asked.plugins))])


class Kind(NamedTuple):
    """One format: what writes it, and the options that it takes beside --plugin, which all take."""

    write: Callable[[Asked], Answer]
    takes: tuple[str, ...] = ()


KINDS = {
    "csv": Kind(_csv, ("--draw", "--draws", "--tables", "-o")),
    "parquet": Kind(_parquet),
    "tracks": Kind(_tracks, ("-o", "--date", "-j")),
    "asterix": Kind(_asterix, ("--pcap", "--draw", "--date")),
    "kmz": Kind(_kmz, ("--draw", "--date", "-o")),
    "jsbsim": Kind(_jsbsim, ("--jsbsim", "--set")),
}
