"""study(): the study of a scenario from Python."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from sim.errors import ScenarioError
from sim.estimation.own_trackers import OwnTrackers
from sim.results.studied import StudyResult
from sim.scenario.plugins import Plugins
from sim.scenario.reading import Source
from sim.studies import study as studies
from sim.workers.executors import Executor, LocalExecutor


def study(
    source: Source,
    folder: str | Path | None = None,
    *,
    seed: int | None = None,
    flights: int | None = None,
    draws: int | None = None,
    workers: int = 1,
    overrides: Mapping[str, Any] | None = None,
    trackers: OwnTrackers | None = None,
    plugins: Plugins = (),
    anew: bool = False,
    progress: Callable[..., Any] | None = None,
    remark: Callable[[str], None] | None = None,
) -> StudyResult:
    """Fly a scenario over the axes of its ``[study]``.

    Parameters
    ----------
    source : a file, a bundled name or a dict of tables
    folder : is made and keeps every finished flight: the same call again goes on where it was stopped. None = a folder
        that is thrown away, and with it what was flown
    workers : processes that share the flights; 1 = they are flown in this one. The numbers do not depend on it
    overrides, trackers, plugins, remark : as for ``sim.run``
    anew : throw away another study that the folder holds

    Raises ``ScenarioError`` for anything that cannot be flown, ``OutputError`` for a folder that cannot be used.
    """
    if workers < 1:
        raise ScenarioError(f"workers must be at least 1, not {workers}")
    given = {"seed": seed, "flights": flights, "draws": draws}
    changes = {**(overrides or {}), **{key: value for key, value in given.items() if value is not None}}
    executor: Executor = LocalExecutor(workers) if workers > 1 else _Here()

    def fly(place: Path) -> dict[str, Any]:
        return studies.study(
            source,
            place,
            executor,
            changes,
            trackers=trackers,
            plugins=plugins,
            anew=anew,
            workers=workers if workers > 1 else 0,
            progress=progress,
            remark=remark,
        )

    if folder is not None:
        return StudyResult(Path(folder), fly(Path(folder)))
    with tempfile.TemporaryDirectory(prefix="shortfinal-") as place:
        return StudyResult(None, fly(Path(place) / "study"))


class _Here:
    """Flies in this process, one after another."""

    def __init__(self) -> None:
        self._jobs: list[tuple[int, Callable[..., Any], tuple[Any, ...]]] = []

    def submit(self, number: int, function: Callable[..., Any], *arguments: Any) -> None:
        """Take a job."""
        self._jobs.append((number, function, arguments))

    def finished(self) -> Iterator[tuple[int, Any]]:
        """Each job's number and result, done as they are asked for."""
        while self._jobs:
            number, function, arguments = self._jobs.pop(0)
            yield number, function(*arguments)

    def close(self) -> None:
        """Drop what has not begun."""
        self._jobs.clear()
