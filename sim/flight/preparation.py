"""prepare(): from a scenario to what flies; everything that can be refused is refused here, before the first step."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from aircraft.airframe import Wind
from aircraft.data import AircraftData
from aircraft.errors import ModelError
from aircraft.model_files import digest, read
from aircraft.point_mass import PointMass
from aircraft.properties import FOOT
from aircraft.runway import Runway as Place
from aircraft.slowest import complete
from autopilot.approach import PHASES, Approach
from autopilot.departure import Departing
from autopilot.design import Designed, law_of_frequency, pull
from autopilot.estimate_lag import softened
from autopilot.landing import REFERENCE_MARGIN, Landing
from autopilot.mode import DesignCase, Mode
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import Leg, Route, pattern_route
from autopilot.route_loop import RouteLoop, lag_loop
from autopilot.stabilised_gate import StabilisedGate
from autopilot.swing_margin import shallower
from autopilot.vectored import Vectored
from sim.errors import ScenarioError, did_you_mean
from sim.flight import departures, swings
from sim.flight.airspeeds import (
    MANOEUVRE_MARGIN,
    REFERENCE_ADDITION,
    landing_stall_speed,
    least_approach_speed,
    level_speeds,
    remarks,
)
from sim.flight.arrivals import vectoring
from sim.flight.gains import Gains, gains_for, known_design, known_flap_settings, plain
from sim.flight.outcomes import Limits
from sim.flight.record import Flight
from sim.flight.recording.flight import REMARK
from sim.flight.recording.flights import recording
from sim.flight.recording.unknown import FINAL_TAKEN, unknown_flight
from sim.flight.vehicles import (
    AirframeChoice,
    Configuration,
    Initial,
    JsbsimVehicle,
    PointMassVehicle,
    designed,
    designed_point_mass,
    leg_loop,
)
from sim.flight.weather import air
from sim.randomness import Streams
from sim.scenario import catalogue
from sim.scenario.arrivals.vectored import VectoredTable
from sim.scenario.messages import at
from sim.scenario.model import Scenario
from sim.scenario.plugins import BUNDLED, is_outside, said
from sim.scenario.recording.table import RecordTable
from sim.scenario.refusals.units import in_words_of
from sim.scenario.tables import STARTS, LegsTable, PatternTable
from sim.workers.isolation import run_isolated

MODEL_TIME_LIMIT = 120.0  # s; an aircraft that is not ours may never trim
SINK_MARGIN = 1.2  # of the gate over the sink of a fast approach, which is briefed for more than 1000 ft/min [FSF ALAR]


@dataclass(frozen=True)
class Prepared:
    """All that one flight needs; built once in the parent, flown anywhere."""

    scenario: Scenario
    autopilot: Approach
    vehicle: Any
    initial: Initial
    limits: Limits
    gains: Gains  # as they travel in the scenario's file
    designed: Designed  # as they fly: intercepts may be shallower in this wind
    rate: float  # Hz, of the equations of motion
    warnings: tuple[str, ...]
    stall_speed: float | None = None  # m/s, equivalent, as it lands; None where none is known
    recording: Flight | None = None  # a flight that was flown elsewhere, in place of one that is flown here

    def __repr__(self) -> str:
        """One line; all that it holds fills pages."""
        scenario = self.scenario
        return f"<Prepared {scenario.name}: {scenario.aircraft.model} on {len(self.route.legs)} legs, {self.law!r}>"

    @property
    def design(self) -> dict[str, Any] | None:
        """The gains as they travel in the scenario's file; None = nothing is flown by them."""
        return None if self.recording is not None else self.gains.to_table()

    @property
    def controller(self) -> Approach | Departing | Vectored:
        """The autopilot, and from the stated departure times on what is flown instead of it; vectors before it."""
        flown = departures.controller(self.autopilot, self.law_called, self.scenario.departures)
        table = self.scenario.route
        if isinstance(table, VectoredTable):
            tracking = vectoring.tracking(self.scenario, self.designed, self.autopilot)
            tracked = departures.controller(tracking, self.law_called, self.scenario.departures)
            return vectoring.vectored(self.scenario, table, self.autopilot, flown, tracked)
        return flown

    @property
    def departure(self) -> float | None:
        """When the law that trackers assume is first left, s; None = never."""
        return min((one.at for one in self.scenario.departures), default=None)

    def fault(self, sensors: tuple[str, ...]) -> float | None:
        """When something first goes wrong that a tracker of these sensors is not told, s; None = never."""
        worse = [one.at for one in self.scenario.sensor_faults if one.sensor in sensors and one.error_factor != 1.0]
        return min((one for one in (self.departure, *worse) if one is not None), default=None)

    @property
    def airframe(self) -> AirframeChoice:
        """The aircraft model, its loading, its runway and its rate."""
        return _airframe(self.scenario, self.rate)

    @property
    def route(self) -> Route:
        """The route that is flown."""
        return self.autopilot.route

    @property
    def law(self) -> Mode:
        """The law that flies it."""
        law: Mode = self.autopilot.law
        return law

    @property
    def has_route_loop(self) -> bool:
        """Whether a route law flies an aircraft that has inner loops."""
        return LateralNavigation.of(self.law) is not None and isinstance(self.vehicle, JsbsimVehicle)

    def route_loop(self) -> RouteLoop:
        """The linear loop, for margins and limit cycles, that flies the leg on which the flight begins.

        Raises ``ScenarioError`` where there is none.
        """
        if not self.has_route_loop:
            wanted = "margins need a JSBSim aircraft under a route law, such as 'lateral_navigation'"
            raise ScenarioError(f"{self.scenario.name}: {wanted}")
        return _loop(self.scenario, self.designed, self.route.legs[self.initial.leg], self.autopilot.flaps)

    @property
    def alternative_laws(self) -> tuple[Mode, ...]:
        """The laws that the autopilot could be switched to: of its other standard modes, as designed.

        Modes that are not standard are left out, so that a mode from outside changes no scenario but those that name
        it; so are laws with the same intent as an earlier one, because a tracker could not tell them apart.
        """
        laws: dict[str, Mode] = {self.law.intent: self.law}
        for mode in self._modes.values():
            if mode.standard and mode.intent not in laws:
                laws[mode.intent] = mode.designed({}, self.case)
        return tuple(laws.values())[1:]

    @property
    def case(self) -> DesignCase:
        """What a law of this flight is designed for."""
        return _case(self.scenario, self.designed, self.route)

    def law_called(self, name: str) -> Mode:
        """The law of a mode, by its kind or by its intent without the word "law": the flown one, else as designed.

        Raises ``ValueError`` where no mode is called so.
        """
        modes = self._modes
        named = [name] if name in modes else [kind for kind in modes if modes[kind].intent == f"{name} law"]
        if self.scenario.mode in named:
            return self.law
        if not named:
            short = [mode.intent.removesuffix(" law") for mode in modes.values()]
            raise ValueError(f"flies: no law '{name}'; {did_you_mean(name, ['bank', 'offset', *short, *modes])}")
        return modes[named[0]].designed({}, self.case)

    @property
    def _modes(self) -> dict[str, type[Mode]]:
        """Every mode of the catalogue by its kind, and those from outside that the scenario names."""
        return {kind: BUNDLED.load("modes", kind) for kind in catalogue.kinds("modes")} | self.scenario.modes

    @property
    def gate_height(self) -> float | None:
        """Where the stabilised-approach gate begins, m; None = the route does not end in a landing."""
        landing = self.autopilot.landing
        return None if landing is None else landing.gate.height

    @property
    def phases(self) -> tuple[str, ...]:
        """Names of the phases by index."""
        return PHASES

    def wind(self, flight: int) -> Wind:
        """The air of one flight: turbulence has its own stream."""
        scenario = self.scenario
        noise = Streams(scenario.seed, flight, 1, "wind").generator("turbulence")
        return air(scenario.wind, scenario.runway, noise, self.rate)


