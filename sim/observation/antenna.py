"""Where an antenna stands and what it sees: slant range, azimuth from its own zero, elevation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.scenario.tables import Runway


def location(runway: Runway, position: tuple[float, float, float]) -> tuple[float, float, float]:
    """(north, east, height) m of an antenna placed in the runway frame (past the threshold, right, up)."""
    north, east = runway.to_local(position[0], position[1])
    return north, east, position[2]


def wrapped(angle: Any) -> Any:
    """Angle in -pi..pi."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


def polar(position: Any, antenna: tuple[float, float, float], zero: float) -> tuple[Any, Any, Any]:
    """(slant range m, azimuth rad, elevation rad) of (north, east, height); azimuth + right seen from the antenna."""
    north, east, up = (p - a for p, a in zip(position, antenna, strict=True))
    ground = np.hypot(north, east)
    return np.hypot(ground, up), wrapped(np.arctan2(east, north) - zero), np.arctan2(up, ground)


def epochs(first: float, period: float, until: float) -> list[float]:
    """Instants ``first + i period`` up to ``until``; the period need not fit any other step."""
    count = int((until - first) / period) + 1 if until >= first else 0
    return [first + i * period for i in range(count)]


def at_least_a_step(period: float, name: str = "period") -> None:
    """Refuse sensors that are faster than the equations of motion."""
    if not period >= 1 / 120:
        raise ValueError(f"{name} must be at least 1/120 s: the flight is not known in finer steps")


def positive(instance: Any, *names: str) -> None:
    """Refuse parameters that are not above zero; None is a parameter that is not used."""
    for name in names:
        value = getattr(instance, name)
        if value is not None and not value > 0:
            raise ValueError(f"{name} must be above 0")


def share(instance: Any, *names: str) -> None:
    """Refuse parameters that are not probabilities."""
    for name in names:
        if not 0 <= getattr(instance, name) <= 1:
            raise ValueError(f"{name} must lie within 0 and 1")
