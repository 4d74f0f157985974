"""roll_out(): a flight that has landed goes on to its stop, in a record of its own that begins where the first ends."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aircraft.errors import FlightError
from aircraft.state import AircraftState, Command
from autopilot.approach import PHASES
from autopilot.route import Route
from sim.flight.outcomes import TOUCHDOWN_ASIDE
from sim.flight.record import RECORD_STEP, Event, Flight

ROLLOUT = "rollout"
STOPPED = "stopped"  # outcome of a roll-out that came to its end
STANDING = 0.5  # m/s over the ground; slower is a stop
LONGEST_ROLLOUT = 180.0  # s
NOTHING_ASKED = math.nan  # the wheels are commanded, not a path or a speed


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
    states: list[AircraftState] = []
    outcome = ""
    reason = ""
    while not outcome:
        states.append(state)
        past, across = runway.from_local(state.north, state.east)
        here = f"{past:.0f} m past the threshold, {abs(across):.1f} m off the centreline"
        if math.hypot(state.velocity_north, state.velocity_east) < STANDING:
            outcome, reason = STOPPED, f"stopped {here}"
        elif abs(across) > TOUCHDOWN_ASIDE:
            outcome, reason = "excursion", f"left the runway {here}, at {state.ground_speed:.1f} m/s"
        elif len(states) * RECORD_STEP >= LONGEST_ROLLOUT:
            outcome, reason = "time_limit", f"still rolling {here}, at {state.ground_speed:.1f} m/s"
        else:
            course = math.atan2(state.velocity_east, state.velocity_north)
            track_error = math.remainder(course - runway.heading, math.tau)
            heading_error = math.remainder(state.heading - runway.heading, math.tau)
            s, controls, wheels = law.step(s, state, across, track_error, heading_error, RECORD_STEP)
            try:
                body = vehicle.roll(body, controls, wheels, RECORD_STEP)
            except FlightError as error:
                outcome, reason = "diverged", str(error)
            state = vehicle.read(body)
    asked = Command(0.0, 0.0, NOTHING_ASKED, NOTHING_ASKED, states[0].flaps, 1.0)
    count = len(states)
    return Flight(
        route,
        AircraftState(*np.array(states, float).T),
        Command(*np.tile(np.array(asked, float)[:, None], count)),
        np.full(count, leg),
        np.full(count, PHASES.index(ROLLOUT)),
        PHASES,
        (Event(states[0].time, ROLLOUT), Event(states[-1].time, outcome, reason)),
        outcome,
        reason,
        gate_height,
    )
