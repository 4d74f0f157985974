"""A validated scenario; values in SI."""

from __future__ import annotations

import traceback
from dataclasses import dataclass, field
from typing import Any

from aircraft.air import Air
from sim.scenario.catalogue import completed
from sim.scenario.plugins import Part
from sim.scenario.recording.table import RecordTable
from sim.scenario.tables import (
    AircraftChoice,
    AutopilotTable,
    Check,
    Contrast,
    Departure,
    Route,
    Runway,
    SensorFault,
    Start,
    StudyTable,
    WindTable,
)


@dataclass(frozen=True)
class TrackerChoice:
    """One tracker of a scenario: its kind, what it listens to, who hands over, and the law it assumes."""

    kind: str
    cls: type[Any]  # of that kind
    sensors: tuple[str, ...]
    handover: str | None
    table: dict[str, Any]  # its own parameters, validated, as spelled in the file
    law: dict[str, float]  # absolute values in SI, or <field>_factor; empty = the law that flies
    association: str | None = None  # how it finds the target's plot among false ones; None = there are none


@dataclass(frozen=True)
class Scenario:
    """A validated experiment; values in SI."""

    name: str
    seed: int
    flights: int
    draws: int
    until: float | None
    runway: Runway
    air: Air  # over the runway, apart from its motion
    aircraft: AircraftChoice
    start: Start
    route: Route
    autopilot: AutopilotTable
    mode: str  # kind of law, a file of autopilot/modes or a part from outside
    modes: dict[str, type[Any]]  # classes of the kinds of law that it names: of the autopilot, and of its departures
    law: dict[str, Any]  # what the file sets of it, SI; the rest is designed
    designed: dict[str, Any] | None  # gains as they travel to workers
    wind: WindTable
    sensors: dict[str, Any]
    trackers: dict[str, TrackerChoice]
    departures: tuple[Departure, ...]
    sensor_faults: tuple[SensorFault, ...]
    contrasts: tuple[Contrast, ...]
    checks: tuple[Check, ...]
    study: StudyTable | None
    tables: dict[str, Any] = field(repr=False)  # the resolved file
    record: RecordTable | None = None  # of a flight that was flown elsewhere; None = it is flown here
    parts: tuple[Part, ...] = field(default=(), repr=False)  # kinds from outside that it names

    @property
    def repetitions(self) -> int:
        """How many flights the scenario has as it stands: also those of a study that varies nothing."""
        return self.flights * (self.study.samples if self.study is not None and not self.study.varied else 1)

    @property
    def has_route(self) -> bool:
        """Whether it says a route; for a recording that has none the final of its runway is taken, without speeds."""
        return self.record is None or "route" in self.tables

    def part_at_fault(self, error: BaseException) -> str | None:
        """The law or the wind event in whose file an error arose, and its line; None = it arose in no such file."""
        lines = {frame.f_globals.get("__name__"): line for frame, line in traceback.walk_tb(error.__traceback__)}
        kinds = [(cls, f"[autopilot] kind '{kind}'") for kind, cls in self.modes.items()]
        kinds += [(type(event), f"[wind.events.{name}]") for name, event in self.wind.events.items()]
        return next((f"{kind} (line {lines[cls.__module__]})" for cls, kind in kinds if cls.__module__ in lines), None)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """In another process its classes are completed as the reader has completed them in this one."""
        for name, value in state.items():
            object.__setattr__(self, name, value)
        for family, classes in (
            ("modes", self.modes.values()),
            ("sensors", map(type, self.sensors.values())),
            ("trackers", (choice.cls for choice in self.trackers.values())),
            ("wind_events", map(type, self.wind.events.values())),
        ):
            for cls in classes:
                completed(family, cls)
