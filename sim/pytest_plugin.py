"""Scenario checks under pytest: every check of a ``*.scenario.toml`` is a test, and ``shortfinal`` flies any scenario.

Heavy imports wait until something is flown, since every pytest run of the environment loads this module. A flight is
flown once in a process; under pytest-xdist, ``--dist loadfile`` keeps the checks of a file in one.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest

SUFFIX = ".scenario.toml"
FLOWN = pytest.StashKey[dict[str, Any]]()  # of the session: results by resolved scenario
USED = pytest.StashKey[list[Any]]()  # of an item: the results that it looked at


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--shortfinal-report=DIR``, and ``shortfinal_plugins`` of the ini file."""
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


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Scenario files by their name."""
    return ScenarioFile.from_parent(parent, path=file_path) if file_path.name.endswith(SUFFIX) else None


class ScenarioFile(pytest.File):
    """A scenario with its checks; a file that cannot be flown is one collection error in the words of ``validate``."""

    def collect(self) -> Iterator[pytest.Item]:
        """One item for each check, or one that flies a scenario without any."""
        from sim.errors import ScenarioError
        from sim.experiment import read

        try:
            checks = read(self.path, plugins=self.config.getini("shortfinal_plugins")).checks
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
        """Fly the scenario, unless a check before this one did, and look at one of its checks."""
        from sim.metrics.checks import broken, phases

        result = fly(self, self.path)
        if self.index is None:
            return
        check = result.metrics["checks"][self.index]
        if check["passed"] is None:
            pytest.skip(f"{check['metric']}: no {phases(check)} was flown")  # neither kept nor broken, as in a report
        if not check["passed"]:
            raise CheckBroken(broken(check))

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
    """A check that the flight did not keep."""


def fly(
    item: pytest.Item,
    source: str | Path | dict[str, Any],
    overrides: dict[str, Any] | None = None,
    plugins: Iterable[Any] = (),
) -> Any:
    """The result of a scenario, flown once in a pytest run however many tests look at it."""
    import sim
    from sim.scenario.plugins import digests

    scenario = sim.read(source, overrides, plugins=(*item.config.getini("shortfinal_plugins"), *plugins))
    flown = item.session.stash.setdefault(FLOWN, {})
    key = json.dumps([scenario.tables, digests(scenario.parts)], sort_keys=True)
    if key not in flown:
        flown[key] = sim.run(scenario)
    item.stash.setdefault(USED, []).append(flown[key])
    return flown[key]


@pytest.fixture
def shortfinal(request: pytest.FixtureRequest) -> Callable[..., Any]:
    """Run a scenario: ``shortfinal("an26_pattern", {"wind.speed_mps": 8})`` is the ``sim.Result``.

    The scenario is a bundled name, a file beside the test, a path or a dict of tables; ``seed``, ``flights`` and
    ``draws`` may be named. ``plugins`` are modules, or files beside the test, with kinds that the scenario names,
    beside those of the ini key ``shortfinal_plugins``. The same scenario is flown once.
    """

    def found(source: Any) -> Any:
        beside = request.path.parent / source if isinstance(source, str | Path) else None
        return beside if beside is not None and beside.is_file() else source

    def run(
        source: str | Path | dict[str, Any],
        overrides: dict[str, Any] | None = None,
        *,
        plugins: Iterable[Any] = (),
        **given: int,
    ) -> Any:
        return fly(request.node, found(source), {**(overrides or {}), **given}, map(found, plugins))

    return run


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Any:
    """Keep the run folders that a failed test looked at, where they are asked for."""
    report = yield
    folder = item.config.getoption("--shortfinal-report")
    if folder is not None and report.when == "call" and report.failed:
        for result in item.stash.get(USED, []):
            report.sections.append(("shortfinal", f"report: {keep(result, folder) / 'report.html'}"))
    return report


def keep(result: Any, folder: Path) -> Path:
    """Write the folder of a run, named after its scenario; each xdist worker writes its own."""
    from sim.experiment import report
    from sim.files import claim, staged, write_json

    worker = os.environ.get("PYTEST_XDIST_WORKER")
    place = folder / (f"{result.scenario.name}-{worker}" if worker else result.scenario.name)
    claim(place, "run")
    with staged(place) as whole:
        report(result, whole)
        write_json(whole / "timing.json", result.timing)
    return place
