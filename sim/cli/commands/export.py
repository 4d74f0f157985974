"""Records of a run for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim.cli.commands.options import Plugins, Sets, overrides_of, progress_bar
from sim.cli.endings import FLIGHTS_CRASHED
from sim.errors import OutputError, printable


def export(
    folder: Annotated[Path, typer.Argument(help="A run folder or a study folder; with --jsbsim a scenario.")],
    csv: Annotated[bool, typer.Option("--csv", help="Comma-separated values.")] = False,
    parquet: Annotated[bool, typer.Option("--parquet", help="Parquet, for large records.")] = False,
    tracks: Annotated[
        bool, typer.Option("--tracks", help="The flights as recordings of traffic, and their runway.")
    ] = False,
    asterix: Annotated[
        bool, typer.Option("--asterix", help="Plots and tracks of a run as ASTERIX: CAT034, 048, 021 and 062.")
    ] = False,
    pcap: Annotated[bool, typer.Option("--pcap", help="With --asterix: a capture of UDP, not blocks alone.")] = False,
    draw: Annotated[
        int | None, typer.Option(metavar="K", help="With --asterix: draw K alone; default all, told apart by number.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="With --tracks: NAME.csv or NAME.parquet; default in the folder.")
    ] = None,
    date: Annotated[
        str | None,
        typer.Option(metavar="DATE", help="With --tracks, --asterix: when the first flight begins, ISO 8601, UTC."),
    ] = None,
    workers: Annotated[
        int, typer.Option("-j", "--workers", min=1, help="With --tracks: processes that fly flights again.")
    ] = 1,
    jsbsim: Annotated[
        Path | None, typer.Option(metavar="DIR", help="A scenario as a root of JSBSim, which flies it alone.")
    ] = None,
    sets: Sets = None,
    plugins: Plugins = None,
) -> None:
    """Write the records of a run, or the flights of a study, for other programs; or a scenario for JSBSim alone."""
    from sim.cli.export import export as write
    from sim.cli.export import export_asterix, export_jsbsim, export_tracks

    if jsbsim is not None:
        if csv or parquet or tracks or asterix or out is not None or date is not None or workers > 1:
            raise OutputError("--jsbsim DIR goes alone, with a scenario, --set and --plugin")
        for line in export_jsbsim(str(folder), jsbsim, overrides_of(sets), plugins or ()):
            typer.echo(printable(line))
        return
    if sets:
        raise OutputError("--set goes with --jsbsim: what was run keeps its values")
    kinds = [name for name, asked in (("csv", csv), ("parquet", parquet)) if asked]
    if (pcap or draw is not None) and not asterix:
        raise OutputError("--pcap and --draw go with --asterix")
    if asterix:
        if kinds or tracks or out is not None or workers > 1:
            raise OutputError("--asterix goes with --pcap, --draw and --date alone; its files lie in the folder")
        files, left = export_asterix(folder, date, draw, pcap, plugins or ())
        for file in files:
            typer.echo(f"wrote {folder / file}")
        for sentence in left:
            typer.echo(printable(f"left out: {sentence}"))
        return
    if tracks:
        if kinds:
            raise OutputError(
                "say --tracks alone: the ending of its file, -o NAME.csv or NAME.parquet, says the format"
            )
        found = export_tracks(folder, out, date, workers, plugins or (), progress_bar())
        typer.echo(f"wrote {found.files[0]}: {found.flights} flights, {found.rows} rows")
        typer.echo(f"wrote {found.files[1]}")
        if found.lost:
            typer.echo(printable(f"warning: {len(found.lost)} flights are not there; {found.lost[0]}"))
            raise typer.Exit(FLIGHTS_CRASHED)
        return
    if out is not None or date is not None or workers > 1:
        raise OutputError("-o and -j go with --tracks, --date with that or --asterix")
    if not kinds:
        raise OutputError("say what: --csv, --parquet, --tracks, --asterix or --jsbsim")
    for kind in kinds:
        for path in write(folder, kind):
            typer.echo(f"wrote {path}")
