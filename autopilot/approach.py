"""The landing pattern as phases: legs, turns, speeds, flaps, gear, glide path, flare, go-around."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from aircraft.state import STANDARD_GRAVITY, AircraftState, Command
from autopilot.route import PathDeviation, Route
from autopilot.stabilised_gate import FRESH, GateState, StabilisedGate

PHASES = ("intercept", "downwind", "base_turn", "base", "final_turn", "final", "glide", "flare", "ground", "go_around")
INTERCEPT, DOWNWIND, BASE_TURN, BASE, FINAL_TURN, FINAL, GLIDE, FLARE, GROUND, GO_AROUND = range(len(PHASES))

LEG_PHASE = (FINAL, BASE)  # of the last leg and the last but one; all before are downwind
TURN_PHASE = (FINAL_TURN, BASE_TURN)  # onto them; onto all before: intercept
ESTABLISHED_TRACK = math.radians(5.0)  # a turn or an intercept is over within this of the course
ESTABLISHED_CROSS_TRACK = 100.0  # m
SPEED_SETTLING = 4.0  # s, by which a new speed is ordered earlier than its ramp needs


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
class Landing:
    """From the glide path to the ground."""

    approach_speed: Annotated[float, "m/s"] = 58.0
    flaps: Annotated[float, "rad"] = math.radians(38.0)
    glide_path: Annotated[float, "rad"] = math.radians(2.0 + 40.0 / 60.0)
    capture_load_factor: float = 0.05  # taken off while the path bends down onto the glide path
    capture_cross_track: Annotated[float, "m"] = 130.0  # half scale: no descent outside it
    flare_time: Annotated[float, "s"] = 3.2  # time constant of the exponential
    touchdown_sink: Annotated[float, "m/s"] = 0.4
    flare_deceleration: Annotated[float, "m/s2"] = 1.0
    align_height: Annotated[float, "m"] = 14.0  # of the wheels, where the de-crab begins
    align_time: Annotated[float, "s"] = 3.0
    sideslip_limit: Annotated[float, "rad"] = math.radians(8.0)
    climb_angle: Annotated[float, "rad"] = math.radians(3.0)  # of the go-around
    regained_height: Annotated[float, "m"] = 100.0  # after which the go-around is over
    wheel_height: Annotated[float, "given"] = 0.0  # m, height of the aircraft's position with the wheels on the ground
    sideslip_bank: Annotated[float, "given"] = 0.0  # bank per sideslip that keeps the track straight
    gate: Annotated[StabilisedGate, "given"] = field(default_factory=StabilisedGate)

    def __post_init__(self) -> None:
        for name in ("approach_speed", "glide_path", "capture_load_factor", "capture_cross_track", "flare_time"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the landing must be positive, not {getattr(self, name)}")
        for name in ("touchdown_sink", "align_time", "climb_angle"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the landing must be positive, not {getattr(self, name)}")
        if self.glide_path > math.radians(10.0):
            raise ValueError(f"a glide path of {math.degrees(self.glide_path):.1f} deg is too steep: at most 10 deg")

    def path(self, distance: float, level: float, bend: float) -> tuple[float, float]:
        """Height (m) and slope of the path ``distance`` (m) before the aiming point, from level flight at ``level``.

        A parabola of constant vertical acceleration joins the level leg and the glide path, so neither the height nor
        its rate jumps and the pitch-over begins before the glide path is reached.
        """
        slope = math.tan(self.glide_path)
        into = level / slope + 0.5 * bend - distance  # m flown since the bend began
        if into <= 0.0:
            return level, 0.0
        if into >= bend:
            return distance * slope, -slope
        return level - slope * into * into / (2.0 * bend), -slope * into / bend

    def bend(self, ground_speed: float) -> float:
        """Length of the parabola, m, that takes ``capture_load_factor`` off."""
        return ground_speed * ground_speed * math.tan(self.glide_path) / (self.capture_load_factor * STANDARD_GRAVITY)


@dataclass(frozen=True)
class Approach:
    """Flies a route under a bank law, and lands at the end of its last leg when a landing is given.

    ``law`` gives the bank command from the deviation; its limits are its own. ``begin`` and ``step`` pass the state.
    """

    route: Annotated[Route, "given"]
    law: Annotated[Any, "given"]
    landing: Annotated[Landing | None, "given"] = None
    roll_rate_limit: Annotated[float, "rad/s"] = math.radians(5.0)
    deceleration: Annotated[float, "m/s2"] = 0.5
    flaps: Annotated[float, "rad"] = math.radians(15.0)
    gear: float = 0.0  # before the glide path
    height_time: Annotated[float, "s"] = 8.0  # in which a change of height fades out
    level_acceleration: Annotated[float, "m/s2"] = 0.5
    level_change_angle: Annotated[float, "rad"] = math.radians(2.5)
    allow_orbit: bool = False
    _reach: tuple[float, ...] = field(
        init=False, repr=False, compare=False
    )  # m to go, where turns are first thought of
    _slow: tuple[float, ...] = field(init=False, repr=False, compare=False)  # m to go, where the next speed is ordered
    _bend: float = field(init=False, repr=False, compare=False)  # m, of the path onto the glide path
    _glide_entry: float = field(init=False, repr=False, compare=False)  # m to go, where it begins

    def __post_init__(self) -> None:
        for name in ("roll_rate_limit", "deceleration", "height_time", "level_acceleration", "level_change_angle"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the autopilot must be positive, not {getattr(self, name)}")
        route, law = self.route, self.law
        route.check_turns(law.bank_limit)
        if hasattr(law, "check_convergence") and not self.allow_orbit:
            ground_speed = min(leg.speed for leg in route.legs) - math.hypot(*route.wind)
            law.check_convergence(ground_speed, turns=len(route.legs) > 1)
        reach, slow = [], []
        for number, (leg, following) in enumerate(zip(route.legs, route.legs[1:], strict=False)):
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
            entry = last.height / math.tan(self.landing.glide_path) + 0.5 * bend
        object.__setattr__(self, "_bend", bend)
        object.__setattr__(self, "_glide_entry", entry)

    def begin(self, state: AircraftState, leg: int = 0) -> ApproachState:
        """On a leg, with the commands where the aircraft is."""
        if not 0 <= leg < len(self.route.legs):
            raise ValueError(f"the route has the legs 0 to {len(self.route.legs) - 1}, not {leg}")
        deviation = self.deviation(leg, state)
        phase = self._leg_phase(leg) if _established(deviation) else INTERCEPT
        bank = math.remainder(float(state.bank), math.tau)
        return ApproachState(
            phase, leg, bank, state.airspeed, state.height, 0.0, deviation.heading_error, 0.0, FRESH, state.height, ""
        )

    def deviation(self, leg: int, state: AircraftState) -> PathDeviation:
        """Deviation of an aircraft from a leg."""
        return self.route.deviation(
            leg, (state.north, state.east), (state.velocity_north, state.velocity_east), state.heading
        )

    def step(self, s: ApproachState, state: AircraftState, dt: float) -> tuple[ApproachState, Command]:
        """Command for the next ``dt`` seconds from what the aircraft does now."""
        phase, leg, bank, airspeed, height, climb_rate, crab, aligned, gate, lowest, finished = s
        route, law, landing = self.route, self.law, self.landing
        velocity_north, velocity_east = state.velocity_north, state.velocity_east
        position, velocity = (state.north, state.east), (velocity_north, velocity_east)
        deviation = route.deviation(leg, position, velocity, state.heading)
        to_go = deviation.distance_to_go
        if to_go < self._reach[leg]:
            following = route.sequence(leg, position, velocity, law.bank_limit)
            if following != leg:
                leg, phase = following, self._turn_phase(following)
                deviation = route.deviation(leg, position, velocity, state.heading)
                to_go = deviation.distance_to_go
        if (phase in (INTERCEPT, BASE_TURN, FINAL_TURN)) and _established(deviation):
            phase = self._leg_phase(leg)

        if landing is None and to_go < 0.0 and leg == len(route.legs) - 1:
            finished = "completed"
        leg_now = route.legs[leg]
        level = leg_now.height
        if phase <= FINAL:
            speed = route.legs[leg + 1].speed if to_go < self._slow[leg] else leg_now.speed
            flaps, gear = self.flaps, self.gear
            deceleration = self.deceleration
            if to_go < self._glide_entry and leg == len(route.legs) - 1:
                near = landing is not None and abs(deviation.cross_track) < landing.capture_cross_track
                phase = GLIDE if near and phase == FINAL else GO_AROUND
        if phase > FINAL:
            assert landing is not None
            flaps, gear, speed, deceleration = landing.flaps, 1.0, landing.approach_speed, self.deceleration
            ground_speed = math.hypot(velocity_north, velocity_east)
            if phase == GLIDE:
                height, slope = landing.path(to_go, level, self._bend)
                climb_rate = slope * ground_speed
                wheels = state.height - landing.wheel_height
                crab += (deviation.heading_error - crab) * min(dt / landing.align_time, 1.0) if aligned == 0.0 else 0.0
                if wheels < landing.align_height:
                    aligned = min(aligned + dt / landing.align_time, 1.0)
                if climb_rate < 0.0 and wheels < landing.flare_time * (-climb_rate - landing.touchdown_sink):
                    phase, height = FLARE, state.height
                elif state.height < landing.gate.height:
                    gate = landing.gate.step(
                        gate,
                        state.airspeed - landing.approach_speed,
                        -state.velocity_up,
                        state.height - height,
                        deviation.cross_track,
                        to_go,
                        dt,
                    )
                    if landing.gate.missed(gate):
                        phase, height, climb_rate = GO_AROUND, state.height, state.velocity_up
            if phase == FLARE:
                climb_rate = (landing.wheel_height - height) / landing.flare_time - landing.touchdown_sink
                height += climb_rate * dt
                aligned = min(aligned + dt / landing.align_time, 1.0)
                speed, deceleration = 0.0, landing.flare_deceleration
                if state.main_wheels > 0.0:
                    phase = GROUND
            if phase == GROUND:  # slow down, wings level, and down onto all wheels
                climb_rate = -landing.touchdown_sink
                height += climb_rate * dt
                airspeed = min(airspeed, state.airspeed)
                speed, deceleration = 0.0, landing.flare_deceleration
            elif phase == GO_AROUND:
                lowest = min(lowest, state.height)
                if state.height > lowest + landing.regained_height:
                    finished = "go_around"
                flaps, gear, aligned = self.flaps, self.gear, 0.0
                speed = max(landing.approach_speed, leg_now.speed)
        if (phase <= FINAL or phase == GO_AROUND) and (climb_rate != 0.0 or height != level):
            angle = self.level_change_angle if phase <= FINAL else landing.climb_angle  # type: ignore[union-attr]
            most = airspeed * angle
            wanted = (level - height) / self.height_time
            wanted = most if wanted > most else -most if wanted < -most else wanted
            change = self.level_acceleration * dt
            climb_rate += change if wanted - climb_rate > change else max(wanted - climb_rate, -change)
            height += climb_rate * dt
            if abs(level - height) < 1e-3 and abs(climb_rate) < 1e-3:
                height, climb_rate = level, 0.0

        change = deceleration * dt
        airspeed += change if speed - airspeed > change else max(speed - airspeed, -change)
        wanted, sideslip = law(deviation), 0.0
        if aligned > 0.0 and landing is not None:
            most = landing.sideslip_limit
            sideslip = aligned * (most if crab > most else -most if crab < -most else crab)
            wanted = wanted + landing.sideslip_bank * sideslip if phase < GROUND else 0.0
        change = self.roll_rate_limit * dt
        bank += change if wanted - bank > change else max(wanted - bank, -change)
        slope = math.atan2(climb_rate, math.hypot(velocity_north, velocity_east)) if climb_rate != 0.0 else 0.0
        return (
            ApproachState(phase, leg, bank, airspeed, height, climb_rate, crab, aligned, gate, lowest, finished),
            Command(bank, slope, height, airspeed, flaps, gear, sideslip),
        )

    def _leg_phase(self, leg: int) -> int:
        from_end = len(self.route.legs) - 1 - leg
        return LEG_PHASE[from_end] if from_end < len(LEG_PHASE) else DOWNWIND

    def _turn_phase(self, leg: int) -> int:
        from_end = len(self.route.legs) - 1 - leg
        return TURN_PHASE[from_end] if from_end < len(TURN_PHASE) else INTERCEPT


def _established(deviation: PathDeviation) -> bool:
    return abs(deviation.track_error) < ESTABLISHED_TRACK and abs(deviation.cross_track) < ESTABLISHED_CROSS_TRACK


def navigated(
    state: AircraftState, north: float, east: float, velocity_north: float, velocity_east: float
) -> AircraftState:
    """The aircraft's own state with the position and velocity over the ground that someone else believes."""
    return state._replace(north=north, east=east, velocity_north=velocity_north, velocity_east=velocity_east)
