"""Scenario checks under pytest: every check of a ``*.scenario.toml`` is a test, and ``shortfinal`` flies any scenario.

A file with ``[study]`` is flown as that study, into a folder that is thrown away. Heavy imports wait until something is
flown, since every pytest run of the environment loads this module. A scenario is flown once in a process; under
pytest-xdist, ``--dist loadfile`` keeps the checks of a file in one.
"""

from __future__ import annotations

import itertools
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

SUFFIX = ".scenario.toml"
FLOWN = pytest.StashKey[dict[str, Any]]()  # of the session: results by resolved scenario
USED = pytest.StashKey[list[Any]]()  # of an item: the results that it looked at
KEPT = pytest.StashKey[dict[int, tuple[Any, Path]]]()  # of the session: results whose folders are kept, and where


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--shortfinal-report=DIR``; of the ini file ``shortfinal_plugins`` and ``shortfinal_workers``."""
    group = parser.getgroup("shortfinal", "scenario checks")
    group.addoption(
        "--shortfinal-report",
        metavar="DIR",
        type=Path,
        help="keep the run folder with its report of every scenario whose test failed",
    )
    parser.addini(
        "shortfinal_plugins",
        "Python files with kinds that scenarios may name",
        type="paths",
    )
    parser.addini("shortfinal_workers", "worker processes that share the flights of a scenario", default="1")


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Scenario files by their name."""
    return ScenarioFile.from_parent(parent, path=file_path) if file_path.name.endswith(SUFFIX) else None


class ScenarioFile(pytest.File):
    """A scenario with its checks; a file that cannot be flown is one collection error in the words of ``validate``."""

    def collect(self) -> Iterator[pytest.Item]:
        """One item for each check, or one that flies a scenario without any."""
        from sim.errors import ScenarioError

        try:
            checks = read_file(self).checks
        except ScenarioError as error:
            raise self.CollectError(str(error)) from None
        names: dict[str, int] = {}
        for index, check in enumerate(checks):
            name = check.name or check.metric
            names[name] = names.get(name, 0) + 1
            number = f" ({names[name]})" if names[name] > 1 else ""
            yield CheckItem.from_parent(self, name=f"{name}{number}", index=index)
        if not checks:
            yield CheckItem.from_parent(self, name="flies", index=None)


