"""TOML -> Scenario: everything checked, all faults of a file told at once, SI inside."""

from __future__ import annotations

import functools
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from aircraft.air import Air
from aircraft.wind_event import broken_promises
from sim.errors import ScenarioError, did_you_mean
from sim.scenario import catalogue as bundled
from sim.scenario.arrivals.navigation import NavigationErrors
from sim.scenario.messages import MOST_FAULTS, faults_of, quantity, report_faults
from sim.scenario.model import Route, Scenario, TrackerChoice
from sim.scenario.parameters import TrueShare, construct, dump, given_values, parameters, spellings_in
from sim.scenario.plugins import Catalogue, Plugins, catalogue_with, is_outside, said
from sim.scenario.recording.completion import beside_file, completed_record, runway_file, strangers
from sim.scenario.recording.plots_alone import faults_of_plots, located, recorded
from sim.scenario.recording.table import RecordTable, final
from sim.scenario.refusals.files import files_in, near_files
from sim.scenario.refusals.sound import sound_part
from sim.scenario.refusals.units import in_words_of
from sim.scenario.schema import DEFAULT_MODE, DEFAULT_ROUTE, ROUTES, file_model, kind_of, owner_of, parts_of
from sim.scenario.tables import (
    HIGHEST_FLIGHT,
    STARTS,
    AircraftChoice,
    AirTable,
    AutopilotTable,
    Check,
    Contrast,
    Departure,
    Runway,
    SensorFault,
    Start,
    StudyTable,
    WindTable,
)
from tracking.track import is_recorded

SHORTEST_PERIOD = (1 - 1e-9) / 120  # s; the flight is not known in finer steps
LARGEST_FILE = 1 << 20  # bytes; a scenario is a page of text
DEEPEST = 100  # dots of one key; many more would keep the reader busy for minutes
MOST_NAMED = 4  # bundled scenarios of a hint
LONGEST_PATH = 200  # characters that are repeated to the user
DEFAULTS: dict[str, Any] = {"seed": 1, "flights": 1, "draws": 130, "until_s": None}


Source = str | Path | dict[str, Any]
"""A file, a bundled name, or a dict of tables."""


def read(
    source: Source,
    overrides: Mapping[str, Any] | None = None,
    *,
    plugins: Plugins = (),
    checks: Callable[[dict[str, Any]], list[str]] | None = None,
) -> Scenario:
    """A scenario from a file, a bundled name or a dict of tables, with ``table.key`` overrides.

    ``plugins`` bring kinds that are not bundled: paths of files, or imported modules, with a table ``SHORTFINAL``.
    ``checks`` tells what is wrong with the names in the tables' checks: which metrics there are is known to the caller.

    Raises ``ScenarioError`` with one line for each fault.
    """
    catalogue = catalogue_with(plugins)
    origin, tables = _load(source)
    for address, value in (overrides or {}).items():
        tables = override(tables, address, value)
    tables = completed_record(located(tables, Path()), parsed)
    return _build(origin, tables, catalogue, checks(tables) if checks is not None else [])


def override(tables: dict[str, Any], address: str, value: Any) -> dict[str, Any]:
    """The tables with one value replaced; another spelling of the same value is taken out."""
    return _replaced(tables, address, value, address)


def _replaced(tables: dict[str, Any], address: str, value: Any, whole: str) -> dict[str, Any]:
    head, dot, rest = address.partition(".")
    if not head or (dot and not rest):
        raise ScenarioError(f"--set {whole}: a part of the key is empty; write table.key=value")
    if rest:
        inner = tables.get(head, {})
        if isinstance(inner, list):
            index, _, below = rest.partition(".")
            if not (index.isascii() and index.isdigit()) or int(index) >= len(inner):
                raise ScenarioError(f"--set {whole}: [[{head}]] {_entries(inner)}")
            items = list(inner)
            if below and not isinstance(items[int(index)], dict):
                raise ScenarioError(f"--set {whole}: entry {index} of [[{head}]] is a value, not a table")
            items[int(index)] = _replaced(items[int(index)], below, value, whole) if below else value
            return {**tables, head: items}
        if not isinstance(inner, dict):
            raise ScenarioError(f"--set {whole}: '{head}' is a value, not a table")
        return {**tables, head: _replaced(inner, rest, value, whole)}
    kept = {key: old for key, old in tables.items() if key == head or quantity(key) != quantity(head)}
    return {**kept, head: value}


