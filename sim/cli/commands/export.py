"""A run for other programs: as files, and as what a FlightGear shows."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from sim.cli.commands.options import Plugins, Quiet, Sets, overrides_of, progress_bar


def export(
    folder: Annotated[Path, typer.Argument(help="A run folder or a study folder; with --jsbsim a scenario.")],
    csv: Annotated[bool, typer.Option("--csv", help="Tables for a spreadsheet, comma-separated, in degrees.")] = False,
    parquet: Annotated[bool, typer.Option("--parquet", help="The arrays as they are, of all draws: Parquet.")] = False,
    tracks: Annotated[
        bool, typer.Option("--tracks", help="The flights as recordings of traffic, and their runway.")
    ] = False,
    asterix: Annotated[
        bool, typer.Option("--asterix", help="Plots and tracks of a run as ASTERIX: CAT034, 048, 021 and 062.")
    ] = False,
    kmz: Annotated[
        bool, typer.Option("--kmz", help="A run for a globe: the flight and a track of each tracker.")
    ] = False,
    jsbsim: Annotated[
        Path | None, typer.Option(metavar="DIR", help="A scenario as a root of JSBSim, which flies it alone.")
    ] = None,
    pcap: Annotated[bool, typer.Option("--pcap", help="With --asterix: a capture of UDP, not blocks alone.")] = False,
    draw: Annotated[
        int | None,
        typer.Option(metavar="K", help="Draw K of the noise; default 0, with --asterix all, told apart by number."),
    ] = None,
    draws: Annotated[str | None, typer.Option(metavar="all", help="With --csv: a row for every draw.")] = None,
    tables: Annotated[
        str | None,
        typer.Option(metavar="NAME,NAME", help="With --csv: flight, measurements, tracks, contrasts; or tracks.NAME."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="With --tracks, --kmz a file, with --csv a folder; default: of the run."),
    ] = None,
    date: Annotated[
        str | None,
        typer.Option(metavar="DATE", help="When the first flight begins, ISO 8601, UTC: --tracks, --asterix, --kmz."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option("-j", "--workers", min=1, help="With --tracks: processes that fly flights again.")
    ] = None,
    sets: Sets = None,
    plugins: Plugins = None,
) -> None:
    """Write the records of a run, or the flights of a study, for other programs; or a scenario for JSBSim alone."""
    from sim.cli.exporting.asked import Asked
    from sim.cli.exporting.asked import export as write

    kinds = {"csv": csv, "parquet": parquet, "tracks": tracks, "asterix": asterix, "kmz": kmz}
    said: dict[str, Any] = {
        **{"--pcap": pcap or None, "--draw": draw, "--draws": draws, "--tables": tables, "-o": out, "--date": date},
        **{"-j": workers, "--set": overrides_of(sets) if sets else None, "--jsbsim": jsbsim},
    }
    given = {option: value for option, value in said.items() if value is not None}
    answer = write({**kinds, "jsbsim": jsbsim is not None}, Asked(folder, given, plugins or (), progress_bar()))
    for line in answer.lines:
        typer.echo(line)
    raise typer.Exit(answer.code)


def replay(
    folder: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    flightgear: Annotated[
        str, typer.Option(metavar="HOST:PORT", help="Where a FlightGear listens for its native FDM packets (UDP).")
    ],
    rate: Annotated[float, typer.Option(metavar="HZ", help="Packets a second.")] = 30.0,
    speed: Annotated[float, typer.Option(metavar="X", help="Times as fast as it was flown.")] = 1.0,
    remote: Annotated[bool, typer.Option("--remote", help="Allow a host that is not this machine.")] = False,
    plugins: Plugins = None,
    quiet: Quiet = False,
) -> None:
    """Show a run in a FlightGear, as it was flown and in its time."""
    from sim.results.loading import load
    from sim.results.replaying import replay as shown

    result = load(folder, plugins=plugins or ())
    progress = None if quiet else progress_bar()
    sent = shown(result, flightgear, rate=rate, speed=speed, remote=remote, progress=progress)
    typer.echo(f"sent {sent.packets} packets, {sent.duration:.1f} s of the flight, to {sent.address}")
