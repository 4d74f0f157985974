"""Fitting the route law to what was flown."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim.cli.commands.options import Plugins, progress_bar


def identify(
    tracks: Annotated[Path, typer.Argument(help="A file of recorded tracks, or the folder of a run.")],
    runway: Annotated[Path | None, typer.Option("--runway", metavar="FILE", help="TOML with a [runway] table.")] = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Folder to write; default out/identify_NAME.")] = None,
    leg: Annotated[int | None, typer.Option(min=0, help="Leg of the route that is captured; default the last.")] = None,
    plugins: Plugins = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print identification.json instead of the table.")] = False,
) -> None:
    """Fit the route law to each capture of recorded tracks, or of a run."""
    from sim.cli.terminal import table
    from sim.studies.identification.command import LAW, NUMBERS, PAGE, identify_to_folder, summary

    folder, found = identify_to_folder(tracks, runway, out, leg, plugins or (), progress_bar())
    if as_json:
        typer.echo((folder / NUMBERS).read_text(encoding="utf-8"), nl=False)
        return
    typer.echo(summary(found, table))
    written = (folder / name for name in (PAGE, LAW) if (folder / name).is_file())
    typer.echo("\n".join(f"wrote {path}" for path in written))
