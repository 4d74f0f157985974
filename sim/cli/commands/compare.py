"""What changed between two runs or two studies."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from sim.cli.commands.options import Quiet
from sim.cli.endings import CHECK_FAILED, GOOD
from sim.errors import printable


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="The folder of a run or a study.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="Another of the same kind.")],
    tolerance: Annotated[
        Path | None, typer.Option(metavar="FILE", help='TOML, "METRIC" = largest difference; exit 1 beyond it.')
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print all rows as JSON.")] = False,
    quiet: Quiet = False,
    verbose: Annotated[bool, typer.Option("-v", "--verbose", help="Show what did not change, too.")] = False,
) -> None:
    """Say what changed between two runs or two studies beyond noise, and beyond a tolerance."""
    from sim.cli.terminal import table
    from sim.studies.comparing.comparison import compare as compared
    from sim.studies.comparing.told import told, verdict

    found = compared(a, b, tolerance)
    if as_json:
        typer.echo(json.dumps(found.plain(), indent=1))
    else:
        for line in [] if quiet else told(found, table, verbose):
            typer.echo(printable(line))
        typer.echo(verdict(found, tolerance is not None))
    raise typer.Exit(CHECK_FAILED if found.beyond else GOOD)