def prepare(scenario: Scenario) -> Prepared:
    """Route, law, aircraft and limits of a scenario; raises ``ScenarioError`` with one sentence for each fault."""
    return run_isolated(scenario, MODEL_TIME_LIMIT, _prepared, scenario)


def _recorded(scenario: Scenario, record: RecordTable) -> Prepared:
    """A recorded flight, with the route and the law that trackers are told. They fly nothing here: the point mass lends
    its bank loop to laws that are designed."""
    place, told = functools.partial(at, scenario.name), scenario.autopilot
    with place("[route]"):
        route = _route(scenario, None)
        speed = max(leg.speed for leg in route.legs)
        gains = designed_point_mass(speed, told.bank_limit, told.roll_rate_limit)
        route = dataclasses.replace(route, time_to_roll=gains.time_to_roll(speed, told.roll_rate_limit))
    with place("[autopilot.law]"):
        law = _law(scenario, _case(scenario, gains, route))
        known = LateralNavigation.of(law)
        gains = gains if known is None else gains.with_law(known)
    with place("[route]"):
        glide = Landing(speed, speed / REFERENCE_MARGIN, glide_path=scenario.runway.glide_path)
        landing = None if scenario.has_route else glide
        autopilot = Approach(route, law, landing, roll_rate_limit=told.roll_rate_limit, allow_orbit=True)
        first = route.legs[0]
    with place("[record]"):
        if record.known:
            flight = recording(record, scenario.runway, scenario.air, route)
        else:
            flight = unknown_flight(route, scenario.sensors)
    remarks = tuple(event.detail for event in flight.events if event.name == REMARK)
    if not record.known and not scenario.has_route:
        remarks += (f"no [route] is told: {FINAL_TAKEN}, at most {first.height:.0f} m high",)
    return Prepared(
        scenario,
        autopilot,
        PointMassVehicle(PointMass(air=scenario.air)),
        Initial(*first.start, first.height, first.course, first.speed),
        Limits(scenario.until, scenario.runway),
        Gains(gains, None),
        gains,
        AircraftData("point mass").rate,
        remarks,
        recording=flight,
    )