class CheckItem(pytest.Item):
    """One check of a scenario."""

    def __init__(self, *, index: int | None, **given: Any) -> None:
        super().__init__(**given)
        self.index = index

    def runtest(self) -> None:
        """Fly the scenario, or its study, unless a check before this one did, and look at one of its checks."""
        from sim.reporting.text.broken_checks import broken, phases, run_again

        metrics = judged(self).metrics
        if self.index is None:
            crashes = metrics.get("crashes") or [
                one["metrics"]["reason"]
                for one in metrics.get("each_flight", ())
                if one["metrics"]["outcome"] == "crashed"
            ]
            if crashes:
                raise CheckBroken(f"{self.path.name}: a flight crashed: {crashes[0]}")
            return
        check = metrics["checks"][self.index]
        if check["passed"] is None:
            pytest.skip(f"{check['metric']}: no {phases(check)} was flown")  # neither kept nor broken, as in a report
        if not check["passed"]:
            file = os.path.relpath(self.path)
            raise CheckBroken(broken(check, metrics, run_again(file, self.config.getini("shortfinal_plugins"))))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], *arguments: Any) -> Any:
        """A broken check and a scenario at fault in their own words, anything else in full."""
        from sim.errors import ScenarioError

        if isinstance(excinfo.value, CheckBroken | ScenarioError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, *arguments)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where the check stands."""
        return self.path, None, f"{self.path.name}: {self.name}"


class CheckBroken(ValueError):
    """A check that was not kept."""


class Judged(NamedTuple):
    """A study that was flown for its checks."""

    scenario: Any
    metrics: dict[str, Any]
    folder: Path


def read_file(item: pytest.Item | pytest.Collector) -> Any:
    """The scenario of a file, with checks that its flights, or those of its study, can answer."""
    from sim.experiment import read, refuse_unfit_run
    from sim.scenario.plugins import catalogue_with
    from sim.studies.plan import plan

    catalogue = catalogue_with(item.config.getini("shortfinal_plugins"))
    scenario = read(item.path, plugins=catalogue)
    if scenario.study is None:
        refuse_unfit_run(scenario)
    else:
        plan(scenario, catalogue)
    return scenario


def judged(item: CheckItem) -> Any:
    """What has the verdicts on the checks of a file, its run or its study, flown once in a pytest run."""
    scenario = read_file(item)
    if scenario.study is None:
        return fly(item, item.path)
    from sim.scenario.plugins import catalogue_with
    from sim.studies.study import study
    from sim.workers.executors import LocalExecutor

    flown = item.session.stash.setdefault(FLOWN, {})
    key = str(item.path)
    if key not in flown:
        folder = Path(tempfile.mkdtemp(prefix="shortfinal-"))
        item.config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
        count, catalogue = workers(item), catalogue_with(item.config.getini("shortfinal_plugins"))
        metrics = study(item.path, folder / "study", LocalExecutor(count), plugins=catalogue, workers=count)
        flown[key] = Judged(scenario, metrics, folder / "study")
    item.stash.setdefault(USED, []).append(flown[key])
    return flown[key]


def workers(item: pytest.Item) -> int:
    """How many processes share the flights of a scenario, by the ini file."""
    from sim.errors import ScenarioError

    said = item.config.getini("shortfinal_workers").strip()
    if not said.isascii() or not said.isdigit() or int(said) < 1:
        raise ScenarioError(f"shortfinal_workers: must be a whole number from 1 on, not '{said}'")
    return int(said)


def fly(
    item: pytest.Item,
    source: str | Path | dict[str, Any],
    overrides: dict[str, Any] | None = None,
    plugins: Iterable[Any] = (),
    trackers: dict[str, Any] | None = None,
) -> Any:
    """The result of a scenario, flown once in a pytest run however many tests look at it."""
    import sim
    from sim.scenario.plugins import digests

    scenario = sim.read(source, overrides, plugins=(*item.config.getini("shortfinal_plugins"), *plugins))
    flown = item.session.stash.setdefault(FLOWN, {})
    key = json.dumps([scenario.tables, digests(scenario.parts)], sort_keys=True)
    key += "".join(f" {name} {id(one)}" for name, one in (trackers or {}).items())  # its result keeps them alive
    if key not in flown:
        flown[key] = sim.run(scenario, workers=workers(item), trackers=trackers)
    item.stash.setdefault(USED, []).append(flown[key])
    return flown[key]


@pytest.fixture
def shortfinal(request: pytest.FixtureRequest) -> Callable[..., Any]:
    """Run a scenario: ``shortfinal("an26_pattern", {"wind.speed_mps": 8})`` is the ``sim.Result``.

    The scenario is a bundled name, a file beside the test, a path or a dict of tables; ``seed``, ``flights`` and
    ``draws`` may be named. ``plugins`` are modules, or files beside the test, with kinds that the scenario names,
    beside those of the ini key ``shortfinal_plugins``, and ``trackers`` the test's own, as for ``sim.run``. The same
    scenario with the same trackers is flown once.
    """

    def found(source: Any) -> Any:
        beside = request.path.parent / source if isinstance(source, str | Path) else None
        return beside if beside is not None and beside.is_file() else source

    def run(
        source: str | Path | dict[str, Any],
        overrides: dict[str, Any] | None = None,
        *,
        plugins: Iterable[Any] = (),
        trackers: dict[str, Any] | None = None,
        **given: int,
    ) -> Any:
        return fly(request.node, found(source), {**(overrides or {}), **given}, map(found, plugins), trackers)

    return run


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Any:
    """Keep the run folders that a failed test looked at, where they are asked for."""
    report = yield
    folder = item.config.getoption("--shortfinal-report")
    if folder is not None and report.when == "call" and report.failed:
        for result in item.stash.get(USED, []):
            report.sections.append(("shortfinal", _kept(item, result, folder)))
    return report


def _kept(item: pytest.Item, result: Any, folder: Path) -> str:
    """Where the report of a failure is; one that cannot be kept costs nothing but itself."""
    from sim.errors import OutputError, ScenarioError

    places = item.session.stash.setdefault(KEPT, {})
    if id(result) not in places:
        worker = os.environ.get("PYTEST_XDIST_WORKER")  # each writes its own
        name = f"{result.scenario.name}-{worker}" if worker else result.scenario.name
        names = itertools.chain([name], (f"{name}-{number}" for number in itertools.count(2)))
        taken = [place.name for _, place in places.values()]
        try:
            places[id(result)] = result, keep(result, folder / next(one for one in names if one not in taken))
        except (OutputError, ScenarioError, OSError) as error:
            return f"no report: {error}"
    return f"report: {places[id(result)][1] / 'report.html'}"


def keep(result: Any, place: Path) -> Path:
    """Write the folder of a run or a study."""
    from sim.experiment import report
    from sim.files import claim

    if isinstance(result, Judged):
        claim(place, "study")
        shutil.copytree(result.folder, place, dirs_exist_ok=True)
        return place
    report(result, place)
    return place
