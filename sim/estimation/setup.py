"""Trackers of a scenario with what the simulation supplies: law, route, sensor geometry; never the truth."""

from __future__ import annotations

import dataclasses
import math
import typing
from collections.abc import Mapping
from typing import Annotated, Any

from aircraft.state import STANDARD_GRAVITY
from autopilot.planned_heights import planned_heights
from sim.errors import ScenarioError
from sim.estimation.clutter import AmongFalsePlots
from sim.flight.preparation import Prepared
from sim.metrics.conformance import MISMATCHED
from sim.observation.record import refuse_unknown
from sim.observation.sensor import unplaced
from sim.scenario.model import TrackerChoice
from sim.scenario.parameters import GIVEN, construct
from sim.scenario.plugins import is_outside, said
from tracking.contract import missing_members
from tracking.height_profile import ChartedHeight, HeightProfile, MeasuredHeight
from tracking.measurement import DebiasedPolar, LinearMeasurement, MeasurementModel, Stacked
from tracking.partial_place import Azimuth, Chosen, SlantRange
from tracking.track import TrackerError, is_recorded


def reads_places(tracker: Any) -> bool:
    return dataclasses.is_dataclass(tracker) and uses_places(type(tracker))


def uses_places(cls: type) -> bool:
    """Whether trackers of a class update with a place on the ground plane."""
    return "measurement" in _given(cls)


def told(prepared: Prepared, cls: type) -> str:
    """What trackers of a class are given of the autopilot, in words; empty = nothing."""
    words = {
        "law": "law",
        "alternative_laws": "other laws",
        "bank_limit": f"bank limit {math.degrees(float(prepared.law.bank_limit)):.4g} deg",
        "route": "route",
    }
    return ", ".join(words[field] for field in words if field in _given(cls))


def build(prepared: Prepared, name: str, choice: TrackerChoice) -> tuple[Any, str | None]:
    """A tracker with what the simulation gives it, and where its assumed law comes from (None = it needs none).

    Raises ``ScenarioError`` where its sensors do not give what it needs.
    """
    try:
        tracker, law_from = untried(prepared, name, choice)
    except TrackerError as error:
        raise ScenarioError(f"[trackers.{name}] kind '{choice.kind}': {error}") from None
    for missing in missing_members(tracker):
        raise ScenarioError(f"[trackers.{name}] kind '{choice.kind}': {missing}")
    return tracker, law_from


def untried(prepared: Prepared, name: str, choice: TrackerChoice) -> tuple[Any, str | None]:
    """`build` for a class that may be no tracker; `tracking.track` lists what a tracker may be given.

    Raises ``TrackerError`` where making one raises something else than ``ValueError``.
    """
    cls = choice.cls
    if is_recorded(cls):
        return _brought(prepared, name, choice), None
    wanted = _given(cls)
    sensors = {sensor: prepared.scenario.sensors[sensor] for sensor in choice.sensors}
    supplied: dict[str, Any] = {}
    law_from = None
    if choice.law and "law" not in wanted:
        raise ScenarioError(f"[trackers.{name}.law] kind '{choice.kind}' uses no law")
    if "law" in wanted:
        supplied["law"], law_from = changed_law(prepared.law, f"[trackers.{name}.law]", choice.law)
    if "alternative_laws" in wanted:
        supplied["alternative_laws"] = prepared.alternative_laws
    if "bank_limit" in wanted:
        supplied["bank_limit"] = float(prepared.law.bank_limit)
    if "route" in wanted:
        supplied["route"] = charted_route(prepared)
    if "measurement" in wanted:
        places = {s: sensor for s, sensor in sensors.items() if "measured" not in wanted or sensor.gives_place}
        supplied["measurement"] = measurement_model(prepared, places, name)
    if "measured" in wanted:
        supplied["measured"] = tuple(f"{s}.{channel}" for s, sensor in sensors.items() for channel in sensor.channels)
    if "zero_azimuth" in wanted:
        radar = next((sensor for sensor in sensors.values() if sensor.zero_azimuth is not None), None)
        if radar is None:
            raise ScenarioError(f"[trackers.{name}] kind '{choice.kind}' needs a sensor that measures an azimuth")
        supplied["zero_azimuth"] = radar.zero_azimuth
    missing = [field for field, required in wanted.items() if required and field not in supplied]
    if missing:
        raise ScenarioError(f"[trackers.{name}] kind '{choice.kind}' needs {missing[0]}, which no scenario gives")
    if choice.association is not None and ("measurement" not in wanted or "measured" in wanted):
        raise ScenarioError(f"[trackers.{name}] association: kind '{choice.kind}' does not track on the ground plane")
    try:
        tracker = construct(cls, choice.table, **supplied)
    except ValueError as error:
        raise ScenarioError(f"[trackers.{name}] {error}") from None
    except Exception as error:
        if not is_outside(cls):
            raise
        raise TrackerError(f"making one raises {said(error)}") from None
    if choice.association is None:
        if with_clutter(sensors):
            raise ScenarioError(
                f"[trackers.{name}] sensors: '{with_clutter(sensors)[0]}' has clutter; "
                'set association = "probabilistic", with it as the only sensor'
            )
        return tracker, law_from
    return AmongFalsePlots(tracker, _cluttered(name, sensors)), law_from