def _prepared(scenario: Scenario) -> Prepared:
    if scenario.record is not None:
        return _recorded(scenario, scenario.record)
    place = functools.partial(at, scenario.name)
    asked = functools.partial(in_words_of, type(scenario.aircraft), scenario.tables["aircraft"])
    with place("[aircraft]", asked):
        aircraft = _data(scenario)
        flaps, landing = _configuration(scenario, aircraft)
    with place("[route]"):
        route = _route(scenario, landing)
    with place("[aircraft]"):
        found = _gains(scenario, route, flaps, landing)
        gains = found.designed
        turn_speed, fastest = _extremes(scenario)
        if len(route.legs) > 1:
            gains = shallower(gains, fastest, turn_speed - math.hypot(*route.wind))
        lead = gains.time_to_roll(turn_speed, scenario.autopilot.roll_rate_limit)
        route = dataclasses.replace(route, time_to_roll=lead, turning=gains.turning)
    with place("[autopilot.law]"):
        law = _law(scenario, _case(scenario, gains, route))
    with place("[autopilot]"):
        if landing is not None:
            landing = dataclasses.replace(landing, sideslip_bank=gains.bank_per_sideslip)
        rate_limit = scenario.autopilot.roll_rate_limit
        try:
            autopilot = Approach(
                route,
                law,
                landing,
                roll_rate_limit=rate_limit,
                **_decelerations(scenario),
                flaps=flaps,
                allow_orbit=scenario.autopilot.allow_orbit,
                offset=_offset(scenario, route),
                bank_lag=scenario.autopilot.bank_lag,
                speeds=vectoring.schedule(scenario.route) if isinstance(scenario.route, VectoredTable) else (),
            )
        except ValueError as error:
            if law != gains.law or scenario.autopilot.estimate_lag > 0.0:  # slow for another reason
                raise
            why = swings.slowness(_loop(scenario, gains, route.legs[0], flaps), gains, fastest, rate_limit)
            raise ValueError(f"{error}; {why}: allow a faster roll or less bank" if why else str(error)) from None
    with place("[start]"):
        initial = _initial(scenario, route, flaps, landing)
        vehicle = _vehicle(scenario, gains)
    with place("[aircraft]"):
        vehicle.read(vehicle.begin(initial, air(scenario.wind, scenario.runway)))  # it trims, or says why not
        flown = LateralNavigation.of(law)
        swing = ""
        if flown is not None and flown != gains.law:
            swing = swings.cause(_loop(scenario, gains, route.legs[initial.leg], flaps), flown, rate_limit)
    with place("[[departures]]"):
        limits = Limits(scenario.until, scenario.runway, swing=swing, swing_bank=0.5 * law.bank_limit)
        told = (*found.remarks, *_warnings(scenario, autopilot, aircraft, gains))
        if swing:
            own = f"the law swings by theory: {swing}"
            told += (f"{own}; without its own numbers the design takes {gains.law.frequency:.3f} rad/s",)
        stall = landing_stall_speed(scenario, aircraft, autopilot)
        prepared = Prepared(scenario, autopilot, vehicle, initial, limits, found, gains, aircraft.rate, told, stall)
        _ = prepared.controller  # it can be left like that, or says why not
    return prepared


