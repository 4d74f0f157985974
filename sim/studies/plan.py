"""Plan of a study: its axes, every cell with its gains, the samples that all cells share."""

from __future__ import annotations

import functools
import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from sim.errors import ScenarioError
from sim.experiment import read
from sim.flight.gains import INPUTS
from sim.flight.preparation import prepare
from sim.metrics.ensemble.verdict import refuse_unfit
from sim.scenario.axes import Axis, Listed, cells, samples
from sim.scenario.model import Scenario
from sim.scenario.plugins import Catalogue, Part, catalogue_with
from sim.scenario.reading import parsed
from sim.scenario.tables import StudyTable
from sim.studies import folder as folders
from sim.studies.job import with_values
from sim.studies.theory import THEORIES

LARGEST_STUDY = 100_000  # flights
OBSERVED = ("draws", "sensors", "sensor_faults", "trackers", "contrasts", "checks")
UNDESIGNED = ("name", "seed", "flights", "until_s", "start", "wind", *OBSERVED)


@dataclass(frozen=True)
class Study:
    """Everything that is to be flown: all axes, every cell's resolved tables, the samples that all cells share."""

    scenario: Scenario
    table: StudyTable
    axes: tuple[Axis, ...]
    cells: tuple[dict[str, Any], ...]  # chosen values
    samples: tuple[dict[str, float], ...]  # drawn values
    parts: tuple[Part, ...] = ()  # kinds from outside that any cell names

    @property
    def flights(self) -> int:
        """Number of flights."""
        return len(self.cells) * len(self.samples) * self.scenario.flights

    def numbers(self) -> Iterator[tuple[int, int, int]]:
        """(cell, sample, flight) of every flight, in order; a flight's number is the same in every cell."""
        each = self.scenario.flights
        for cell in range(len(self.cells)):
            for sample in range(len(self.samples)):
                for repeat in range(each):
                    yield cell, sample, sample * each + repeat


def plan(scenario: Scenario, plugins: Any = (), own: Iterable[str] = ()) -> Study:
    """What a study flies, with ``own`` trackers of the caller.

    Raises ``ScenarioError`` for axes and checks that no flight has, before anything is flown.
    """
    table = scenario.study
    if table is None:
        raise ScenarioError(
            f"{scenario.name}: has no [study]; say what is to be varied under [study.axes], or [study] samples = N for "
            f"N flights in air of their own, or use 'run'"
        )
    axes = table.varied
    faults, parts = _faults(scenario, table, axes, catalogue_with(plugins).also(scenario.parts))
    if faults:
        raise ScenarioError("\n".join(f"{scenario.name}: {fault}" for fault in faults))
    planned = Study(scenario, table, axes, cells(axes), samples(axes, table.samples, scenario.seed), parts)
    size = scenario.flights * table.samples
    refuse_unfit(scenario.name, scenario.checks, size, (*scenario.trackers, *own), contrasts=scenario.contrasts)
    return planned


def _faults(
    scenario: Scenario, table: StudyTable, axes: tuple[Axis, ...], catalogue: Catalogue
) -> tuple[list[str], tuple[Part, ...]]:
    """What is wrong with a study, and the parts from outside that the scenario and the values of its axes name."""
    size = scenario.flights * table.samples
    for one in axes:
        size *= len(one.values) if isinstance(one, Listed) else 1
    if size > LARGEST_STUDY:
        much = f"[study] {size} flights are more than the budget of {LARGEST_STUDY}; take fewer values or samples"
        return [much], ()
    faults, parts, base = [], {*scenario.parts}, _flown_tables(scenario)
    for one in axes:
        for value in one.values if isinstance(one, Listed) else (one.typical,):
            try:
                tables = with_values(base, {one.address: value})
                cell = read(tables, plugins=catalogue)
                parts |= {*cell.parts}
            except ScenarioError as error:
                faults += [f'[study] axes "{one.address}": {_said(line)}' for line in str(error).splitlines()]
                break
            wanted = dict.fromkeys(side for pair in scenario.contrasts for side in (pair.of, pair.against))
            gone = [name for name in wanted if name in scenario.trackers and name not in cell.trackers]
            if gone:
                faults.append(
                    f"[study] axes \"{one.address}\": [[contrasts]] needs the tracker '{gone[0]}' in every cell"
                )
                break
    if table.theory is not None:
        theory, chosen = THEORIES[table.theory], [one.address for one in axes if isinstance(one, Listed)]
        if unfit := theory.unfit(chosen):
            faults.append(f'[study] theory "{table.theory}" {unfit}')
        if theory.needs(scenario):
            faults.append(f'[study] theory "{table.theory}" needs {theory.needs(scenario)}')
    return faults, tuple(sorted(parts))


def _said(line: str) -> str:
    """A fault without the name of the temporary scenario."""
    return line.removeprefix("scenario: ").removeprefix("--set ")


def _flown_tables(scenario: Scenario) -> dict[str, Any]:
    """The resolved tables of one flight."""
    return {key: value for key, value in scenario.tables.items() if key != "study" and value is not None}


def designed_cells(planned: Study) -> tuple[dict[str, Any], ...]:
    """The tables of every cell with its gains, designed once for all cells that share a design.

    They are frozen: what a sample of the cell draws changes no gain. A cell that cannot be designed keeps its tables,
    and its flights say why; raises ``ScenarioError`` where none can.
    """
    base = _flown_tables(planned.scenario)
    design = functools.cache(_designed)
    found: list[dict[str, Any]] = []
    refused = []
    for values in planned.cells:
        tables = with_values(base, values)
        if "record" not in tables and INPUTS in tables.get("designed", {INPUTS: None}):
            kept = {name: value for name, value in tables.items() if name not in UNDESIGNED}
            quickness = {"autopilot": {k: v for k, v in kept.get("autopilot", {}).items() if k != "frequency_share"}}
            key = json.dumps({**kept, **quickness})  # how quick the law is changes no gain of the inner loops
            try:
                tables = {**tables, "designed": design(key, planned.parts)}
            except ScenarioError as error:
                where = ", ".join(f"{address} = {value}" for address, value in values.items())
                refused.append(f"{planned.scenario.name}: with {where or 'these values'}: {error}")
        found.append(tables)
    if len(refused) == len(found):
        raise ScenarioError(refused[0])
    return tuple(found)


def _designed(text: str, parts: tuple[Part, ...]) -> dict[str, Any]:
    tables = json.loads(text)
    truth = {"autopilot": {**tables["autopilot"], "navigation": "truth"}}  # gains do not depend on who navigates
    return prepare(read({"name": "design", **tables, **truth}, plugins=parts)).gains.designed.to_table()


def read_text(content: bytes, catalogue: Catalogue) -> Scenario:
    """The scenario of a resolved file, so that a study and its resumption start from the same bytes."""
    return read(parsed(folders.SCENARIO, content), plugins=catalogue)