def _brought(prepared: Prepared, name: str, choice: TrackerChoice) -> Any:
    """A tracker that brings its estimates; raises ``ScenarioError`` for what it cannot be asked."""
    scenario, place = prepared.scenario, f"[trackers.{name}]"
    asked = {"law": choice.law, "handover": choice.handover, "association": choice.association}
    for key, value in asked.items():
        if value:
            raise ScenarioError(f"{place} {key}: a recorded track is judged as it is; take {key} out")
    if scenario.autopilot.navigation == name:
        raise ScenarioError(f"[autopilot] navigation: '{name}' is recorded, and cannot lead an aircraft")
    if scenario.study is not None:
        raise ScenarioError(f"{place} is the track of one flight, and [study] flies others")
    try:
        return construct(choice.cls, choice.table, runway=scenario.runway)
    except ValueError as error:
        raise ScenarioError(f"{place} {error}") from None


def _cluttered(name: str, sensors: dict[str, Any]) -> Any:
    """The one sensor of a tracker that associates."""
    radar = next(iter(sensors.values()))
    if len(sensors) > 1 or not with_clutter(sensors):
        raise ScenarioError(
            f"[trackers.{name}] association: needs exactly one sensor, a radar with clutter above 0; "
            f"it has {', '.join(sensors)}"
        )
    if not radar.detection > 0.0:
        raise ScenarioError(f"[trackers.{name}] association: its radar never detects the target (detection = 0)")
    return radar


def with_clutter(sensors: dict[str, Any]) -> list[str]:
    """Sensors whose looks hold false plots."""
    return [name for name, sensor in sensors.items() if sensor.clutter > 0.0]


def _given(cls: type) -> dict[str, bool]:
    """Fields that the simulation fills, and whether they must be filled."""
    hints = typing.get_type_hints(cls, include_extras=True)
    return {
        field.name: field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        for field in dataclasses.fields(cls)
        if typing.get_origin(hints[field.name]) is Annotated and GIVEN in hints[field.name].__metadata__
    }


def check(prepared: Prepared) -> None:
    """Build every tracker once, so that what cannot be tracked is refused before anything flies."""
    if prepared.recording is not None:
        refuse_unknown(prepared.recording, prepared.scenario.sensors)
    for name, sensor in prepared.scenario.sensors.items():
        for sentence in unplaced(sensor):
            raise ScenarioError(f"[sensors.{name}] {sentence}")
    choices = prepared.scenario.trackers
    built = {name: build(prepared, name, choice)[0] for name, choice in choices.items()}
    for name, choice in choices.items():
        before, chain = choice.handover, [name]
        while before is not None:
            if before in chain:
                raise ScenarioError(
                    f"[trackers.{name}] handover: goes round in a circle, {' <- '.join([*chain, before])}"
                )
            if is_recorded(built[before]):
                raise ScenarioError(f"[trackers.{chain[-1]}] handover: '{before}' is recorded, and hands nothing over")
            chain.append(before)
            before = choices[before].handover
        if choice.handover is not None:
            lacking = [c for c in built[name].channels if c not in built[choice.handover].channels]
            if lacking:
                raise ScenarioError(f"[trackers.{name}] handover: '{choice.handover}' does not estimate {lacking[0]}")


def changed_law(law: Any, place: str, asked: Mapping[str, float]) -> tuple[Any, str]:
    """The law that a tracker assumes, and its origin: the law that flies, with values (SI) or factors.

    ``place`` is where they are asked for.
    """
    changes = {}
    fields = [field.name for field in dataclasses.fields(law) if not isinstance(getattr(law, field.name), str)]
    for key, value in asked.items():
        attribute = key.removesuffix("_factor")
        if attribute not in fields:
            names = ", ".join(f"{field}_factor" for field in fields)
            raise ScenarioError(f"{place} {key}: no such key; allowed: {names}")
        changes[attribute] = value * getattr(law, attribute) if key.endswith("_factor") else value
    try:
        return dataclasses.replace(law, **changes), MISMATCHED if changes else "autopilot"
    except ValueError as error:
        raise ScenarioError(f"{place} {error}") from None