def _decelerations(scenario: Scenario) -> dict[str, float]:
    """How fast the pattern lets the speed fall, before and on the glide path."""
    table = scenario.route
    if isinstance(table, LegsTable):
        return {}
    on_glide_path = table.deceleration if table.glide_deceleration is None else table.glide_deceleration
    return {"deceleration": table.deceleration, "glide_deceleration": on_glide_path}


def _data(scenario: Scenario) -> AircraftData:
    model = scenario.aircraft.model
    known = (
        AircraftData("point mass")
        if model == "point_mass"
        else complete(model, scenario.aircraft.repairs, known_flap_settings)
    )
    if model == "point_mass" and scenario.aircraft.factors:
        raise ModelError("the point mass has no factors")
    mass = scenario.aircraft.mass
    if mass is not None and not known.mass_min <= mass <= known.mass_max:
        raise ModelError(
            f"mass of {known.title} must lie within {known.mass_min:.0f} and {known.mass_max:.0f} kg, not {mass:.0f} kg"
        )
    balance = scenario.aircraft.centre_of_gravity_mac
    low, high = known.centre_of_gravity_min, known.centre_of_gravity_max
    if balance is not None and not low <= balance <= high:
        raise ModelError(f"centre_of_gravity_mac of {known.title} must lie within {low} and {high}, not {balance}")
    return known


def _configuration(scenario: Scenario, aircraft: AircraftData) -> tuple[float, Landing | None]:
    """Flaps before the glide path, and the landing where the route ends in one; margins are in equivalent airspeed."""
    mass = scenario.aircraft.mass or aircraft.reference_mass
    settings = sorted(aircraft.flap_settings, key=lambda setting: setting.flaps)
    table, air = scenario.route, scenario.air
    slowest = min(equivalent for _, _, equivalent in level_speeds(scenario))
    enough = [s.flaps for s in settings if MANOEUVRE_MARGIN * aircraft.stall_speed(s.flaps, mass) <= slowest]
    flaps = enough[0] if enough else settings[-1].flaps if settings else 0.0
    if isinstance(table, LegsTable):
        return flaps, None
    full = settings[-1].flaps if settings else 0.0
    speed = table.approach_speed
    stall = speed / REFERENCE_MARGIN  # true, over the runway
    if settings:
        reference = least_approach_speed(aircraft, full, mass)
        speed = max(speed, reference / air.equivalent_share(table.height))  # it is least where final begins
        stall = aircraft.stall_speed(full, mass) / air.equivalent_share(0.0)
    glide_path = scenario.runway.glide_path
    return flaps, Landing(
        approach_speed=speed,
        stall_speed=stall,
        flaps=full,
        glide_path=glide_path,
        localiser=vectoring.localiser(scenario) if isinstance(table, VectoredTable) else None,
        wheel_height=aircraft.height_of_wheels,
        lowest_pitch=aircraft.lowest_touchdown_pitch,
        highest_pitch=aircraft.highest_touchdown_pitch,
        gate=StabilisedGate(
            scenario.autopilot.gate_height,
            sink=max(StabilisedGate.sink, SINK_MARGIN * speed * math.tan(glide_path)),
        ),
    )


