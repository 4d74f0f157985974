"""How a flight ends: the first condition that is met decides, and none of them raises an exception."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from aircraft.state import (
    FUSELAGE,
    MAIN_WHEEL,
    STANDARD_GRAVITY,
    TAIL,
    WING_TIP,
    AircraftState,
    main_wheel_first,
    parts,
)
from autopilot.route import Route

LANDED = "landed"  # the outcome after which an aircraft rolls out
ROLLOUT = "rollout"  # the phase in which it does
STOPPED = "stopped"  # the outcome of a roll-out that came to its end
LONGEST_FLIGHT = 1800.0  # s
SWINGS = 2  # from one bank to the other within one leg; a turn onto a leg and its capture are one
STRUCTURE = TAIL + WING_TIP + FUSELAGE
SUNK = -1.0  # m, height of an aircraft without a wheel between it and the runway
HARDEST_LANDING = 3.05  # m/s, 10 ft/s, the limit sink of the landing gear [CS 25.473]


@dataclass(frozen=True)
class Limits:
    """What ends a flight."""

    until: float | None  # s
    runway: Any  # sim.scenario.tables.Runway, with its touchdown box
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
        self.sink = 0.0  # m/s, before the last contact
        self.parts = 0.0  # that have touched the ground so far
        self.touched: tuple[float, float, float] | None = None  # m past and right of the threshold, sink m/s, at first
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
        another, self.parts = state.touched != self.parts, state.touched
        if another or state.main_wheels > 0.0 or state.height < SUNK:
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
        """Whether that is a landing yet, or why it will be none; where it first touched counts, and its hardest bounce.

        The reason says all of it, and behind each figure the limit that it is beyond.
        """
        runway = self.limits.runway
        here = (*runway.from_local(state.north, state.east), self.sink)
        self.touched = past, across, sink = self.touched or here
        sink = max(sink, self.sink)
        sunk = not state.main_wheels and not state.touched
        first = int(state.first_contact) or MAIN_WHEEL
        then = int(state.touched) & STRUCTURE & ~first
        short, far, aside = runway.touchdown_from, runway.touchdown_to, runway.touchdown_aside
        figures = (
            (
                f"{abs(past):.0f} m {'past' if past >= 0.0 else 'before'} the threshold",
                f"beyond the box of {far:.0f} m" if past > far else f"short of the box, {short:.0f} m past it",
                not short <= past <= far,
            ),
            (
                f"{abs(across):.1f} m off the centreline",
                f"beside the box of {aside:.0f} m",
                abs(across) > aside,
            ),
            (f"sink {sink:.2f} m/s", f"harder than {HARDEST_LANDING:.2f} m/s", sink > HARDEST_LANDING),
            (
                "without a wheel under it" if sunk else f"{parts(first)} first",
                f"then the {parts(then)}",
                bool(then),
            ),
        )
        told = ", ".join(f"{figure}, {limit}" if beyond else figure for figure, limit, beyond in figures)
        if sunk or not main_wheel_first(first) or any(beyond for _, _, beyond in figures):
            return "ground", f"touched down {told}"
        return (LANDED, f"landed {told}") if state.main_wheels >= 1.0 else None

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
