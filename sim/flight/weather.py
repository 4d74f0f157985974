"""The air of a scenario: what its [wind] table comes to, in motion and in words."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aircraft.airframe import Wind
from aircraft.turbulence import Turbulence
from aircraft.wind import SteadyWind, Together
from aircraft.wind_events.microburst import Microburst
from aircraft.wind_events.wind_shift import WindShift
from aircraft.wind_shear import ShearedWind
from sim.scenario.tables import Runway, WindTable


def air(table: WindTable, runway: Runway, noise: np.random.Generator | None = None) -> Wind:
    """Everything that moves in one flight; without ``noise``, all of it but the turbulence."""
    steady = SteadyWind(*table.steady)
    mean = steady if table.profile is None else ShearedWind(steady, table.tower, table.profile)
    turbulent = noise is not None and table.intensity > 0.0
    course = runway.heading if table.speed == 0.0 else math.atan2(steady.east, steady.north)
    if isinstance(mean, SteadyWind) and not table.events:  # added up in one place, for speed
        return Turbulence(table.intensity, noise, steady, course) if noise is not None and turbulent else steady
    parts: list[Any] = [mean, *table.events.values()]
    if noise is not None and turbulent:
        parts.append(Turbulence(table.intensity, noise, course=course))
    return Together(tuple(parts))


def words(table: WindTable) -> list[str]:
    """What there is of wind, shear, turbulence and events, a phrase each."""
    said = ["no steady wind"]
    if table.speed > 0.0:
        measured = "" if table.profile is None else f" {table.tower:.3g} m up, {table.shear} shear"
        said = [f"wind from {math.degrees(table.from_) % 360:03.0f} deg at {table.speed:.1f} m/s{measured}"]
    if table.intensity > 0.0:
        level = "" if table.turbulence == "none" else f"{table.turbulence} "
        said.append(f"{level}turbulence, {table.intensity:.1f} m/s at 20 ft")
    return said + [f"{name}: {event_words(event)}" for name, event in table.events.items()]


def event_words(event: Any) -> str:
    """One event in a phrase: what, how strong, where or when."""
    if isinstance(event, Microburst):
        place = _place(event.past_threshold, event.right)
        return f"microburst of {event.peak:.1f} m/s, {event.radius:.0f} m in radius, {place}{_time(event)}"
    parts = []
    if event.up:
        parts.append(f"{abs(event.up):.1f} m/s {'up' if event.up > 0.0 else 'down'}")
    if event.speed:
        parts.append(f"{event.speed:.1f} m/s from {math.degrees(event.from_) % 360:03.0f} deg")
    strength = " and ".join(parts) or "no strength"
    if isinstance(event, WindShift):
        where = "" if event.length is None else f", over {event.length:.0f} m from {_place(event.past_threshold, 0.0)}"
        return f"wind shift of {strength}{where}{_time(event)}"
    where = "" if event.length is None else f", {event.length:.0f} m long, {_place(event.past_threshold, event.right)}"
    return f"gust of {strength}{where}{_time(event)}"


def _place(past_threshold: float, right: float) -> str:
    along = f"{abs(past_threshold):.0f} m {'past' if past_threshold > 0.0 else 'before'} the threshold"
    return along + (f", {abs(right):.0f} m {'right' if right > 0.0 else 'left'} of the centreline" if right else "")


def _time(event: Any) -> str:
    return "" if event.at is None else f", from {event.at:.0f} s for {event.lasts:.3g} s"
