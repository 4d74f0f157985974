"""What there is to choose from, and what a scenario resolves to."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sim.cli.commands.options import DEFAULT, NoCache, Plugins, Scenario, Sets, overrides_of
from sim.errors import ScenarioError


def list_(
    aircraft: Annotated[bool, typer.Option("--aircraft", help="Aircraft instead of scenarios.")] = False,
    kinds: Annotated[bool, typer.Option("--kinds", help="Kinds of sensors, trackers, laws, wind events.")] = False,
    plugins: Plugins = None,
) -> None:
    """List the bundled scenarios, or the aircraft, or the kinds that a scenario can name."""
    if aircraft and kinds:
        raise ScenarioError("list: say --aircraft or --kinds, not both")
    if plugins and not kinds:
        raise ScenarioError("list: --plugin brings kinds; say --kinds as well")
    from sim.cli.listing import aircraft_lines, kind_lines, scenario_lines

    typer.echo("\n".join(aircraft_lines() if aircraft else kind_lines(plugins or ()) if kinds else scenario_lines()))


def explain(
    scenario: Scenario = DEFAULT,
    sets: Sets = None,
    plugins: Plugins = None,
    bode: Annotated[
        Path | None, typer.Option(metavar="FILE.svg", help="Draw gain and phase of the route loop instead.")
    ] = None,
    step: Annotated[
        Path | None, typer.Option(metavar="FILE.svg", help="Draw bank and path after a step instead.")
    ] = None,
    no_cache: NoCache = False,
) -> None:
    """Show what a scenario resolves to: route, trim, modes, gains, limits, checks."""
    from sim.cli.explain import draw_loops
    from sim.cli.explain import explain as told
    from sim.experiment import read

    read_ = read(scenario, overrides_of(sets), plugins=plugins or ())
    wanted = {name: path for name, path in (("bode", bode), ("step", step)) if path is not None}
    for path in draw_loops(read_, wanted):
        typer.echo(f"wrote {path}")
    if not wanted:
        typer.echo(told(read_))