def _route(scenario: Scenario, landing: Landing | None) -> Route:
    table, runway = scenario.route, scenario.runway
    wind = scenario.wind.at(max(height for _, _, height in table.levels))  # the turns are flown there
    if isinstance(table, VectoredTable):
        assert landing is not None
        slowest = _extremes(scenario)[0]
        if slowest < landing.approach_speed:
            raise ValueError(
                f"speeds must fall along the route, but {slowest:.1f} m/s true are flown before the glide path and "
                f"{landing.approach_speed:.1f} on it; the approach has at least {REFERENCE_MARGIN} of the stall speed "
                f"and {REFERENCE_ADDITION} m/s as indicated: raise 'speed' and its schedule"
            )
        return vectoring.final(scenario, table)
    if isinstance(table, PatternTable):
        assert landing is not None
        if not table.downwind_speed >= table.turn_speed >= landing.approach_speed:
            speeds = table.downwind_speed, table.turn_speed, landing.approach_speed
            true, shown = (
                "downwind {:.1f}, turn {:.1f}, approach {:.1f} m/s".format(*(share * speed for speed in speeds))
                for share in (1.0, scenario.air.equivalent_share(table.height))
            )
            raise ValueError(
                f"speeds must fall along the pattern, but they are {true} true, which an indicator shows there as "
                f"{shown}; the approach has at least {REFERENCE_MARGIN} of the stall speed and {REFERENCE_ADDITION} "
                "m/s as indicated: raise the others, or give all three as charts do, with indicated_turn_speed_mps "
                "for turn_speed_mps"
            )
        return pattern_route(
            table.side,
            height=table.height,
            downwind_abeam=table.downwind_abeam,
            base_distance=table.base_distance,
            downwind_speed=table.downwind_speed,
            turn_speed=table.turn_speed,
            aiming_point=runway.aiming_point,
            runway_heading=runway.heading,
            wind=wind,
        )
    return Route(tuple(Leg(leg.from_, leg.to, leg.speed, leg.height) for leg in table.legs), wind)


def _gains(scenario: Scenario, route: Route, flaps: float, landing: Landing | None) -> Gains:
    """The gains: those that travel in the scenario, or a design on the linear model.

    The inputs are the very arguments of the design, the model by its content: whatever else a design comes to depend on
    becomes an argument of it, and is then noticed when it changes.
    """
    slowest, fastest = _extremes(scenario)
    limits = {"bank_limit": scenario.autopilot.bank_limit, "roll_rate_limit": scenario.autopilot.roll_rate_limit}
    arguments: dict[str, Any] = {"speed": fastest, **limits}
    design: Callable[..., Designed] = designed_point_mass
    aircraft = {"model": "point_mass"}
    if scenario.aircraft.model != "point_mass":
        design = designed
        if landing is None:
            wanted = [Configuration(flaps, 0.0, 0.96 * slowest, 1.04 * fastest)]
        else:
            final = landing.approach_speed
            wanted = [
                Configuration(flaps, 0.0, 1.03 * final, 1.02 * fastest),
                Configuration(landing.flaps, 1.0, 0.97 * final, 1.02 * slowest, -landing.glide_path),
            ]
        arguments |= {"configurations": wanted, "height": max(leg.height for leg in route.legs)}
        choice = _airframe(scenario)._replace(runway=Place(elevation=scenario.runway.elevation))  # all of it that acts
        arguments["choice"] = choice
        aircraft = plain(choice) | {"model": digest(read(choice.model))}
    lag = scenario.autopilot.estimate_lag
    inputs = plain(arguments) | {"estimate_lag": lag, "choice": aircraft}

    def made() -> Designed:
        return softened(design(**arguments), fastest, lag)

    return gains_for(scenario.designed, inputs, lambda: known_design(inputs, scenario.aircraft.model, made))


