"""Beginning a scenario file, and finding what is wrong with it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from sim.cli.commands.options import DEFAULT, NoCache, Plugins, Quiet, Sets, Verbose, overrides_of
from sim.cli.endings import BAD_INPUT, GOOD
from sim.cli.terminal import say
from sim.errors import OutputError, printable


def validate(
    files: Annotated[list[str], typer.Argument(metavar="FILE...", help="Scenarios; - is standard input.")],
    sets: Sets = None,
    plugins: Plugins = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Say whether scenarios can be flown, and everything that is wrong with them, with its line."""
    from sim.cli.validation.faults import validate as examined
    from sim.scenario.plugins import catalogue_with

    catalogue, overrides, bad = catalogue_with(plugins or ()), overrides_of(sets), False
    for file in files:
        verdict = examined(file, overrides, catalogue)
        for fault in verdict.faults:
            say(f"shortfinal: {printable(fault)}")
        for warning in verdict.warnings if verbose else ():
            typer.echo(printable(f"{verdict.name}: warning: {warning}"))
        bad = bad or bool(verdict.faults)
        if not verdict.faults and not quiet:
            typer.echo(f"{verdict.name}: good")
    raise typer.Exit(BAD_INPUT if bad else GOOD)


SCHEMA = "scenario.schema.json"


def new(file: Annotated[Path, typer.Argument(help="The scenario file to make.")]) -> None:
    """Write a commented scenario to start from, and beside it the schema by which editors complete and check it."""
    from importlib import resources

    from sim.files import whole
    from sim.scenario.schema import NAME

    name = file.name.removesuffix(".toml").removesuffix(".scenario")
    if file.suffix != ".toml" or not NAME.fullmatch(name):
        raise OutputError(f"{file}: name it NAME.toml; a NAME starts with a letter and has letters, digits, _ and -")
    text = (resources.files("sim.scenario.bundled") / f"{DEFAULT}.toml").read_text(encoding="utf-8")
    try:
        with file.open("x", encoding="utf-8") as made:
            made.write(f"#:schema ./{SCHEMA}\n" + text.replace(f'"{DEFAULT}"', json.dumps(name)))
    except FileExistsError:
        raise OutputError(f"{file}: exists already; choose another name") from None
    except OSError as error:
        raise OutputError(f"{file}: cannot be written: {error.strerror}") from None
    beside = file.with_name(SCHEMA)
    is_there = beside.exists()
    if not is_there:
        with whole(beside) as partial:
            partial.write_text(_schema(), encoding="utf-8")
    typer.echo(f"{beside} is there already, and kept" if is_there else f"wrote {beside}; editors complete keys by it")
    typer.echo(f"wrote {file}; fly it with: shortfinal run {file}")


def schema(plugins: Plugins = None) -> None:
    """Print the JSON Schema of a scenario file."""
    typer.echo(_schema(plugins or ()), nl=False)


def _schema(plugins: Sequence[Path] = ()) -> str:
    from sim.metrics.checks import with_names
    from sim.scenario.editors.json_schema import schema as made
    from sim.scenario.plugins import catalogue_with

    return json.dumps(with_names(made(catalogue_with(plugins))), indent=1) + "\n"
