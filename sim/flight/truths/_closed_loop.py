"""A point mass under a bank law, for one run or an ensemble that flies side by side."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from aircraft.point_mass import PointMass, PointMassState
from aircraft.state import AircraftState, Command
from autopilot.route import PathDeviation, Route
from sim.flight.record import Flight
from sim.flight.truths._motion import recorded

Array = Any


class Air(NamedTuple):
    """What the air does at one instant."""

    wind: tuple[Array, Array, float]  # m/s, (north, east, up)
    acceleration: tuple[Array, Array]  # m/s2, (north, east), of the air and so of the aircraft


class Plan(NamedTuple):
    """What is flown next, besides the bank."""

    speed: Array  # m/s, airspeed
    height: Array  # m
    slope: Array  # rad, of the path
    phase: Array  # index
    finished: Array  # whether this run is over


class Closed(NamedTuple):
    """The closed loop: the body, the route and the law."""

    mass: PointMass
    route: Route
    law: Callable[[PathDeviation], Array]
    bank_limit: float  # rad, for which the turns are anticipated
    plan: Callable[[AircraftState, Array, PathDeviation, Array], Plan]  # state, leg, deviation, phase so far
    phases: tuple[str, ...]
    longest: float  # s


def choose(condition: Any, this: Any, that: Any) -> Any:
    """``this`` where the condition holds, else ``that``; floats stay floats, ten times faster than an array of one."""
    if isinstance(condition, bool):
        return this if condition else that
    return np.where(condition, this, that)


STILL = Air((0.0, 0.0, 0.0), (0.0, 0.0))


def wandering_air(
    generator: np.random.Generator,
    sigma: float,
    period: float,
    step: float,
    longest: float,
    shape: tuple[int, ...],
    steady: tuple[float, float] = (0.0, 0.0),
) -> Callable[[int], Air]:
    """Air whose horizontal acceleration is drawn afresh every ``period``; its velocity is ``steady`` at the start.

    It carries the aircraft along: its acceleration shows in the load factors, not in the airspeed.
    """
    periods = math.ceil(longest / period) + 2
    drawn = sigma * generator.standard_normal((periods, 2, *shape))
    reached = period * np.concatenate([np.zeros((1, 2, *shape)), np.cumsum(drawn, axis=0)])

    def at(row: int) -> Air:
        index = int(row * step / period + 1e-9)
        since = row * step - index * period
        north, east = reached[index] + since * drawn[index]
        pushed_north, pushed_east = drawn[index]
        if not shape:
            north, east, pushed_north, pushed_east = map(float, (north, east, pushed_north, pushed_east))
        return Air((steady[0] + north, steady[1] + east, 0.0), (pushed_north, pushed_east))

    return at


def fly_closed(
    loop: Closed, body: PointMassState, leg: Any, step: float, air: Callable[[int], Air] | None = None, reason: str = ""
) -> Flight:
    """Fly until every run has finished; runs that finish earlier keep flying under their law and plan.

    A loop that takes longer than it may ends with the outcome ``time_limit``.

    Parameters
    ----------
    body : state at the start, floats or arrays (*B)
    leg : index at the start, int or (*B)
    air : of the number of the record, after the start; None = calm, or the steady wind of ``body``
    """
    route, mass = loop.route, loop.mass
    batched = isinstance(body.north, np.ndarray)
    phase: Any = np.zeros(body.north.shape, int) if batched else 0
    leg = np.broadcast_to(leg, body.north.shape) if batched else leg
    states: list[Any] = []
    commands, legs, phases, pushes = [], [], [], []
    felt = STILL if air is None else air(0)
    while True:
        state = mass.read(body)
        position, velocity = (state.north, state.east), (state.velocity_north, state.velocity_east)
        leg = route.sequence(leg, position, velocity, loop.bank_limit)
        deviation = route.deviation(leg, position, velocity, state.heading)
        plan = loop.plan(state, leg, deviation, phase)
        phase = plan.phase
        command = Command(loop.law(deviation), plan.slope, plan.height, plan.speed, 0.0, 0.0)
        states.append(state)
        pushes.append(felt.acceleration)
        commands.append(command)
        legs.append(leg)
        phases.append(phase)
        finished = bool(np.all(plan.finished))
        if finished or len(states) * step > loop.longest:
            break
        if air is None:
            body = mass.step(body, command, step)
        else:
            felt = air(len(states))
            body = mass.step(body, command, step, felt.wind)
    shape = np.shape(body.north)
    state = AircraftState(*_stacked(states, shape))._replace(time=step * np.arange(len(states)))
    return recorded(
        state if air is None else _pushed(state, _stacked(pushes, shape)),
        Command(*_stacked(commands, shape)),
        route,
        np.array(legs),
        np.array(phases),
        loop.phases,
        reason if finished else f"not finished after {loop.longest:.0f} s",
        "completed" if finished else "time_limit",
    )


def _pushed(state: AircraftState, acceleration: list[Array]) -> AircraftState:
    """The state of an aircraft in accelerated air: the acceleration of the air is added to its specific force."""
    forward, right, down = state.wind_axes  # those of the body: no angle of attack, no sideslip
    north, east = acceleration
    return state._replace(
        specific_force_forward=state.specific_force_forward + north * forward[0] + east * forward[1],
        specific_force_right=state.specific_force_right + north * right[0] + east * right[1],
        specific_force_down=state.specific_force_down + north * down[0] + east * down[1],
    )


def _stacked(rows: list[Any], shape: tuple[int, ...]) -> list[Array]:
    """Every field stacked over time; a value that all runs share is stored once."""
    fields = []
    for column in zip(*rows, strict=True):
        array = np.array(column, float)
        if array.ndim == 1:
            array = np.broadcast_to(array.reshape(-1, *(1,) * len(shape)), (len(rows), *shape))
        fields.append(array if array.any() else np.broadcast_to(0.0, array.shape))
    return fields
