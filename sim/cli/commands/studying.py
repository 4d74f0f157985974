"""Flying a scenario many times: a study, and going on with one."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from sim.cli.commands.options import NoCache, Out, Plugins, Quiet, Sets, Workers, overrides_of, progress_bar
from sim.cli.endings import CHECK_FAILED, FLIGHTS_CRASHED, GOOD, stop_code
from sim.errors import OutputError, printable

Cluster = Annotated[
    str | None, typer.Option("--cluster", metavar="ADDRESS", help="Fly on a Dask cluster: its scheduler's HOST:PORT.")
]
Insecure = Annotated[bool, typer.Option("--insecure", help="Allow a cluster on another machine without TLS.")]


def study(
    scenario: Annotated[str, typer.Argument(help="A scenario with [study]: a file or a bundled name.")],
    out: Out = None,
    workers: Workers = None,
    sets: Sets = None,
    plugins: Plugins = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of every random number.")] = None,
    flights: Annotated[int | None, typer.Option(min=1, help="Flights of every sample of every cell.")] = None,
    anew: Annotated[bool, typer.Option("--anew", help="Throw away another study that the folder holds.")] = False,
    cluster: Cluster = None,
    insecure: Insecure = False,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Fly a scenario over the axes of its [study] table; what a folder already has of it is not flown again."""
    from sim.experiment import read
    from sim.scenario.plugins import catalogue_with
    from sim.studies import study as studies

    how: dict[str, Any] = {
        "overrides": overrides_of(sets, seed=seed, flights=flights),
        "plugins": catalogue_with(plugins or ()),
    }
    folder = out if out is not None else Path("out") / read(scenario, plugins=how["plugins"]).name
    call = studies.study
    with _executor(workers, cluster, insecure) as given:
        _study(folder, lambda **more: call(scenario, folder, anew=anew, **how, **given, **more), plugins, quiet)


def resume(
    folder: Annotated[Path, typer.Argument(help="The folder of a study that was interrupted.")],
    workers: Workers = None,
    plugins: Plugins = None,
    anyway: Annotated[bool, typer.Option("--anyway", help="Go on although the versions differ.")] = False,
    cluster: Cluster = None,
    insecure: Insecure = False,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Go on with a study where it was interrupted; the result is that of an uninterrupted one."""
    from sim.studies import study as studies

    with _executor(workers, cluster, insecure) as given:
        _study(
            folder,
            lambda **more: studies.resume(folder, plugins=plugins or (), anyway=anyway, **given, **more),
            plugins,
            quiet,
        )


def _study(folder: Path, fly: Any, plugins: list[Path] | None, quiet: bool) -> None:
    from sim.cli.run_summary import study_summary
    from sim.reporting.text.broken_checks import run_again

    def remark(sentence: str) -> None:
        if not quiet:
            typer.echo(f"warning: {printable(sentence)}")

    again = "".join(f" --plugin {file}" for file in plugins or ())
    try:
        metrics = fly(progress=None if quiet else progress_bar(), remark=remark)
    except KeyboardInterrupt as stop:
        typer.echo(f"stopped; finished flights are kept; go on with: shortfinal resume {folder}{again}", err=True)
        raise typer.Exit(stop_code(stop)) from None
    if not quiet:
        typer.echo(study_summary(metrics, run_again(folder / "scenario.toml", plugins or ())))
    typer.echo(f"report: {folder / 'report.html'}")
    crashed = "crashed" in metrics["outcomes"]
    failed = any(check["passed"] is False for check in metrics["checks"])
    raise typer.Exit(FLIGHTS_CRASHED if crashed else CHECK_FAILED if failed else GOOD)


@contextlib.contextmanager
def _executor(workers: int | None, cluster: str | None, insecure: bool) -> Iterator[dict[str, Any]]:
    """Where a study flies, and how many workers that costs this machine."""
    if cluster is None:
        from sim.workers.executors import LocalExecutor

        count = workers if workers is not None else os.cpu_count() or 1
        yield {"executor": LocalExecutor(count), "workers": count}
        return
    if workers is not None:
        raise OutputError("say -j or --cluster, not both: a cluster has its own workers")
    from sim.workers.cluster import connect

    executor = connect(cluster, insecure)
    try:
        yield {"executor": executor, "workers": 0}
    finally:
        executor.close()
