"""Whether a part, an aircraft or the installation is sound."""

from __future__ import annotations

from typing import Annotated

import typer

from sim.cli.commands.options import Plugins
from sim.cli.endings import BAD_INPUT, CHECK_FAILED, GOOD
from sim.errors import printable


def contract(
    kind: Annotated[str, typer.Argument(metavar="KIND", help="A kind, or FAMILY.KIND where two families have it.")],
    plugins: Plugins = None,
) -> None:
    """Say whether a sensor, a tracker, a mode or a wind event keeps the contract of its family."""
    from sim.cli.contract import examine as tried
    from sim.scenario.plugins import catalogue_with

    name, broken = tried(kind, catalogue_with(plugins or ()))
    for sentence in broken:
        typer.echo(printable(f"{name}: {sentence}"))
    if not broken:
        typer.echo(f"{name} keeps its contract")
    raise typer.Exit(CHECK_FAILED if broken else GOOD)


def doctor(
    aircraft: Annotated[
        str | None,
        typer.Option(metavar="PATH", help="Check this aircraft instead: what it lacks, and what repairs do."),
    ] = None,
) -> None:
    """Check the installation, or an aircraft."""
    from sim.cli.doctor import examine, examine_aircraft

    lines, healthy = examine() if aircraft is None else examine_aircraft(aircraft)
    for line in lines:
        typer.echo(printable(line))
    raise typer.Exit(GOOD if healthy else BAD_INPUT)
