"""The command ``shortfinal``: every verb of the simulation, one sentence for every fault."""

from __future__ import annotations

import contextlib
import functools
import json
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from sim.cli.endings import (
    BAD_INPUT,
    CHECK_FAILED,
    FLIGHTS_CRASHED,
    GOOD,
    STOPPED,
    UNFORESEEN,
    Interrupted,
    Unwritable,
    stop_code,
    stopped_by_signals,
    told_apart,
    unforeseen,
    written,
)
from sim.cli.terminal import prepared_streams, say
from sim.errors import OutputError, ScenarioError, printable
from sim.workers.blas import one_thread

UsageError: Any = typer.BadParameter.__base__  # typer does not export it
DEFAULT = "an26_pattern"

app = typer.Typer(
    name="shortfinal",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help, in less than half the time
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(asked: bool) -> None:
    if asked:
        from sim.versions import __version__

        typer.echo(f"shortfinal {__version__}")
        raise typer.Exit


@app.callback()
def shortfinal(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version, and end.")
    ] = False,
) -> None:
    """Fly an approach in JSBSim under a bank-limited route autopilot, watch it, track it, judge it.

    Research software, not for operational use.
    """


Scenario = Annotated[str, typer.Argument(help="A scenario file or the name of a bundled scenario.")]
Out = Annotated[Path | None, typer.Option("-o", "--out", help="Folder to write; default out/NAME.")]
Sets = Annotated[
    list[str] | None, typer.Option("--set", metavar="TABLE.KEY=VALUE", help="Replace one value; repeatable.")
]

Plugins = Annotated[
    list[Path] | None,
    typer.Option("--plugin", metavar="FILE", help="Python file with kinds that the scenario names; repeatable."),
]

Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Say errors and the last line alone.")]
Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Say also what takes how long, and all warnings.")]

Workers = Annotated[
    int | None, typer.Option("-j", "--workers", min=1, help="Worker processes; default one for each core.")
]


def _without_cache(asked: bool) -> bool:
    """Switch the cache of the user off, for this process and those that it starts."""
    from sim.cache.user_cache import OFF, SWITCH

    if asked:
        os.environ[SWITCH] = OFF
    return asked


NoCache = Annotated[
    bool,
    typer.Option(
        "--no-cache", callback=_without_cache, help="Use and leave nothing in the user's cache folder (see doctor)."
    ),
]


@app.command()
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
    overrides = _overrides(sets, seed=seed, flights=flights, draws=draws)
    _run(scenario, overrides, out, plugins, as_json, quiet, verbose, flight=flight, workers=workers)


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

    given = {"progress": None if quiet else _progress(), "plugins": plugins or (), "remark": remark, **how}
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


@app.command()
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


@app.command()
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

    _run(scenario_of(tracks, runway, flight), _overrides(sets), out, plugins, as_json)


Cluster = Annotated[
    str | None, typer.Option("--cluster", metavar="ADDRESS", help="Fly on a Dask cluster: its scheduler's HOST:PORT.")
]
Insecure = Annotated[bool, typer.Option("--insecure", help="Allow a cluster on another machine without TLS.")]


@app.command()
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
        "overrides": _overrides(sets, seed=seed, flights=flights),
        "plugins": catalogue_with(plugins or ()),
    }
    folder = out if out is not None else Path("out") / read(scenario, plugins=how["plugins"]).name
    call = studies.study
    with _executor(workers, cluster, insecure) as given:
        _study(folder, lambda **more: call(scenario, folder, anew=anew, **how, **given, **more), plugins, quiet)


@app.command()
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
        metrics = fly(progress=None if quiet else _progress(), remark=remark)
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


@app.command()
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
            rows = ledger.measured(chosen, seed, quick, None if quiet else _progress(), out)
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


@app.command()
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


