"""The landing pattern as phases: legs, turns, speeds, flaps, gear, glide path, flare, go-around."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated, Any, NamedTuple

from aircraft.state import AircraftState, Command
from autopilot.landing import Landing
from autopilot.route import PathDeviation, Route, pack
from autopilot.saturation import rate_limit, saturate
from autopilot.stabilised_gate import GateState

PHASES = (
    *("intercept", "downwind", "base_turn", "base", "final_turn", "final", "glide", "flare", "ground", "go_around"),
    "rollout",  # flown by ``autopilot.rollout``
    *("vectors", "capture"),  # flown by ``autopilot.vectored``
)
INTERCEPT, DOWNWIND, BASE_TURN, BASE, FINAL_TURN, FINAL, GLIDE, FLARE, GROUND, GO_AROUND, _, VECTORS, CAPTURE = range(
    len(PHASES)
)

LEG_PHASE = (FINAL, BASE)  # of the last leg and the last but one; all before are downwind
TURN_PHASE = (FINAL_TURN, BASE_TURN)  # onto them; onto all before: intercept
TURNING = (INTERCEPT, BASE_TURN, FINAL_TURN)
POSITIVE = (
    *("roll_rate_limit", "deceleration", "glide_deceleration"),
    *("height_time", "level_acceleration", "level_change_angle"),
)
FROM_HERE = (FLARE, GO_AROUND)  # phases whose path begins where the aircraft is
TO_HEADING = slice(AircraftState._fields.index("heading") + 1)
ESTABLISHED_TRACK = math.radians(5.0)  # a turn or an intercept is over within this of the course
ESTABLISHED_CROSS_TRACK = 100.0  # m
SPEED_SETTLING = 4.0  # s, by which a new speed is ordered earlier than its ramp needs
FLARE_LAG = 1.0  # m/s, of the airspeed over its command in the flare, which then waits
BOUNCE = 0.5  # m of the wheels above the ground: it flies again, and flares again
LEAST_AIRSPEED = 5.0  # m/s, of the command after a landing; a flying boat floats until then
CLIMB_AWAY = 2.0  # regained heights: how far at least a go-around climbs
PUSH_OVER = 2.0  # m/s2, by which the climb of a go-around gives way to airspeed: a load factor of 0.8
SETTLED = 1e-3  # m and m/s: a change of height is over


class ApproachState(NamedTuple):
    """What the autopilot remembers from one step to the next."""

    phase: int  # index into PHASES
    leg: int
    bank: float  # rad, rate-limited command
    airspeed: float  # m/s, command on its way to the speed of the leg
    height: float  # m, the height that is held
    climb_rate: float  # m/s, its rate
    crab: float  # rad, heading minus course that the crosswind asks for
    aligned: float  # 0..1, share of the crab that the de-crab has taken out
    gate: GateState
    lowest: float  # m, since the go-around began
    finished: str  # "completed" behind the last leg, "go_around" once the height is regained, else ""


@dataclass(frozen=True)
class Approach:
    """Flies a route under a bank law, and lands at the end of its last leg when a landing is given.

    ``law`` gives the bank command from the deviation; its limits are its own (``autopilot/mode.py``; of a mode it needs
    ``bank_limit``, ``__call__`` and ``check_convergence``). ``begin`` and ``step`` pass the state.
    """

    route: Annotated[Route, "given"]
    law: Annotated[Any, "given"]
    landing: Annotated[Landing | None, "given"] = None
    roll_rate_limit: Annotated[float, "rad/s"] = math.radians(5.0)
    deceleration: Annotated[float, "m/s2"] = 0.5
    glide_deceleration: Annotated[float, "m/s2"] = 0.5  # to the approach speed
    flaps: Annotated[float, "rad"] = math.radians(15.0)
    gear: float = 0.0  # before the glide path
    height_time: Annotated[float, "s"] = 8.0  # in which a change of height fades out
    level_acceleration: Annotated[float, "m/s2"] = 0.5
    level_change_angle: Annotated[float, "rad"] = math.radians(2.5)
    allow_orbit: bool = False
    offset: Annotated[float, "given"] = math.inf  # m, the largest distance from which a leg is approached
    bank_lag: Annotated[float, "s"] = 0.0  # in which the bank command follows the law's, beside the roll-rate limit
    speeds: Annotated[tuple[tuple[float, float], ...], "given"] = ()  # m to go on the last leg, and the m/s from there
    _reach: tuple[float, ...] = field(
        init=False, repr=False, compare=False
    )  # m to go, where turns are first thought of
    _slow: tuple[float, ...] = field(init=False, repr=False, compare=False)  # m to go, where the next speed is ordered
    _bend: float = field(init=False, repr=False, compare=False)  # m, of the path onto the glide path
    _glide_entry: float = field(init=False, repr=False, compare=False)  # m to go on the last leg, where it begins

    def __post_init__(self) -> None:
        for name in POSITIVE:
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the autopilot must be positive, not {getattr(self, name)}")
        route, law = self.route, self.law
        route.check_turns(law.bank_limit)
        if not self.allow_orbit:
            ground_speed = min(leg.speed for leg in route.legs) - math.hypot(*route.wind)
            law.check_convergence(ground_speed, self.offset, turns=len(route.legs) > 1)
        reach, slow = [], []
        for number, (leg, following) in enumerate(pairwise(route.legs)):
            reach.append(1.3 * route.turn(number, 1.1 * max(leg.speed, following.speed), law.bank_limit).entry + 500.0)
            ramp = max(leg.speed - following.speed, 0.0) / self.deceleration
            ahead = ramp + SPEED_SETTLING if ramp > 0.0 else 0.0
            entry = route.turn(number, following.speed, law.bank_limit).entry
            slow.append(entry + ahead * route.ground_speed(number, 0.5 * (leg.speed + following.speed)))
        object.__setattr__(self, "_reach", (*reach, -math.inf))
        object.__setattr__(self, "_slow", (*slow, -math.inf))
        last, entry, bend = route.legs[-1], -math.inf, 0.0
        if self.landing is not None:
            bend = self.landing.bend(route.ground_speed(len(route.legs) - 1, last.speed))
            entry = last.height / self.landing.slope + 0.5 * bend
            self._check_glide_entry(entry)
        object.__setattr__(self, "_bend", bend)
        object.__setattr__(self, "_glide_entry", entry)

    def _check_glide_entry(self, entry: float) -> None:
        """Raise ``ValueError`` when the path would bend down before the turn onto the last leg is over."""
        route = self.route
        exit_of_turn = 0.0
        if len(route.legs) > 1:
            number = len(route.legs) - 2
            exit_of_turn = route.turn(number, route.legs[-1].speed, self.law.bank_limit).exit
        straight = route.legs[-1].length - exit_of_turn
        if entry > straight:
            raise ValueError(
                f"the glide path begins {entry:.0f} m before the aiming point, but the last leg is straight only for "
                f"{straight:.0f} m: lower the pattern, steepen the glide path or lengthen the last leg"
            )

    def begin(self, state: AircraftState, leg: int = 0) -> ApproachState:
        """On a leg, with the commands where the aircraft is."""
        if not 0 <= leg < len(self.route.legs):
            raise ValueError(f"the route has the legs 0 to {len(self.route.legs) - 1}, not {leg}")
        deviation = self.deviation(leg, state)
        phase = _phase_of(leg, self.route, LEG_PHASE, DOWNWIND) if established(deviation) else INTERCEPT
        bank = math.remainder(state.bank, math.tau)
        crab, gate = deviation.heading_error, (self.landing or Landing()).gate.begin()
        return ApproachState(phase, leg, bank, state.airspeed, state.height, 0.0, crab, 0.0, gate, state.height, "")

    def deviation(self, leg: int, state: AircraftState) -> PathDeviation:
        """Deviation of an aircraft from a leg."""
        _, north, east, _, velocity_north, velocity_east, _, _, _, heading = state[TO_HEADING]
        return self.route.deviation_at(leg, north, east, velocity_north, velocity_east, heading)

    def step(self, s: ApproachState, state: AircraftState, dt: float) -> tuple[ApproachState, Command]:
        """Command for the next ``dt`` seconds from what the aircraft does now."""
        phase, leg, bank, airspeed, height, climb_rate, crab, aligned, gate, lowest, finished = s
        route, landing = self.route, self.landing
        legs = route.legs
        _, north, east, altitude, velocity_north, velocity_east, _, _, _, heading = state[TO_HEADING]
        deviation = route.deviation_at(leg, north, east, velocity_north, velocity_east, heading)
        to_go = deviation.distance_to_go
        if to_go < self._reach[leg]:
            leg, phase, deviation = self._sequenced(leg, phase, deviation, state)
            to_go = deviation.distance_to_go
        if phase in TURNING and established(deviation):
            phase = _phase_of(leg, self.route, LEG_PHASE, DOWNWIND)
        if leg == len(legs) - 1:
            if landing is not None:
                phase, gate, lowest, finished = self._landing_phase(landing, s, phase, state, deviation, dt)
            elif to_go < 0.0:
                finished = "completed"

        slope, level = 0.0, legs[leg].height
        if phase > FINAL or climb_rate != 0.0 or height != level:
            if phase != s.phase and phase in FROM_HERE:
                height, climb_rate = altitude, state.velocity_up
            over_ground, allowed = math.hypot(velocity_north, velocity_east), math.inf
            if phase == GO_AROUND and landing is not None:
                level = max(level, lowest + CLIMB_AWAY * landing.regained_height)
                allowed = landing.climb_away(state.airspeed, altitude - landing.wheel_height)
            if climb_rate + self.level_acceleration * dt > allowed:  # from here: heights that it fell behind stall it
                height, climb_rate = altitude, max(allowed, climb_rate - PUSH_OVER * dt)
            else:
                height, climb_rate = self._path(phase, level, height, climb_rate, to_go, over_ground, airspeed, dt)
            slope = math.atan2(climb_rate, over_ground)
            if phase == FLARE and landing is not None:  # where the wheels are, not where they were to be
                wheels = altitude - landing.wheel_height
                slope = math.atan2(-landing.flare_sink(wheels), over_ground)
                slope += landing.attitude(wheels, state.pitch)
        airspeed, flaps, gear = self._speed(phase, leg, to_go, airspeed, state, -climb_rate, dt)
        wanted_bank, sideslip = self.law(deviation), 0.0
        if phase > FINAL:
            wanted_bank, sideslip, crab, aligned = self._aligned(
                phase, wanted_bank, crab, aligned, state, deviation, dt
            )
        if self.bank_lag > dt:
            wanted_bank = bank + (wanted_bank - bank) * dt / self.bank_lag
        bank = rate_limit(bank, wanted_bank, self.roll_rate_limit, dt)
        return (
            pack(
                ApproachState,
                (phase, leg, bank, airspeed, height, climb_rate, crab, aligned, gate, lowest, finished),
            ),
            pack(Command, (bank, slope, height, airspeed, flaps, gear, sideslip)),
        )

    def _sequenced(
        self, leg: int, phase: int, deviation: PathDeviation, state: AircraftState
    ) -> tuple[int, int, PathDeviation]:
        """Leg, phase and deviation after the turn to the next leg, once it is due."""
        position, velocity = (state.north, state.east), (state.velocity_north, state.velocity_east)
        following = self.route.sequence(leg, position, velocity, self.law.bank_limit)
        if following == leg:
            return leg, phase, deviation
        return following, _phase_of(following, self.route, TURN_PHASE, INTERCEPT), self.deviation(following, state)

    def _landing_phase(
        self, landing: Landing, s: ApproachState, phase: int, state: AircraftState, deviation: PathDeviation, dt: float
    ) -> tuple[int, GateState, float, str]:
        """Phase on the last leg, with what the gate and the go-around remember."""
        gate = s.gate
        if phase <= FINAL:
            if deviation.distance_to_go < self._glide_entry:
                near = landing.may_descend(deviation.cross_track, deviation.distance_to_go, phase == FINAL)
                phase = GLIDE if near else GO_AROUND
            return phase, gate, state.height, s.finished
        if phase == GLIDE:
            if landing.flare_begins(state.height - landing.wheel_height, -s.climb_rate):
                phase = FLARE
            elif state.height < landing.gate.height:
                errors = state.airspeed - min(landing.approach_speed, s.airspeed), state.height - s.height
                gate = landing.gate.step(
                    gate, errors[0], -state.velocity_up, errors[1], deviation.cross_track, deviation.distance_to_go, dt
                )
                if landing.gate.missed(gate):
                    phase = GO_AROUND
            return phase, gate, state.height, s.finished
        if phase == FLARE and state.main_wheels > 0.0:
            return GROUND, gate, state.height, s.finished
        if phase == GROUND and state.height - landing.wheel_height > BOUNCE:
            return FLARE, gate, state.height, s.finished
        if phase == GO_AROUND and state.height > s.lowest + landing.regained_height:
            return phase, gate, s.lowest, "go_around"
        return phase, gate, min(s.lowest, state.height), s.finished

    def _path(
        self,
        phase: int,
        level: float,
        height: float,
        climb_rate: float,
        distance: float,
        over_ground: float,
        airspeed: float,
        dt: float,
    ) -> tuple[float, float]:
        """Height to hold, m, and its rate, m/s."""
        landing = self.landing
        if landing is None or phase <= FINAL or phase == GO_AROUND:
            angle = self.level_change_angle if landing is None or phase <= FINAL else landing.climb_angle
            return self.towards(level, height, climb_rate, airspeed * angle, dt)
        if phase == GLIDE:
            height, slope = landing.path(distance, level, self._bend)
            return height, slope * over_ground
        sink = landing.flare_sink(height - landing.wheel_height) if phase == FLARE else landing.touchdown_sink
        return height - sink * dt, -sink

    def towards(self, level: float, height: float, climb_rate: float, fastest: float, dt: float) -> tuple[float, float]:
        """Height, m, and its rate, m/s, a time ``dt`` later on the way to a level, no faster than ``fastest``."""
        wanted = saturate((level - height) / self.height_time, fastest)
        climb_rate = rate_limit(climb_rate, wanted, self.level_acceleration, dt)
        height += climb_rate * dt
        return (level, 0.0) if abs(level - height) < SETTLED and abs(climb_rate) < SETTLED else (height, climb_rate)

    def _speed(
        self, phase: int, leg: int, distance: float, airspeed: float, state: AircraftState, sink: float, dt: float
    ) -> tuple[float, float, float]:
        """Airspeed, m/s, on its ramp, flaps and gear."""
        landing, deceleration = self.landing, self.deceleration
        flaps, gear = self.flaps, self.gear
        wanted = self.route.legs[leg + 1 if distance < self._slow[leg] else leg].speed
        for begins, speed in self.speeds:
            if distance <= begins:
                wanted = speed
        if landing is None or phase <= FINAL:
            if airspeed == wanted:
                return airspeed, flaps, gear
        else:
            if phase == GO_AROUND:
                wanted = max(landing.approach_speed, wanted)
            else:
                flaps, gear, wanted = landing.flaps, 1.0, landing.approach_speed
                deceleration = self.glide_deceleration
            wheels = state.height - landing.wheel_height
            if phase == GLIDE and landing.slows_down(wheels, sink, airspeed, deceleration):
                wanted = landing.threshold_speed
            elif phase == FLARE:
                if state.airspeed > airspeed + FLARE_LAG:  # to slow down faster it would raise the nose, and float
                    return airspeed, flaps, gear
                wanted, deceleration = landing.touchdown_speed, landing.flare_deceleration
            elif phase == GROUND:
                wanted, deceleration = LEAST_AIRSPEED, landing.flare_deceleration
                airspeed = min(airspeed, state.airspeed)  # what the wheels brake is not to be flown back by pitching up
        return rate_limit(airspeed, wanted, deceleration, dt), flaps, gear

    def _aligned(
        self,
        phase: int,
        bank: float,
        crab: float,
        aligned: float,
        state: AircraftState,
        deviation: PathDeviation,
        dt: float,
    ) -> tuple[float, float, float, float]:
        """Bank and sideslip, rad, of the de-crab, with the crab and the share of it that is taken out."""
        landing = self.landing
        if landing is None or phase == GO_AROUND:
            return bank, 0.0, crab, 0.0
        share = dt / landing.align_time
        if phase == GLIDE and state.height - landing.wheel_height >= landing.align_height:
            return bank, 0.0, crab + (deviation.heading_error - crab) * share, 0.0
        aligned = min(aligned + share, 1.0)
        sideslip = aligned * saturate(crab, landing.most_sideslip)
        return bank + landing.sideslip_bank * sideslip if phase != GROUND else 0.0, sideslip, crab, aligned


def established(deviation: PathDeviation) -> bool:
    """Whether an aircraft is on its leg: a turn onto it, or an intercept, is over."""
    return bool(abs(deviation.track_error) < ESTABLISHED_TRACK and abs(deviation.cross_track) < ESTABLISHED_CROSS_TRACK)


def _phase_of(leg: int, route: Route, table: tuple[int, ...], otherwise: int) -> int:
    """Phase of a leg, or of the turn onto it, counted from the end of the route."""
    from_end = len(route.legs) - 1 - leg
    return table[from_end] if from_end < len(table) else otherwise


def with_estimated_position(
    state: AircraftState, north: float, east: float, velocity_north: float, velocity_east: float
) -> AircraftState:
    """The aircraft's own state with the position and velocity over the ground that someone else believes."""
    return state._replace(north=north, east=east, velocity_north=velocity_north, velocity_east=velocity_east)
