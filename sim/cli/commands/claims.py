"""Measuring what the papers claim."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from sim.cli.commands.options import Quiet, progress_bar
from sim.cli.endings import stop_code


def claims(
    papers: Annotated[list[str] | None, typer.Argument(metavar="[PAPER]...", help="Default: all.")] = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Folder for claims.json and the pages.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer runs: wider intervals.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the rows as JSON.")] = False,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of every random number.")] = None,
    quiet: Quiet = False,
) -> None:
    """Measure what the papers claim, and say which claims hold."""
    from sim import claims as ledger
    from sim.claims.table import table
    from sim.files import claim, plain
    from sim.workers.sharing import helper

    chosen = ledger.chosen(papers or ())
    if out is not None:
        claim(out, "claims")
    seed = ledger.SEED if seed is None else seed
    with helper(len(chosen) > 1):
        try:
            rows = ledger.measured(chosen, seed, quick, None if quiet else progress_bar(), out)
        except KeyboardInterrupt as stop:
            typer.echo("stopped" if out is None else "stopped; the rows are kept; the same command goes on", err=True)
            raise typer.Exit(stop_code(stop)) from None
        if out is not None:
            from sim.claims.page import write

            write(out, rows, seed)
    if as_json or not quiet or out is None:
        typer.echo(json.dumps(plain([row.plain() for row in rows]), indent=1) if as_json else table(rows))
    if out is not None and not as_json:
        typer.echo(f"page: {out / 'claims.html'}")
