"""Where an antenna is and what it measures: slant range, azimuth from its own zero, elevation."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np

from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.observation.sensor import Look
from sim.randomness import Rows
from sim.scenario.tables import Runway
from tracking.measurement import wrap

ARC = 2.0  # deg of an outline between two corners
FAR = 20 * 1852.0  # m, how far what sees as far as it likes is drawn

S = TypeVar("S")  # a sensor's state


def location(runway: Runway, position: tuple[float, float, float]) -> tuple[float, float, float]:
    """(north, east, height) m of an antenna placed in the runway frame (past the threshold, right, up)."""
    north, east = runway.to_local(position[0], position[1])
    return north, east, position[2]


def antenna_of(sensor: Any) -> tuple[float, float, float]:
    """(north, east, height) of the antenna of a sensor, m: its ``antenna``."""
    return location(sensor.runway, sensor.position)


def zero_azimuth_of(sensor: Any) -> float:
    """Course of zero azimuth, rad clockwise from north, of a sensor that has a ``course``: its ``zero_azimuth``."""
    return float(sensor.runway.heading + sensor.course)


def no_outline(sensor: Any) -> tuple[tuple[float, float], ...]:
    """The ``outline`` of a sensor whose coverage on the ground has no limits."""
    return ()


def place(state: AircraftState) -> tuple[Any, Any, Any]:
    """(north, east, height) of a state, m."""
    return state.north, state.east, state.height


def polar(position: Any, antenna: tuple[float, float, float], zero: float) -> tuple[Any, Any, Any]:
    """(slant range m, azimuth rad, elevation rad) of (north, east, height); azimuth + right seen from the antenna."""
    north, east, up = (p - a for p, a in zip(position, antenna, strict=True))
    ground = np.hypot(north, east)
    return np.hypot(ground, up), wrap(np.arctan2(east, north) - zero), np.arctan2(up, ground)


class Sampling(NamedTuple):
    """The state of a sensor that keeps nothing but its noise from step to step."""

    epoch: float  # s, of the next look
    noise: Rows


def looks_until(state: S, period: float, until: float, look: Callable[[float], Look | None]) -> tuple[S, list[Look]]:
    """The looks at all epochs up to ``until``, and the state with the epoch after; a look that is None is not made.

    ``state`` has a field ``epoch``, the next one; the period need not be a multiple of any other step.
    """
    own: Any = state
    epoch, looks = own.epoch, []
    while epoch <= until:
        made = look(epoch)
        if made is not None:
            looks.append(made)
        epoch += period
    return own._replace(epoch=epoch), looks


def quantised(value: Any, step: float) -> Any:
    """The nearest multiple of a step; 0 = as it is."""
    return np.round(value / step) * step if step > 0.0 else value


DEAD_TIME = 0.25  # of a turn: sooner the same aircraft is not met again, but where it passes over the antenna
PIECE = 1 / 16  # of a turn, in which a beam is looked for


def beam_passes(
    sensor: Any, begun: float, free: float, before: AircraftState, after: AircraftState
) -> tuple[list[float], float]:
    """Times in (before, after], s, at which a beam points at the aircraft, and from when on the next may be.

    The beam turns clockwise once in ``sensor.period`` and pointed at the sensor's zero azimuth at ``begun``. Before
    ``free`` there is no pass. The root of wrap(2 pi (t - begun) / period - azimuth(t)) is found by secants.
    """

    def ahead(time: float) -> float:
        """By how much the beam has passed the aircraft, rad within -pi and pi."""
        azimuth = polar(place(state_at(before, after, time)), sensor.antenna, sensor.zero_azimuth)[1]
        return float(wrap(2.0 * math.pi * (time - begun) / sensor.period - azimuth))

    found: list[float] = []
    start = max(before.time, free)
    while start < after.time:
        end = min(after.time, start + PIECE * sensor.period)
        first, last = ahead(start), ahead(end)
        if first < 0.0 <= last and last - first < math.pi:
            time = max(_root(ahead, (start, first), (end, last)), math.nextafter(start, math.inf))
            found.append(time)
            end = free = time + DEAD_TIME * sensor.period
        start = end
    return found, max(free, before.time)


def _root(ahead: Callable[[float], float], left: tuple[float, float], right: tuple[float, float]) -> float:
    """Where a nearly straight function is 0, between a point below and one at or above it: four secants, bracketed."""
    for _ in range(4):
        time = left[0] + (right[0] - left[0]) * left[1] / (left[1] - right[1])
        value = ahead(time)
        left, right = ((time, value), right) if value < 0.0 else (left, (time, value))
    return min(left, right, key=lambda point: abs(point[1]))[0]


def sector(
    antenna: tuple[float, float, float], axis: float, width: float, reach: float
) -> tuple[tuple[float, float], ...]:
    """Outline of all within ``reach`` (m) and ``width / 2`` (rad) of an axis (course, rad); all round from 2 pi on."""
    north, east, _ = antenna
    all_round = width >= 2 * math.pi
    turn = axis + np.linspace(-0.5, 0.5, max(2, math.ceil(math.degrees(min(width, 2 * math.pi)) / ARC) + 1)) * width
    arc = tuple((north + reach * math.cos(a), east + reach * math.sin(a)) for a in turn.tolist())
    return arc if all_round else ((north, east), *arc)


def inside(outline: tuple[tuple[float, float], ...], north: Any, east: Any) -> np.ndarray:
    """Whether points lie within an outline, by the parity of edges to their east; () is everywhere."""
    north, east = np.asarray(north), np.asarray(east)
    within = np.full(north.shape, not outline)
    for (n0, e0), (n1, e1) in zip(outline, outline[1:] + outline[:1], strict=True):
        if n0 != n1:
            within ^= ((n0 > north) != (n1 > north)) & (east < e0 + (e1 - e0) * (north - n0) / (n1 - n0))
    return within
