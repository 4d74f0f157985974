"""The state of an aircraft that moves as prescribed, and its record as a Flight."""

from __future__ import annotations

from typing import Any

import numpy as np

from aircraft.state import STANDARD_GRAVITY, AircraftState, Command
from autopilot.route import Route
from sim.flight.record import Event, Flight

Array = Any


def state_of_motion(
    time: Array, position: Array, velocity: Array, acceleration: Array, bank: Array | None = None
) -> AircraftState:
    """Load factors, attitude and rates of an aircraft without angle of attack or sideslip on a given path in calm air.

    Fields have the shape (k, *B), only the time is the same for all runs, (k,). Load factors, attitude, pitch and
    heading rates are exactly those of the path; the roll rate is that of the record.

    Parameters
    ----------
    time : (k,) s
    position, velocity, acceleration : (3, k, *B) north, east, up, in m, m/s, m/s2
    bank : (k, *B) rad; None = coordinated, no force to the side
    """
    shape = np.broadcast_shapes(np.shape(position[0]), np.shape(velocity[0]), np.shape(acceleration[0]))
    place_north, place_east, height = (np.broadcast_to(component, shape) for component in position)
    north, east, up = (np.broadcast_to(component, shape) for component in velocity)
    a_north, a_east, a_up = (np.broadcast_to(component, shape) for component in acceleration)
    level = np.hypot(north, east)
    heading, pitch = np.arctan2(east, north), np.arctan2(up, level)
    along = (north * a_north + east * a_east) / level  # horizontal acceleration forward and to the right
    across = (north * a_east - east * a_north) / level
    heading_rate = across / level
    pitch_rate = (a_up * level - up * along) / (level**2 + up**2)
    cos_pitch, sin_pitch = np.cos(pitch), np.sin(pitch)
    lift = (a_up + STANDARD_GRAVITY) * cos_pitch - along * sin_pitch  # specific force normal to the path, upwards
    if bank is None:
        bank = np.arctan2(across, lift)
    cos_bank, sin_bank = np.cos(bank), np.sin(bank)
    roll = np.gradient(np.unwrap(bank, axis=0), time, axis=0) if len(time) > 1 else np.zeros(shape)
    nothing = np.broadcast_to(0.0, shape)
    return AircraftState(
        np.asarray(time),
        place_north,
        place_east,
        height,
        north,
        east,
        up,
        np.broadcast_to(bank, shape),
        pitch,
        heading % (2.0 * np.pi),
        roll - heading_rate * sin_pitch,
        pitch_rate * cos_bank + heading_rate * cos_pitch * sin_bank,
        heading_rate * cos_pitch * cos_bank - pitch_rate * sin_bank,
        np.hypot(level, up),
        np.hypot(level, up),  # a formula flies in the air of sea level
        nothing,
        nothing,
        along * cos_pitch + (a_up + STANDARD_GRAVITY) * sin_pitch,
        across * cos_bank - lift * sin_bank,
        -lift * cos_bank - across * sin_bank,
        *(nothing,) * 9,
    )


def prescribed_flight(
    state: AircraftState, route: Route, leg: Array, phase: Array, phases: tuple[str, ...], reason: str
) -> Flight:
    """Record of a prescribed motion; the commands are the motion itself."""
    nothing = np.broadcast_to(0.0, np.shape(state.north))
    command = Command(state.bank, state.pitch, state.height, state.airspeed, nothing, nothing, nothing)
    return recorded(state, command, route, leg, phase, phases, reason)


def recorded(
    state: AircraftState,
    command: Command,
    route: Route,
    leg: Array,
    phase: Array,
    phases: tuple[str, ...],
    reason: str,
    outcome: str = "completed",
) -> Flight:
    """A Flight that was flown to its end; a batch of runs has the events of its first run."""
    shape = np.shape(state.north)
    leg, phase = np.broadcast_to(leg, shape), np.broadcast_to(phase, shape)
    time, order = np.asarray(state.time), phase[(slice(None), *(0,) * (len(shape) - 1))]
    changes = [0, *(np.flatnonzero(np.diff(order)) + 1)]
    events = [Event(float(time[i]), phases[order[i]]) for i in changes]
    events.append(Event(float(time[-1]), outcome, reason))
    return Flight(route, state, command, leg, phase, phases, tuple(events), outcome, reason)