def _entries(items: list[Any]) -> str:
    return f"has entries 0 to {len(items) - 1}" if items else "has no entries"


def _load(source: str | Path | dict[str, Any]) -> tuple[str, dict[str, Any]]:
    if isinstance(source, dict):
        return "scenario", source
    origin, content, path = content_of(str(source))
    tables = parsed(origin, content)
    if not tables:
        raise ScenarioError(f"{origin}: says nothing; 'shortfinal new FILE.toml' writes a scenario to start from")
    return origin, placed(tables, path)


def content_of(source: str) -> tuple[str, bytes, Path | None]:
    """What messages call a scenario, its text, and the path of its file; None of a bundled one."""
    ours = bundled.bundled(source)
    if ours is not None:
        return f"{source}.toml", ours.read_bytes(), None
    path = Path(source)
    return str(path), _content(path, source), path


def placed(tables: dict[str, Any], path: Path | None) -> dict[str, Any]:
    """The tables of a file, called by it where they have no name, with other files counted from its folder."""
    if path is None:
        return tables
    named = {"name": path.stem.removesuffix(".scenario"), **tables}
    return located(beside_file(named, path.parent), path.parent)


def parsed(origin: str, content: bytes) -> dict[str, Any]:
    """The tables of a file, which may be anybody's; raises ``ScenarioError`` in one sentence."""
    if max(piece.count(b".") for piece in re.split(rb"[=,\[\]{}\n]", content)) > DEEPEST:
        raise ScenarioError(f"{origin}: not TOML: nested too deeply")
    try:
        return tomllib.loads(content.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise ScenarioError(f"{origin}: not UTF-8 text; save the file as UTF-8") from None
    except RecursionError:
        raise ScenarioError(f"{origin}: not TOML: nested too deeply") from None
    except ValueError as error:  # of its grammar, or of a number with thousands of digits
        what = "" if Path(origin).suffix in ("", ".toml") else "; a scenario is a TOML file, NAME.toml"
        raise ScenarioError(report_faults(origin, [f"not TOML: {str(error).partition(';')[0]}{what}"])) from None


def read_runway(path: Path) -> tuple[Runway, Air]:
    """The runway of a TOML file, and the air over it; raises ``ScenarioError`` with one line for each fault."""
    tables = {"name": "runway", **runway_file(path, parsed)}
    scenario = _build(str(path), tables, catalogue_with(()), [])
    return scenario.runway, scenario.air


def _content(path: Path, source: str) -> bytes:
    """The bytes of a file that is to be a scenario."""
    try:
        if path.is_file():
            with path.open("rb") as file:
                content = file.read(LARGEST_FILE + 1)
            if len(content) > LARGEST_FILE:
                raise ScenarioError(f"{path}: larger than {LARGEST_FILE} bytes, which no scenario is")
            return content
        if path.is_dir():
            inside = f", such as {own[0]}" if (own := files_in(path)) else ""
            raise ScenarioError(f"{path}: is a folder; name a scenario file in it{inside}")
        if path.exists():
            raise ScenarioError(f"{path}: no regular file")
        near = near_files(path)
        if path.suffix == ".toml" or "/" in source:
            raise ScenarioError(f"{path}: no such file{f'; did you mean {near[0]}?' if near else ''}")
    except OSError as error:
        raise ScenarioError(f"{str(path)[:LONGEST_PATH]}: cannot be read: {error.strerror}") from None
    raise ScenarioError(
        report_faults(f"no scenario '{source}'", [f"did you mean {near[0]}?" if near else _bundled(source)])
    )


def _bundled(word: str) -> str:
    """Which bundled scenarios somebody may have meant."""
    names = [*bundled.scenarios(), *bundled.studies()]
    begun = [name for name in names if word and name.startswith(word)]
    if len(begun) > 1:
        others = " or another of them" if len(begun) > MOST_NAMED else ""
        return f"did you mean {', '.join(begun[:MOST_NAMED])}{others}? 'shortfinal list' shows all"
    near = did_you_mean(word, names)
    return (
        near
        if near.startswith("did")
        else "'shortfinal list' shows those that are bundled; else name a file, NAME.toml"
    )


def _build(origin: str, tables: dict[str, Any], catalogue: Catalogue, told_of_checks: list[str]) -> Scenario:
    whole, broken = tables, _broken(tables, catalogue)
    tables, numbers = sound_part(tables, broken)
    if broken and (len(broken) > MOST_FAULTS or _broken(tables, catalogue)):  # what is left cannot be asked further
        raise ScenarioError(report_faults(origin, [*broken, *told_of_checks]))
    faults = [*broken, *told_of_checks]
    all_sensors, all_trackers = (
        named if isinstance(named := whole.get(family), dict) else {} for family in ("sensors", "trackers")
    )

    def table(name: str, cls: type, true_share: TrueShare | None = None) -> Any:
        return _construct(faults, f"[{name}]", cls, tables.get(name, {}), true_share)

    is_recorded = tables.get("record") is not None
    if is_recorded and not broken:
        faults += strangers(tables)
    record = table("record", RecordTable) if is_recorded else None
    runway = table("runway", Runway) or Runway()
    air_table = table("air", AirTable) or AirTable()
    air = Air(runway.elevation, air_table.kelvin, air_table.qnh)
    route_kind = kind_of(tables.get("route", {}), DEFAULT_ROUTE)
    route = table("route", ROUTES[route_kind or DEFAULT_ROUTE], functools.partial(_true_share, air))
    if is_recorded and "route" not in tables:
        route = final(runway)
    mode = kind_of(tables.get("autopilot", {}), DEFAULT_MODE) or ""
    autopilot_table = {k: v for k, v in tables.get("autopilot", {}).items() if k != "law"}
    modes = _modes(faults, mode, numbers("departures"), catalogue)
    law_table = tables.get("autopilot", {}).get("law", {})
    sensors = {
        name: _construct(
            faults, f"[sensors.{name}]", catalogue.load("sensors", entry["kind"]), entry, runway=runway, air=air
        )
        for name, entry in tables.get("sensors", {}).items()
    }
    for name, sensor in sensors.items():
        period = None if sensor is None else getattr(sensor, "period", None)
        if sensor is not None and not (isinstance(period, int | float) and SHORTEST_PERIOD <= period < math.inf):
            faults.append(f"[sensors.{name}] period must be a number of at least 1/120 s, not {period!r}")
    trackers = {
        name: _tracker(
            faults, name, catalogue.load("trackers", entry["kind"]), entry, all_sensors, all_trackers, runway
        )
        for name, entry in tables.get("trackers", {}).items()
        if isinstance(whole.get("sensors", {}), dict)  # else it is not known what they could listen to
    }
    for i, entry in numbers("sensor_faults"):
        if (own := entry["sensor"]) not in all_sensors:
            faults.append(f"[[sensor_faults]] entry {i} sensor: no sensor '{own}'; {did_you_mean(own, all_sensors)}")
    wind_table = tables.get("wind", {})
    events = {
        name: _event(faults, f"[wind.events.{name}]", catalogue.load("wind_events", entry["kind"]), entry, runway)
        for name, entry in wind_table.get("events", {}).items()
    }
    scenario = {
        "name": tables["name"],
        "seed": tables.get("seed", DEFAULTS["seed"]),
        "flights": tables.get("flights", DEFAULTS["flights"]),
        "draws": _draws(faults, tables, sensors),
        "until": tables.get("until_s"),
        "record": record,
        "runway": runway,
        "aircraft": table("aircraft", AircraftChoice),
        "start": table(
            "start", Start, functools.partial(_true_share, air, otherwise=_start_height(tables, route, runway))
        ),
        "air": air_table,
        "route": route,
        "autopilot": _construct(faults, "[autopilot]", AutopilotTable, autopilot_table),
        "mode": mode,
        "modes": modes,
        "law": given_values(modes[mode], law_table),
        "designed": tables.get("designed"),
        "wind": _construct(faults, "[wind]", WindTable, wind_table, events=events, runway=runway),
        "sensors": sensors,
        "trackers": trackers,
        **{
            several: tuple(_construct(faults, f"[[{several}]] entry {i}", cls, entry) for i, entry in numbers(several))
            for several, cls in (
                ("departures", Departure),
                ("sensor_faults", SensorFault),
                ("contrasts", Contrast),
                ("checks", Check),
            )
        },
        "study": table("study", StudyTable) if tables.get("study") is not None else None,
        "navigation_errors": None
        if tables.get("navigation_errors") is None
        else table("navigation_errors", NavigationErrors),
    }
    if not broken:
        faults += [*_told_twice(scenario["contrasts"]), *faults_of_plots(tables, record, sensors)]
    navigation = tables.get("autopilot", {}).get("navigation", "truth")
    if navigation != "truth" and navigation not in all_trackers:
        faults.append(
            f"[autopilot] navigation: no tracker '{navigation}'; {did_you_mean(navigation, ['truth', *all_trackers])}"
        )
    if navigation != "truth" and tables.get("navigation_errors") is not None:
        faults.append(
            '[navigation_errors] belongs to navigation = "truth": a tracker that navigates has its own errors'
        )
    if faults:
        raise ScenarioError(report_faults(origin, faults))
    named = [
        *(("modes", name) for name in modes),
        *(("sensors", entry["kind"]) for entry in tables.get("sensors", {}).values()),
        *(("trackers", choice.kind) for choice in trackers.values()),
        *(("wind_events", entry["kind"]) for entry in wind_table.get("events", {}).values()),
    ]
    parts = sorted({part for family, kind in named if (part := catalogue.named(family, kind)) is not None})
    resolved = _resolved(tables, scenario)
    return Scenario(**{**scenario, "air": air}, tables=resolved, parts=tuple(parts))


def _broken(tables: dict[str, Any], catalogue: Catalogue) -> list[str]:
    """Faults of the tables against the model of their file."""
    faults: list[str] = []
    model = file_model(**parts_of(tables, faults, catalogue))
    try:
        model.model_validate(tables)
    except ValidationError as error:
        faults += faults_of(model, error, lambda place, key: owner_of(tables, place, key))
    return faults


def _told_twice(contrasts: tuple[Contrast | None, ...]) -> list[str]:
    """Faults of contrasts of two trackers that an earlier entry has already."""
    pairs = [None if one is None else one.pair for one in contrasts]
    return [
        f"[[contrasts]] entry {number}: '{one.of}' against '{one.against}' is entry {pairs.index(one.pair)} already"
        for number, one in enumerate(contrasts)
        if one is not None and pairs.index(one.pair) < number
    ]


def _modes(
    faults: list[str], mode: str, departures: Iterable[tuple[int, Any]], catalogue: Catalogue
) -> dict[str, type[Any]]:
    """Classes of the modes that are named by their kind: of the autopilot, and of what it is left for."""
    found = {mode: catalogue.load("modes", mode)}
    for number, entry in departures:
        try:
            found[entry["flies"]] = catalogue.load("modes", entry["flies"])
        except KeyError:
            continue  # a hand, or a law by its intent: prepare() knows them
        except ScenarioError as error:
            faults.append(f"[[departures]] entry {number} flies: {error}")
    return found


def _draws(faults: list[str], tables: dict[str, Any], sensors: dict[str, Any]) -> int:
    """Noise draws per flight: one where a tracker flies the aircraft, since its noise then shapes the flight.

    One too where all plots are recorded, since there is no noise to draw.
    """
    if tables.get("autopilot", {}).get("navigation", "truth") != "truth":
        why = "where a tracker navigates, because its noise shapes the flight; use 'flights'"
    elif sensors and len(recorded(sensors)) == len(sensors):
        why = "where all sensors are recorded, because every draw would see the same plots"
    else:
        return int(tables.get("draws", DEFAULTS["draws"]))
    if tables.get("draws", 1) != 1:
        faults.append(f"draws: must be 1 {why}")
    return 1


def _true_share(air: Air, height: float | None, otherwise: float = 0.0) -> float:
    """True over indicated airspeed at a height, m; ``otherwise`` where none is said. What no table allows is left."""
    height = otherwise if height is None else height
    return float(1.0 / air.equivalent_share(height)) if 0.0 <= height <= HIGHEST_FLIGHT else 1.0


def _start_height(tables: dict[str, Any], route: Route | None, runway: Runway) -> float:
    """Where a flight begins whose [start] says no height, m: that of its leg, or on the glide path under it."""
    table = {key: value for key, value in tables.get("start", {}).items() if quantity(key) != "speed"}
    start = given_values(Start, table)
    number = STARTS.get(start.get("phase", ""), start.get("leg", 0))
    levels = () if route is None else route.levels
    if route is not None and route.final is not None:
        distance = start.get("distance", math.inf) if number == route.final else math.inf
        return min(levels[0][2], float(distance) * math.tan(runway.glide_path))
    return levels[number][2] if 0 <= number < len(levels) else 0.0


def _construct(
    faults: list[str],
    place: str,
    cls: type,
    table: dict[str, Any],
    true_share: TrueShare | None = None,
    **given: Any,
) -> Any:
    try:
        return construct(cls, table, true_share, **given)
    except ValueError as error:
        faults.append(f"{place} {in_words_of(cls, table, str(error))}")
    except Exception as error:
        if not is_outside(cls):
            raise
        faults.append(f"{place} making it raises {said(error)}")
    return None


def _event(faults: list[str], place: str, cls: type, table: dict[str, Any], runway: Runway) -> Any:
    """A wind event that keeps its contract; what one breaks is a fault of the file that names it."""
    event = _construct(faults, place, cls, table, runway=runway)
    if event is not None:
        faults += [f"{place} kind '{table['kind']}': {broken}" for broken in broken_promises(cls, lambda: event)]
    return event


def _tracker(
    faults: list[str],
    name: str,
    cls: type,
    table: dict[str, Any],
    sensors: dict[str, Any],
    others: dict[str, Any],
    runway: Runway,
) -> TrackerChoice:
    wanted = table.get("sensors", list(sensors))
    for sensor in wanted:
        if sensor not in sensors:
            faults.append(f"[trackers.{name}] sensors: no sensor '{sensor}'; {did_you_mean(sensor, sensors)}")
    if not wanted:
        faults.append(f"[trackers.{name}] sensors: a tracker needs at least one sensor")
    handover = table.get("handover")
    if handover is not None and (handover not in others or handover == name):
        rest = [other for other in others if other != name]
        faults.append(f"[trackers.{name}] handover: no other tracker '{handover}'; {did_you_mean(handover, rest)}")
    own = {k: v for k, v in table.items() if k not in ("kind", "sensors", "handover", "law", "association")}
    law, association = table.get("law", {}), table.get("association")
    if is_recorded(cls):
        brought = _construct(faults, f"[trackers.{name}]", cls, own, runway=runway)
        own = own if brought is None else _completed(brought, own)
    return TrackerChoice(table["kind"], cls, tuple(wanted), handover, own, law, association)


def _resolved(tables: dict[str, Any], built: dict[str, Any]) -> dict[str, Any]:
    """The file with every default written out, the user's own spellings kept."""
    out: dict[str, Any] = {key: built[key] for key in ("name", "seed", "flights", "draws")}
    out["until_s"] = built["until"]
    flown = () if built["record"] is not None else ("aircraft", "start", "route", "autopilot", "wind")
    if built["record"] is not None:
        out |= {name: tables[name] for name in ("record", "route", "autopilot") if name in tables}
    for name in ("runway", "air", *flown):
        given = tables.get(name, {})
        kind = {"route": kind_of(given, DEFAULT_ROUTE), "autopilot": built["mode"]}.get(name)
        law = {"law": given["law"]} if "law" in given else {}
        out[name] = ({"kind": kind} if kind else {}) | _completed(built[name], given) | law
    if flown and built["wind"].events:
        out["wind"]["events"] = {
            name: {"kind": tables["wind"]["events"][name]["kind"]} | _completed(event, tables["wind"]["events"][name])
            for name, event in built["wind"].events.items()
        }
    out["designed"] = tables.get("designed")
    out["sensors"] = {
        name: {"kind": tables["sensors"][name]["kind"]} | _completed(sensor, tables["sensors"][name])
        for name, sensor in built["sensors"].items()
    }
    out["trackers"] = {
        name: {**tables["trackers"][name], **choice.table, "sensors": list(choice.sensors)}
        for name, choice in built["trackers"].items()
    }
    for several in ("departures", "sensor_faults", "contrasts"):
        if tables.get(several):
            out[several] = list(tables[several])
    if built["navigation_errors"] is not None:
        out["navigation_errors"] = _completed(built["navigation_errors"], tables["navigation_errors"])
    out["checks"] = list(tables.get("checks", []))
    out["study"] = tables.get("study")
    return out


def _completed(instance: Any, given: dict[str, Any]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    spelt = spellings_in(type(instance), given)
    for parameter in parameters(type(instance)):
        if (key := spelt.get(parameter.attribute)) is not None:
            table[key] = given[key]
        else:
            table |= dump(instance, parameter)
    return table