@app.command()
def validate(
    files: Annotated[list[str], typer.Argument(metavar="FILE...", help="Scenarios; - is standard input.")],
    sets: Sets = None,
    plugins: Plugins = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> None:
    """Say whether scenarios can be flown, and everything that is wrong with them, with its line."""
    from sim.cli.validation.faults import validate as examined
    from sim.scenario.plugins import catalogue_with

    catalogue, overrides, bad = catalogue_with(plugins or ()), _overrides(sets), False
    for file in files:
        verdict = examined(file, overrides, catalogue)
        for fault in verdict.faults:
            say(f"shortfinal: {printable(fault)}")
        for warning in verdict.warnings if verbose else ():
            typer.echo(printable(f"{verdict.name}: warning: {warning}"))
        bad = bad or bool(verdict.faults)
        if not verdict.faults and not quiet:
            typer.echo(f"{verdict.name}: good")
    raise typer.Exit(BAD_INPUT if bad else GOOD)


@app.command()
def new(file: Annotated[Path, typer.Argument(help="The scenario file to make.")]) -> None:
    """Write a commented scenario to start from."""
    from importlib import resources

    from sim.scenario.schema import NAME

    name = file.name.removesuffix(".toml").removesuffix(".scenario")
    if file.suffix != ".toml" or not NAME.fullmatch(name):
        raise OutputError(f"{file}: name it NAME.toml; a NAME starts with a letter and has letters, digits, _ and -")
    text = (resources.files("sim.scenario.bundled") / f"{DEFAULT}.toml").read_text(encoding="utf-8")
    try:
        with file.open("x", encoding="utf-8") as made:
            made.write(text.replace(f'"{DEFAULT}"', json.dumps(name)))
    except FileExistsError:
        raise OutputError(f"{file}: exists already; choose another name") from None
    except OSError as error:
        raise OutputError(f"{file}: cannot be written: {error.strerror}") from None
    typer.echo(f"wrote {file}; fly it with: shortfinal run {file}")


@app.command("list")
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


@app.command()
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

    read_ = read(scenario, _overrides(sets), plugins=plugins or ())
    wanted = {name: path for name, path in (("bode", bode), ("step", step)) if path is not None}
    for path in draw_loops(read_, wanted):
        typer.echo(f"wrote {path}")
    if not wanted:
        typer.echo(told(read_))


@app.command()
def schema(plugins: Plugins = None) -> None:
    """Print the JSON Schema of a scenario file."""
    from sim.metrics.checks import with_examples
    from sim.scenario.editors.json_schema import schema as made
    from sim.scenario.plugins import catalogue_with

    typer.echo(json.dumps(with_examples(made(catalogue_with(plugins or ()))), indent=1))


@app.command()
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


@app.command()
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


@app.command()
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

    folder, found = identify_to_folder(tracks, runway, out, leg, plugins or (), _progress())
    if as_json:
        typer.echo((folder / NUMBERS).read_text(encoding="utf-8"), nl=False)
        return
    typer.echo(summary(found, table))
    written = (folder / name for name in (PAGE, LAW) if (folder / name).is_file())
    typer.echo("\n".join(f"wrote {path}" for path in written))


@app.command()
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
        **{"-j": workers, "--set": _overrides(sets) if sets else None, "--jsbsim": jsbsim},
    }
    given = {option: value for option, value in said.items() if value is not None}
    answer = write({**kinds, "jsbsim": jsbsim is not None}, Asked(folder, given, plugins or (), _progress()))
    for line in answer.lines:
        typer.echo(line)
    raise typer.Exit(answer.code)


@app.command()
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
    progress = None if quiet else _progress()
    sent = shown(result, flightgear, rate=rate, speed=speed, remote=remote, progress=progress)
    typer.echo(f"sent {sent.packets} packets, {sent.duration:.1f} s of the flight, to {sent.address}")


def _overrides(sets: list[str] | None, **named: int | None) -> dict[str, Any]:
    import tomllib

    overrides: dict[str, Any] = {}
    for item in sets or []:
        address, equals, text = item.partition("=")
        if not equals or not address.strip():
            raise ScenarioError(f"--set {item}: write it as table.key=value")
        try:
            read = tomllib.loads(f"value = {text}")
        except (ValueError, RecursionError):  # also of a number with thousands of digits
            read = {}
        overrides[address.strip()] = read["value"] if len(read) == 1 else text.strip()  # an unquoted word
    return overrides | {key: value for key, value in named.items() if value is not None}


def _progress() -> Any:
    """A progress bar on a terminal, silence elsewhere."""
    if not sys.stderr.isatty():
        return None
    from sim.cli.terminal import bar

    return bar


def _exit_code(metrics: dict[str, Any]) -> int:
    if "crashed" in metrics["flights_summary"]["outcomes"]:
        return FLIGHTS_CRASHED
    failed = any(check["passed"] is False for check in metrics["checks"])
    return CHECK_FAILED if failed else GOOD


for _command in app.registered_commands:
    assert _command.callback is not None
    _command.callback = told_apart()(_command.callback)


def main() -> None:
    """Entry point: faults become sentences on standard error, each kind with an exit code of its own."""
    one_thread()
    prepared_streams()
    with stopped_by_signals() as came:
        code = _ended(came)
        if came and code:  # typer has a code of its own for what comes while it reads the words
            code = STOPPED + came[0]
        sys.exit(code)


def _ended(came: list[int]) -> Any:
    """The exit code of the command that was asked for; ``came`` are the signals that were to stop it."""
    try:
        return written(lambda: app(standalone_mode=False))
    except BaseException as error:
        if came:  # extensions that are being imported make other errors of it
            say("stopped")
            return STOPPED + came[0]
        return _told(error)


def _told(error: BaseException) -> int:
    """What went wrong, in sentences, and its exit code."""
    match error:
        case SystemExit():
            say("shortfinal: a part or a model ends the process; it must raise an error instead")
            return BAD_INPUT
        case Interrupted():
            say("stopped")
            return error.code
        case Unwritable():
            say(f"shortfinal: {error}")
            return UNFORESEEN
        case UsageError():
            told = error.format_message()
            if "\n" in told:  # nothing was asked, and the help is the answer
                typer.echo(told)
            else:
                command = error.ctx.command_path if error.ctx else app.info.name
                say(f"shortfinal: {printable(told).rstrip('.')}; see '{command} -h'")
            return BAD_INPUT
        case ScenarioError() | OutputError():
            for line in str(error).splitlines():
                say(f"shortfinal: {printable(line)}")
            return BAD_INPUT
        case _:
            return unforeseen(error)


if __name__ == "__main__":
    main()