def _extremes(scenario: Scenario) -> tuple[float, float]:
    """The slowest and the fastest airspeed before a glide path, m/s."""
    speeds = [speed for _, speed, _ in scenario.route.levels]
    return min(speeds), max(speeds)


def _offset(scenario: Scenario, route: Route) -> float:
    """The largest distance, m, from which a leg is approached under the law.

    The law of a vectored approach captures where it turns in already: there is nothing from which it could orbit.
    """
    if isinstance(scenario.route, VectoredTable):
        return 0.0
    return abs(scenario.start.cross_track) if len(route.legs) == 1 else math.inf


def _loop(scenario: Scenario, gains: Designed, leg: Leg, flaps: float) -> RouteLoop:
    """The loop that the gains close on a leg."""
    if scenario.aircraft.model == "point_mass":
        return lag_loop(1.0 / gains.bank_bandwidth, leg.speed)
    return leg_loop(_airframe(scenario), gains, leg.speed, leg.height, flaps, Approach.gear)


def _case(scenario: Scenario, gains: Designed, route: Route) -> DesignCase:
    """What a law is designed for: the route law of the design, or that of the frequency which the file sets."""
    pilot, (_, speed) = scenario.autopilot, _extremes(scenario)
    bank_limit, share = pilot.bank_limit, pilot.frequency_share
    frequency = None if share is None else share * gains.bank_bandwidth
    base = gains.law if frequency is None else law_of_frequency(frequency, speed, bank_limit, gains.turning)
    if pilot.damping is None and pilot.intercept_speed is None:  # the other modes are designed as they always are
        return DesignCase(bank_limit, gains.bank_bandwidth, speed, base.k1, base.k2, base.cross_track_limit)
    k1 = scenario.law.get("k1", base.k1)
    k2 = scenario.law.get(
        "k2", base.k2 if pilot.damping is None else 2.0 * pilot.damping * math.sqrt(k1 / pull(gains.turning))
    )
    limit = base.cross_track_limit if pilot.intercept_speed is None else pilot.intercept_speed * k2 / k1
    return DesignCase(bank_limit, gains.bank_bandwidth, speed, k1, k2, limit)


def _law(scenario: Scenario, case: DesignCase) -> Mode:
    """The law of the design with what the file sets of it."""
    mode: type[Mode] = scenario.modes[scenario.mode]
    try:
        law = mode.designed(scenario.law, case)
        _ = law.explain(), law.limits()  # what reports will ask: a part that fails there is told before it flies
    except Exception as error:
        if not is_outside(mode) or isinstance(error, ValueError):
            raise
        raise ValueError(f"kind '{scenario.mode}' cannot be designed: {said(error)}") from None
    flown = LateralNavigation.of(law)
    if scenario.autopilot.frequency_share is not None and (
        {"k1", "k2"} & {*scenario.law} or flown is None or (flown.k1, flown.k2) != (case.k1, case.k2)
    ):
        raise ValueError("'frequency_share' sets k1 and k2 of the route law: leave them out, or leave it out")
    for key, field, name in (("damping", "k2", "k2"), ("intercept_speed", "cross_track_limit", "z_max")):
        if getattr(scenario.autopilot, key) is not None and (field in scenario.law or flown is None):
            raise ValueError(f"'{key}' sets {name} of the route law: leave one of them out")
    return law


