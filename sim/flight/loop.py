"""fly(): vehicle and autopilot in closed loop, recorded at 30 Hz until something ends the flight, and its roll-out."""

from __future__ import annotations

import itertools
import math
from typing import Any

from aircraft.errors import FlightError
from aircraft.state import AircraftState, Command
from autopilot.approach import PHASES
from autopilot.route import Route
from sim.flight.outcomes import LANDED, ROLLOUT, STOPPED, Limits, OutcomeMonitor
from sim.flight.record import RECORD_STEP, Event, Flight, Recorder

MONITORED = 10  # records between two looks of the monitor, which looks at every one close to the ground
LOW = 15.0  # m
LARGEST_BANK = math.pi  # rad; no law means more
STANDING = 0.5  # m/s over the ground; slower is a stop
LONGEST_ROLLOUT = 180.0  # s
NOTHING_ASKED = math.nan  # in a roll-out the wheels are commanded, not a path or a speed
ROLLING = PHASES.index(ROLLOUT)
NEAR_GROUND = 60.0  # m; below, the autopilot runs at twice the rate for the flare


def fly(
    vehicle: Any,
    autopilot: Any,
    initial: Any,
    wind: Any,
    limits: Limits,
    phases: tuple[str, ...],
    navigator: Any = None,
    gate_height: float | None = None,
) -> Flight:
    """Fly one flight to its end.

    ``vehicle`` and ``autopilot`` are started here and stepped in turn: the autopilot sees the state, the vehicle flies
    the command; what has landed rolls out. With a ``navigator`` the autopilot sees the position estimated by a tracker
    instead of the true one. A flight that diverges is an outcome with its time, never an exception. ``gate_height`` (m)
    goes into the record.
    """
    body = vehicle.begin(initial, wind)
    state = vehicle.read(body)
    seen, sight = state, None
    if navigator is not None:
        sight, seen = navigator.begin(state)
    pilot = autopilot.begin(seen, initial.leg)
    monitor = OutcomeMonitor(limits, autopilot.route)
    recorder, recorded = Recorder(), state
    events: list[Event] = []
    pilot_step, vehicle_step, read, record = autopilot.step, vehicle.step, vehicle.read, recorder.add
    half, last = RECORD_STEP / 2, monitor.end - 1e-9
    phase = -1
    number = 0
    verdict = None
    while verdict is None:
        height = state.height
        near_ground = height < NEAR_GROUND
        pilot, command = pilot_step(pilot, seen, half if near_ground else RECORD_STEP)
        if seen is not state:
            command = _as_seen(command, state, seen)
        record(state, command, pilot.leg, pilot.phase)
        recorded = state
        if not abs(command.bank) < LARGEST_BANK:  # nor where it is no number
            verdict = "diverged", f"the law commands a bank of {command.bank:.4g} rad"
            break
        if pilot.phase != phase:
            phase = pilot.phase
            events.append(Event(state.time, phases[phase]))
        if number % MONITORED == 0 or height < LOW or state.time >= last or pilot.finished:
            verdict = monitor(state, pilot.leg, pilot.finished)
        try:
            if near_ground:
                body = vehicle_step(body, command, half)
                between = read(body)
                if seen is state:
                    pilot, command = pilot_step(pilot, between, half)
                else:
                    moved = _moved(between, state, seen)
                    pilot, command = pilot_step(pilot, moved, half)
                    command = _as_seen(command, between, moved)
                body = vehicle_step(body, command, half)
            else:
                body = vehicle_step(body, command, RECORD_STEP)
            before, state = state, read(body)
            seen = state
            if navigator is not None:
                sight, seen = navigator.step(sight, before, state)
        except FlightError as error:
            verdict = verdict or ("diverged", str(error))
        number += 1
    outcome, reason = verdict
    rollout = None
    if outcome == LANDED and state is not recorded:  # else the model gave up as it landed
        rollout = roll_out(vehicle, body, autopilot.route, pilot.leg, limits.runway, gate_height)
    events.append(Event(recorded.time, outcome, reason))
    return Flight(autopilot.route, *recorder.columns(), phases, tuple(events), outcome, reason, gate_height, rollout)


def roll_out(vehicle: Any, body: Any, route: Route, leg: int, runway: Any, gate_height: float | None) -> Flight | None:
    """Roll a vehicle to its stop from the first record after a landing; None for one without wheels.

    The crew sees the centreline, whatever the approach was flown on. How it ends is in ``outcome``: ``stopped``,
    ``excursion`` (off the side of the runway), ``time_limit`` or ``diverged``.
    """
    law = vehicle.rollout(body)
    if law is None:
        return None
    state = vehicle.read(body)
    s = law.begin(state)
    asked = Command(0.0, 0.0, NOTHING_ASKED, NOTHING_ASKED, state.flaps, 1.0)
    recorder, landed = Recorder(), state
    for number in itertools.count(1):
        recorder.add(state, asked, leg, ROLLING)
        past, across = runway.from_local(state.north, state.east)
        speed = math.hypot(state.velocity_north, state.velocity_east)
        if speed < STANDING:
            outcome, reason = STOPPED, f"stopped {_place(past, across)}"
            break
        if abs(across) > runway.touchdown_aside:
            outcome, reason = "excursion", f"left the runway {_place(past, across)}, at {speed:.1f} m/s"
            break
        if number * RECORD_STEP >= LONGEST_ROLLOUT:
            outcome, reason = "time_limit", f"still rolling {_place(past, across)}, at {speed:.1f} m/s"
            break
        course = math.atan2(state.velocity_east, state.velocity_north)
        track_error = math.remainder(course - runway.heading, math.tau)
        heading_error = math.remainder(state.heading - runway.heading, math.tau)
        s, controls, wheels = law.step(s, state, across, track_error, heading_error, RECORD_STEP)
        try:
            body = vehicle.roll(body, controls, wheels, RECORD_STEP)
        except FlightError as error:
            outcome, reason = "diverged", str(error)
            break
        state = vehicle.read(body)
    events = (Event(landed.time, ROLLOUT), Event(state.time, outcome, reason))
    return Flight(route, *recorder.columns(), PHASES, events, outcome, reason, gate_height)


def _place(past: float, across: float) -> str:
    """Where on the runway, in words."""
    return f"{past:.0f} m past the threshold, {abs(across):.1f} m off the centreline"


def _as_seen(command: Command, state: AircraftState, seen: AircraftState) -> Command:
    """The command with the height error that the autopilot sees: the inner loops know the true height."""
    return command._replace(height=command.height + state.height - seen.height)


def _moved(now: AircraftState, before: AircraftState, seen: AircraftState) -> AircraftState:
    """The state that the autopilot sees half a record later: the estimation error is kept constant."""
    return now._replace(
        north=now.north + seen.north - before.north,
        east=now.east + seen.east - before.east,
        height=now.height + seen.height - before.height,
        velocity_north=now.velocity_north + seen.velocity_north - before.velocity_north,
        velocity_east=now.velocity_east + seen.velocity_east - before.velocity_east,
    )
