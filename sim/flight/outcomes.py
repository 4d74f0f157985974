"""How a flight ends: the first condition that is met decides, and none of them raises an exception."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from aircraft.state import STANDARD_GRAVITY, AircraftState
from autopilot.route import Route

LONGEST_FLIGHT = 1800.0  # s
TOUCHDOWN_BOX = (60.0, 823.0)  # m past the threshold [CS AWO.A.ALS.106, from memory]
TOUCHDOWN_ASIDE = 21.0  # m off the centreline, of the same box: no scenario knows how wide its runway is
SWINGS = 2  # from one bank to the other within one leg; a turn onto a leg and its capture are one
HARDEST_LANDING = 3.05  # m/s, 10 ft/s, the limit sink of the landing gear [CS 25.473]


@dataclass(frozen=True)
class Limits:
    """What ends a flight."""

    until: float | None  # s
    runway: Any  # sim.tables.Runway: where the touchdown box lies
    stall_angle: float = math.radians(20.0)  # rad
    bank: float = math.radians(60.0)
    load_factor: float = 3.0
    swing: str = ""  # what sustains the swings of the law, by theory
    swing_bank: float = math.inf  # rad, beyond which a bank to the other side is part of a swing


class OutcomeMonitor:
    """Watches one flight for its end; called once per record, it remembers what it needs between records."""

    def __init__(self, limits: Limits, route: Route) -> None:
        self.limits, self.route = limits, route
        self.end = LONGEST_FLIGHT if limits.until is None else min(limits.until, LONGEST_FLIGHT)
        self.lines = [(*leg.start, *leg.direction) for leg in route.legs]
        self.leg, self.turned, self.course = -1, 0.0, 0.0
        self.start_offset = 0.0
        self.outside_since: float | None = None
        self.sink = 0.0
        self.touched = ""  # where and how the first wheel touched
        self.side, self.swings, self.has_swung = 0.0, 0, False

    def __call__(self, state: AircraftState, leg: int, finished: str) -> tuple[str, str] | None:
        """(outcome, reason) once the flight is over, else None."""
        if self.limits.swing:
            self._watch_bank(state.bank, leg)
        verdict = self._verdict(state, leg, finished)
        if verdict is None or not self.has_swung:
            return verdict
        return verdict[0], f"{verdict[1]}; it swung: by theory {self.limits.swing}"

    def _watch_bank(self, bank: float, leg: int) -> None:
        """Count how often the bank goes from one side to the other within a leg."""
        if leg != self.leg:
            self.side, self.swings = 0.0, 0
        if abs(bank) > self.limits.swing_bank and bank * self.side <= 0.0:
            self.swings += self.side != 0.0
            self.side = math.copysign(1.0, bank)
            self.has_swung |= self.swings >= SWINGS

    def _verdict(self, state: AircraftState, leg: int, finished: str) -> tuple[str, str] | None:
        if not math.isfinite(state.north + state.east + state.height + state.airspeed + state.bank):
            return "diverged", "the motion of the aircraft is no number any more"
        if state.main_wheels > 0.0 or state.height < -1.0:
            verdict = self._contact(state)
            if verdict is not None:
                return verdict
        else:
            self.sink = -state.velocity_up
        course = math.atan2(state.velocity_east, state.velocity_north)
        offset = self._cross_track(state, leg)
        if leg != self.leg:
            self.leg, self.turned, self.start_offset = leg, 0.0, abs(offset)
        else:
            self.turned += math.remainder(course - self.course, 2 * math.pi)
        self.course = course
        if abs(self.turned) > 3 * math.pi:
            return "orbit", f"turned {math.degrees(abs(self.turned)):.0f} deg within leg {leg}"
        if abs(offset) > 3 * self.start_offset + 5000:
            return "diverged", f"{abs(offset):.0f} m off leg {leg}, {self.start_offset:.0f} m at its start"
        return self._envelope(state) or self._ended(state, finished)

    def _cross_track(self, state: AircraftState, leg: int) -> float:
        north, east, along_north, along_east = self.lines[leg]
        across: float = (state.east - east) * along_north - (state.north - north) * along_east
        return across

    def _contact(self, state: AircraftState) -> tuple[str, str] | None:
        past, across = self.limits.runway.from_local(state.north, state.east)
        along = f"{abs(past):.0f} m {'past' if past >= 0.0 else 'before'} the threshold"
        here = f"{along}, {abs(across):.1f} m off the centreline, sink {self.sink:.2f} m/s"
        self.touched = where = self.touched or here
        in_box = TOUCHDOWN_BOX[0] <= past <= TOUCHDOWN_BOX[1] and abs(across) <= TOUCHDOWN_ASIDE
        if not in_box or self.sink > HARDEST_LANDING or state.height < -1.0:
            return "ground", f"touched the ground {where}"
        return ("landed", f"landed {where}") if state.main_wheels >= 1.0 else None

    def _envelope(self, state: AircraftState) -> tuple[str, str] | None:
        load = math.hypot(state.specific_force_right, state.specific_force_down) / STANDARD_GRAVITY
        limits = self.limits
        outside = (
            abs(state.bank) > limits.bank or load > limits.load_factor or state.angle_of_attack > limits.stall_angle
        )
        if not outside:
            self.outside_since = None
            return None
        if self.outside_since is None:
            self.outside_since = state.time
        if state.time - self.outside_since < 1.0:
            return None
        return "envelope", (
            f"bank {math.degrees(state.bank):.0f} deg, load factor {load:.1f}, "
            f"angle of attack {math.degrees(state.angle_of_attack):.0f} deg for 1 s"
        )

    def _ended(self, state: AircraftState, finished: str) -> tuple[str, str] | None:
        if finished == "go_around":
            return finished, f"went around and regained its height, {state.height:.0f} m"
        if finished:
            return finished, f"flown to the end of leg {self.leg}"
        if state.time >= self.end - 1e-9:
            if self.limits.until is not None and self.limits.until <= LONGEST_FLIGHT:
                return "completed", f"flown until {state.time:.0f} s"
            return "time_limit", f"still flying after {state.time:.0f} s"
        return None