def charted_route(prepared: Prepared) -> Any:
    """The route with the speeds that its chart shows: of each leg, of its schedule, and of a glide path.

    A recording for which no route is told has a final without speeds.
    """
    route, landing = prepared.route, prepared.autopilot.landing
    if not prepared.scenario.has_route:
        return route
    last = len(route.legs) - 1
    # the glide path begins where it leaves the height of the leg
    scheduled = tuple((last, begins, speed) for begins, speed in prepared.autopilot.speeds)
    glide = () if landing is None else ((last, route.legs[last].height / landing.slope, landing.approach_speed),)
    return dataclasses.replace(route, chart=(*scheduled, *glide))


def height_profile(prepared: Prepared) -> HeightProfile:
    """The heights that are taken for granted where a range is read without one: as planned, never the true ones.

    The plan begins where the flight is filed to begin.
    """
    approach, initial = prepared.autopilot, prepared.initial
    legs = approach.route.legs
    first = legs[initial.leg]
    to_go = (first.end[0] - initial.north) * first.direction[0] + (first.end[1] - initial.east) * first.direction[1]
    planned = planned_heights(approach, initial.leg, to_go, initial.height)
    along, height, _ = zip(*planned, strict=True)
    fastest = max(leg.speed for leg in legs)
    return HeightProfile(
        tuple((*leg.start, *leg.end) for leg in legs),
        along,
        height,
        next((point.along for point in planned if point.on_glide_path), math.inf),
        fastest**2 / (STANDARD_GRAVITY * math.tan(float(approach.law.bank_limit))),
    )


def measurement_model(prepared: Prepared, sensors: dict[str, Any], name: str) -> Any:
    """How the looks of sensors become what a tracker on the ground plane updates with.

    A sensor that gives a place is read as one; an azimuth or a slant range of one that does not is a row of its own.
    What else they measure is left out. Raises ``ScenarioError`` for a sensor that has nothing for such a tracker, and
    where all together give no place.
    """
    models: list[MeasurementModel] = []
    for sensor_name, sensor in sensors.items():
        model = sensor_model(prepared, sensor)
        if model is None:
            raise ScenarioError(
                f"[trackers.{name}] sensors: '{sensor_name}' measures {_listed(sensor)}, which is no position; "
                f"a tracker on the ground plane uses {USED}"
            )
        models.append(model)
    if not any(sensor.gives_place for sensor in sensors.values()):
        azimuths = sum("azimuth" in sensor.channels for sensor in sensors.values())
        ranges = sum("range" in sensor.channels for sensor in sensors.values())
        if azimuths == 0 or azimuths + ranges < 2:
            measured = "; ".join(f"'{sensor_name}' {_listed(sensor)}" for sensor_name, sensor in sensors.items())
            raise ScenarioError(
                f"[trackers.{name}] sensors: {measured or 'none'}: from that alone no position follows; a tracker on "
                f"the ground plane needs {USED}"
            )
    return models[0] if len(models) == 1 else Stacked(tuple(models))


USED = "north and east, or range and azimuth, of one sensor or of two"


def _listed(sensor: Any) -> str:
    return ", ".join(sensor.channels)


def sensor_model(prepared: Prepared, sensor: Any) -> MeasurementModel | None:
    """How one sensor is read; None = it measures nothing of a place on the ground plane."""
    channels = sensor.channels
    used: tuple[str, ...]
    model: MeasurementModel
    if sensor.gives_place and "north" in channels:
        used = ("north", "east")
        model = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
    elif sensor.gives_place:
        north, east, up = sensor.antenna
        model = DebiasedPolar((north, east), sensor.zero_azimuth)
        if "elevation" in channels:
            used = ("range", "azimuth", "elevation")
        elif "height" in channels:
            used, model = ("range", "azimuth", "height"), MeasuredHeight(model, up)
        else:
            used, model = ("range", "azimuth"), ChartedHeight(model, height_profile(prepared), up)
    else:
        used = tuple(channel for channel in channels if channel in ("azimuth", "range"))
        parts = tuple(_row(prepared, sensor, channel) for channel in used)
        if not parts:
            return None
        model = parts[0] if len(parts) == 1 else Stacked(parts)
    rows = tuple(channels.index(channel) for channel in used)
    return model if rows == tuple(range(len(channels))) else Chosen(model, rows, len(channels))


def _row(prepared: Prepared, sensor: Any, channel: str) -> MeasurementModel:
    north, east, up = sensor.antenna
    if channel == "azimuth":
        return Azimuth((north, east), sensor.zero_azimuth)
    return SlantRange((north, east, up), height_profile(prepared))
