"""The pydantic model of one scenario file, for the kinds that it uses."""

from __future__ import annotations

import functools
import re
import types
import typing
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, create_model

from sim.errors import ScenarioError, did_you_mean
from sim.scenario import catalogue as bundled
from sim.scenario.arrivals.navigation import NavigationErrors
from sim.scenario.arrivals.vectored import VectoredTable
from sim.scenario.parameters import model_of
from sim.scenario.plugins import BUNDLED, Catalogue
from sim.scenario.recording.table import RecordTable
from sim.scenario.tables import (
    AircraftChoice,
    AirTable,
    AutopilotTable,
    Check,
    Contrast,
    Departure,
    LegsTable,
    PatternTable,
    Runway,
    SensorFault,
    Start,
    StudyTable,
    WindTable,
)

MOST_MODELS = 256  # that are kept of one sort; files that differ in numbers alone share theirs
MOST_NAMES = 50  # sensors or trackers of one scenario
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,63}")
ROUTES = {"pattern": PatternTable, "legs": LegsTable, "vectored": VectoredTable}
RESERVED = {"trackers": {"truth": "'truth' is the motion itself, as [autopilot] navigation has it"}}
FROM_OUTSIDE = "; others come with --plugin FILE"
DEFAULT_ROUTE, DEFAULT_MODE = "pattern", "lateral_navigation"  # of files that name no kind
LAW_GIVEN = ("bank_limit",)  # stands in [autopilot] itself
DESIGNED = (
    "Gains of the inner loops and of the route law in SI, as a run writes them into its own scenario.toml. They fly as "
    "long as 'inputs' is what the scenario asks the design for; otherwise there is a new design, with a remark. "
    "Without 'inputs' they are frozen and fly whatever else the scenario says."
)


class TrackerTable(BaseModel):
    """The keys that every tracker's table has beside its own."""

    model_config = ConfigDict(extra="forbid")
    sensors: Annotated[list[str], Field(min_length=1)] | None = None
    handover: str | None = None
    association: typing.Literal["probabilistic"] | None = None
    law: dict[str, Annotated[float, Field(allow_inf_nan=False, strict=True)]] | None = None


@functools.cache
def _tracker_model(cls: type, kind: str) -> type[BaseModel]:
    return create_model(f"{kind}_tracker", __base__=(TrackerTable, model_of(cls, kind)))


@functools.cache
def _autopilot_model(cls: type, kind: str) -> type[BaseModel]:
    law: Any = model_of(cls, partial=True, without=LAW_GIVEN)
    base = model_of(AutopilotTable, kind, defaulted_kind=kind == DEFAULT_MODE)
    return create_model(f"{kind}_autopilot", __base__=base, law=(law | None, None))


MODELS: dict[str, Callable[[type, str], type[BaseModel]]] = {
    "sensors": model_of,
    "trackers": _tracker_model,
    "wind_events": model_of,
    "modes": _autopilot_model,
}


def route_model(kind: str) -> type[BaseModel]:
    return model_of(ROUTES[kind], kind, defaulted_kind=kind == DEFAULT_ROUTE)


@functools.lru_cache(maxsize=MOST_MODELS)
def wind_model(events: Any) -> type[BaseModel]:
    return create_model("wind", __base__=model_of(WindTable), events=(events, {}))


def _entries(cls: type) -> Any:
    """``list`` of a model that is made at run time, which a type checker would not take for a type."""
    return types.GenericAlias(list, (model_of(cls),))


def _optional(cls: type) -> Any:
    """A model that is made at run time, or None."""
    return model_of(cls) | None


@functools.lru_cache(maxsize=MOST_MODELS)
def file_model(route: Any, autopilot: Any, wind: Any, sensors: Any, trackers: Any) -> type[BaseModel]:
    """The model of a whole file, from the types of the tables that have kinds; making one takes long."""
    text = Annotated[str, Field(pattern=f"^{NAME.pattern}$")]
    return create_model(
        "Scenario",
        __config__=ConfigDict(extra="forbid"),
        name=(text, ...),
        seed=(Annotated[int, Field(strict=True, ge=0, lt=2**63)], 1),
        flights=(Annotated[int, Field(strict=True, ge=1, le=100_000)], 1),
        draws=(Annotated[int, Field(strict=True, ge=1, le=100_000)], 130),
        until_s=(Annotated[float, Field(gt=0, le=1800, allow_inf_nan=False, strict=True)] | None, None),
        record=(_optional(RecordTable), None),
        runway=(model_of(Runway), None),
        air=(model_of(AirTable), None),
        aircraft=(model_of(AircraftChoice), None),
        start=(model_of(Start), None),
        designed=(dict[str, Any] | None, Field(default=None, description=DESIGNED)),
        departures=(_entries(Departure), []),
        sensor_faults=(_entries(SensorFault), []),
        contrasts=(_entries(Contrast), []),
        checks=(_entries(Check), []),
        study=(_optional(StudyTable), None),
        navigation_errors=(_optional(NavigationErrors), None),
        route=(route, None),
        autopilot=(autopilot, None),
        wind=(wind, None),
        sensors=(sensors, {}),
        trackers=(trackers, {}),
    )