def _initial(scenario: Scenario, route: Route, flaps: float, landing: Landing | None) -> Initial:
    start = scenario.start
    if start.phase is not None and not isinstance(scenario.route, PatternTable):
        raise ValueError("'phase' belongs to a pattern; say 'leg' on a route of legs")
    if start.phase is not None and start.phase not in STARTS:
        raise ValueError(f"phase must be one of {', '.join(STARTS)}, not '{start.phase}'")
    number = STARTS[start.phase] if start.phase is not None else start.leg or 0
    if not 0 <= number < len(route.legs):
        raise ValueError(f"leg must lie within 0 and {len(route.legs) - 1}, not {number}")
    leg = route.legs[number]
    distance = leg.length if start.distance is None else start.distance
    along_north, along_east = leg.direction
    north = leg.end[0] - along_north * distance - along_east * start.cross_track
    east = leg.end[1] - along_east * distance + along_north * start.cross_track
    height, angle, gear, speed, level_flaps = leg.height, 0.0, 0.0, leg.speed, flaps
    if landing is not None and number == len(route.legs) - 1:
        height, slope = landing.path(distance, leg.height, leg.speed)
        if slope < 0.0:
            angle, flaps, gear, speed = math.atan(slope), landing.flaps, 1.0, landing.approach_speed
    course = leg.course
    if isinstance(scenario.route, VectoredTable):
        vectors = vectoring.begins(scenario, scenario.route)
        if start.distance is None:
            north, east, _ = vectors
            height, angle, gear, flaps = leg.height, 0.0, 0.0, level_flaps
        course, speed = vectors[2], scenario.route.speed
    height = height if start.height is None else start.height
    speed = speed if start.speed is None else start.speed
    course = course if start.course is None else start.course
    return Initial(
        north, east, height, course, airspeed=speed, flight_path_angle=angle, flaps=flaps, gear=gear, leg=number
    )


def _airframe(scenario: Scenario, rate: float | None = None) -> AirframeChoice:
    choice, runway = scenario.aircraft, scenario.runway
    return AirframeChoice(
        choice.model,
        choice.mass,
        choice.centre_of_gravity_mac,
        choice.factors,
        Place(runway.latitude, runway.longitude, runway.elevation, runway.heading),
        scenario.air,
        rate,
        scenario.aircraft.repairs,
    )


def _vehicle(scenario: Scenario, gains: Designed) -> Any:
    if scenario.aircraft.model == "point_mass":
        return PointMassVehicle(PointMass(air=scenario.air))
    return JsbsimVehicle(gains, _airframe(scenario))


def _warnings(scenario: Scenario, autopilot: Approach, aircraft: AircraftData, gains: Designed) -> tuple[str, ...]:
    """What is beyond the limits of the aircraft or of the model, and what was changed: flown all the same."""
    north, east = scenario.wind.steady
    along, across = scenario.runway.from_local(north, east)
    told, landing = [], autopilot.landing
    if scenario.aircraft.repairs and scenario.aircraft.model != "point_mass":
        told += [f"the model is repaired: {text}" for text in _airframe(scenario).load().repairs]
    if landing is not None and landing.gate.sink > StabilisedGate.sink:
        sink, usual, allowed = (
            60.0 * speed / FOOT
            for speed in (landing.approach_speed * landing.slope, StabilisedGate.sink, landing.gate.sink)
        )
        told.append(
            f"a glide path of {math.degrees(landing.glide_path):.2f} deg at {landing.approach_speed:.1f} m/s sinks at "
            f"{sink:.0f} ft/min: its gate lets {allowed:.0f} ft/min pass, not the usual {usual:.0f}"
        )
    if scenario.wind.events and scenario.aircraft.model == "point_mass":
        told.append("the point mass keeps its airspeed in wind events: they only carry it along")
    if along > aircraft.tailwind_limit:
        told.append(
            f"tailwind {along:.1f} m/s is above the limit of {aircraft.tailwind_limit:.1f} m/s ({aircraft.title})"
        )
    if abs(across) > aircraft.crosswind_limit:
        limit = aircraft.crosswind_limit
        told.append(f"crosswind {abs(across):.1f} m/s is above the limit of {limit:.1f} m/s ({aircraft.title})")
    return (*told, *remarks(scenario, autopilot, aircraft, gains))
