"""A run shown by a FlightGear."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim.cli.commands.options import Plugins, Quiet, progress_bar


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