def owner_of(tables: dict[str, Any], place: list[Any], key: str) -> str | None:
    """Which bundled kinds of sensor have a key that the kind at a place has not, as a hint; None = no other."""
    if len(place) != 2 or place[0] != "sensors":
        return None
    own = kind_of(tables["sensors"][place[1]], None)
    others = [kind for kind in bundled.kinds("sensors") if key in model_of(BUNDLED.load("sensors", kind)).model_fields]
    return f"a {own} has none, it is one of {', '.join(others)}" if others else None


def kind_of(table: Any, default: str | None) -> str | None:
    return table.get("kind", default) if isinstance(table, dict) else default


def parts_of(tables: dict[str, Any], faults: list[str], catalogue: Catalogue) -> dict[str, Any]:
    """Types of the tables with kinds, for the kinds that this file uses."""
    parts: dict[str, Any] = {}
    route = kind_of(tables.get("route", {}), DEFAULT_ROUTE)
    if route in list(ROUTES):  # it may be anything, also what cannot be a key
        parts["route"] = route_model(route)
    else:
        faults.append(f"[route] kind: no kind '{route}'; {did_you_mean(str(route), ROUTES)}")
        parts["route"] = Any
    mode = kind_of(tables.get("autopilot", {}), DEFAULT_MODE)
    parts["autopilot"] = _model(catalogue, "modes", mode, "autopilot", faults)
    parts["sensors"] = _members("sensors", "sensors", tables.get("sensors"), faults, catalogue)
    parts["trackers"] = _members("trackers", "trackers", tables.get("trackers"), faults, catalogue)
    wind = tables.get("wind")
    events = wind.get("events") if isinstance(wind, dict) else None
    parts["wind"] = wind_model(_members("wind_events", "wind.events", events, faults, catalogue))
    return parts


def _model(catalogue: Catalogue, family: str, kind: Any, place: str, faults: list[str]) -> Any:
    """The model of a table of this kind; anything where the kind is a fault."""
    try:
        return MODELS[family](catalogue.load(family, kind), kind)
    except KeyError:
        retired = bundled.RETIRED.get((family, str(kind)))
        hint = did_you_mean(str(kind), catalogue.kinds(family))
        hint = f"write {retired}" if retired else hint if "mean" in hint else hint + FROM_OUTSIDE
        faults.append(f"[{place}] kind: no kind '{kind}'; {hint}")
    except ScenarioError as error:
        faults.append(f"[{place}] {error}")
    return Any


def name_faults(family: str, name: Any) -> list[str]:
    """What is wrong with a user's name of a sensor, a tracker or an event."""
    faults = []
    if not isinstance(name, str) or not NAME.fullmatch(name):
        faults.append("a name starts with a letter and has letters, digits, _ and -")
    if name in RESERVED.get(family, ()):
        faults.append(f"{RESERVED[family][name]}; choose another name")
    return faults


def _members(family: str, place: str, named: Any, faults: list[str], catalogue: Catalogue) -> Any:
    """The model of a table whose members are named by the user and have kinds."""
    members: dict[str, Any] = {}
    if isinstance(named, dict) and len(named) > MOST_NAMES:
        faults.append(f"{place}: {len(named)} are more than the {MOST_NAMES} that one scenario can have")
        return Any
    for name, table in named.items() if isinstance(named, dict) else ():
        faults += [f"[{place}.{name}]: {fault}" for fault in name_faults(family, name)]
        if not isinstance(table, dict):
            faults.append(f"[{place}] {name}: must be a table with a 'kind'")
            members[name] = Any
        elif not (kind := kind_of(table, None)):
            faults.append(f"[{place}.{name}] kind: is missing")
            members[name] = Any
        else:
            members[name] = _model(catalogue, family, kind, f"{place}.{name}", faults)
    return _table_model(family, tuple(members.items()))


@functools.lru_cache(maxsize=MOST_MODELS)
def _table_model(family: str, members: tuple[tuple[str, Any], ...]) -> type[BaseModel]:
    """The model of a table of these members, all of which are there."""
    required: dict[str, Any] = {name: (model, ...) for name, model in members}
    return create_model(family, __config__=ConfigDict(extra="forbid"), **required)
