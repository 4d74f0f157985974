"""Flying one scenario into a folder: simulated, recorded, or again with tracks that were made elsewhere."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from sim.cli.commands.options import (
    DEFAULT,
    NoCache,
    Out,
    Plugins,
    Quiet,
    Scenario,
    Sets,
    Verbose,
    overrides_of,
    progress_bar,
)
from sim.cli.endings import CHECK_FAILED, FLIGHTS_CRASHED, GOOD
from sim.errors import ScenarioError, printable


def run(
    scenario: Scenario = DEFAULT,
    out: Out = None,
    sets: Sets = None,
    plugins: Plugins = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of every random number.")] = None,
    flights: Annotated[int | None, typer.Option(min=1, help="Flights, each with its own turbulence.")] = None,
    draws: Annotated[int | None, typer.Option(min=1, help="Noise draws of the sensors per flight.")] = None,
    flight: Annotated[int | None, typer.Option(min=0, help="Fly this flight alone, by its number from 0.")] = None,
    workers: Annotated[
        int, typer.Option("-j", "--workers", min=1, help="Worker processes that share the flights.")
    ] = 1,
    as_json: Annotated[bool, typer.Option("--json", help="Print metrics.json instead of the summary.")] = False,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Fly, observe, track and report a scenario."""
    if flight is not None and workers > 1:
        raise ScenarioError("run: say --flight or -j, not both: one flight has no work to share")
    overrides = overrides_of(sets, seed=seed, flights=flights, draws=draws)
    _run(scenario, overrides, out, plugins, as_json, quiet, verbose, flight=flight, workers=workers)


def judge(
    folder: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run, whose plots were tracked.")],
    tracks: Annotated[Path, typer.Option(metavar="FILE", help="Estimates made of them: CSV, Parquet or ASTERIX.")],
    name: Annotated[str, typer.Option(help="What to call the tracker.")] = "mine",
    sensors: Annotated[
        str | None, typer.Option(metavar="NAME,NAME", help="Sensors that it listened to; default all.")
    ] = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Folder to write; default RUN_NAME.")] = None,
    plugins: Plugins = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print metrics.json instead of the summary.")] = False,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Judge tracks that were made elsewhere from the plots of a run, beside its own trackers."""
    from sim.results.judging import verdict, with_track

    tables = with_track(folder, name, tracks, None if sensors is None else sensors.split(","), plugins or ())
    given = out if out is not None else folder.with_name(f"{folder.name}_{name}")
    _run(tables, {}, given, plugins, as_json, quiet, verbose, functools.partial(verdict, name))


def record(
    tracks: Annotated[Path, typer.Argument(help="Recorded tracks, CSV or Parquet.")],
    runway: Annotated[Path, typer.Option(metavar="FILE", help="TOML file with a table [runway], and [air] if known.")],
    flight: Annotated[str | None, typer.Option(metavar="ID", help="Which flight, where there are several.")] = None,
    out: Out = None,
    sets: Sets = None,
    plugins: Plugins = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print metrics.json instead of the summary.")] = False,
    no_cache: NoCache = False,
) -> None:
    """Observe, track and report a recorded flight; the scenario lies in the folder of the run."""
    from sim.scenario.recording.completion import scenario_of

    _run(scenario_of(tracks, runway, flight), overrides_of(sets), out, plugins, as_json)


def _run(
    scenario: str | dict[str, Any],
    overrides: dict[str, Any],
    out: Path | None,
    plugins: list[Path] | None,
    as_json: bool,
    quiet: bool = False,
    verbose: bool = False,
    first: Callable[[dict[str, Any]], str] | None = None,
    **how: Any,
) -> None:
    """Run a scenario into a folder and say what came of it; ``first`` says of its metrics what it was run for."""
    from sim import experiment

    def remark(sentence: str) -> None:
        if not quiet:
            typer.echo(f"warning: {sentence}", err=as_json)

    given = {"progress": None if quiet else progress_bar(), "plugins": plugins or (), "remark": remark, **how}
    folder, result = experiment.run_to_folder(scenario, overrides, out, **given)
    if as_json:
        typer.echo((folder / "metrics.json").read_text(encoding="utf-8"), nl=False)
    else:
        from sim.cli.run_summary import summary
        from sim.reporting.text.broken_checks import run_again

        if first is not None:
            typer.echo(printable(first(result.metrics)))
        again = run_again(folder / "scenario.toml", plugins or ())
        if not quiet:
            typer.echo(summary(result.metrics, again, result.prepared.warnings, result.contrasted))
        for part, taken in result.timing.items() if verbose and not quiet else ():
            typer.echo(f"{part.removesuffix('_s').replace('_', ' ')}: {taken:.2f} s")
        typer.echo(f"report: {folder / 'report.html'}")
    raise typer.Exit(_exit_code(result.metrics))


def _exit_code(metrics: dict[str, Any]) -> int:
    if "crashed" in metrics["flights_summary"]["outcomes"]:
        return FLIGHTS_CRASHED
    failed = any(check["passed"] is False for check in metrics["checks"])
    return CHECK_FAILED if failed else GOOD
