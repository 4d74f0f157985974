"""The air of a scenario: its [wind] table as motion of the air and in words."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aircraft.air import FREEZING, STANDARD_DENSITY, Air
from aircraft.airframe import Wind
from aircraft.turbulence import Turbulence
from aircraft.wind import SteadyWind, Together
from aircraft.wind_shear import ShearedWind
from sim.scenario.model import Scenario
from sim.scenario.tables import Runway, WindTable


def air(table: WindTable, runway: Runway, noise: np.random.Generator | None = None, rate: float = 120.0) -> Wind:
    """The whole motion of the air in one flight; without ``noise``, all but the turbulence.

    ``rate`` (Hz) is that of the steps in which the aircraft asks for it.
    """
    steady = SteadyWind(*table.steady)
    mean = steady if table.profile is None else ShearedWind(steady, table.tower, table.profile)
    turbulent = noise is not None and table.intensity > 0.0
    course = runway.heading if table.strength == 0.0 else math.atan2(steady.east, steady.north)
    if isinstance(mean, SteadyWind) and not table.events:  # added up in one place, for speed
        return Turbulence(table.intensity, noise, steady, course, rate) if noise is not None and turbulent else steady
    parts: list[Any] = [mean, *table.events.values()]
    if noise is not None and turbulent:
        parts.append(Turbulence(table.intensity, noise, course=course, rate=rate))
    return Together(tuple(parts))


def still(scenario: Scenario) -> list[str]:
    """Elevation, temperature and pressure at the runway in words; nothing where they are those of sea level."""
    air = scenario.air
    if air == Air():
        return []
    share = air.density(0.0) / STANDARD_DENSITY
    return [
        f"runway at {air.elevation:.0f} m, {air.temperature_at(0.0) - FREEZING:.1f} C, QNH {air.qnh / 100.0:.0f} hPa: "
        f"{share:.3f} of the density of sea level"
    ]


def words(scenario: Scenario) -> list[str]:
    """The still air, wind, shear, turbulence and events, one phrase for each that there is."""
    table = scenario.wind
    if scenario.record is not None:  # nobody recorded its wind
        return still(scenario)
    said = [*still(scenario), "no steady wind"]
    if table.strength > 0.0:
        measured = "" if table.profile is None else f" {table.tower:.3g} m up, {table.shear} shear"
        north, east = table.steady
        course = math.degrees(math.atan2(-east, -north)) % 360
        said[-1] = f"wind from {course:03.0f} deg at {table.strength:.1f} m/s{measured}"
    if table.intensity > 0.0:
        level = "" if table.turbulence in ("none", "by_wind") else f"{table.turbulence} "
        whose = " of the mean wind" if table.turbulence == "by_wind" else ""
        said.append(f"{level}turbulence{whose}, {table.intensity:.1f} m/s at 20 ft")
    return said + [f"{name}: {kind_in_words(scenario, name)} of {one.words()}" for name, one in table.events.items()]


def kind_in_words(scenario: Scenario, name: str) -> str:
    """What kind of event a scenario's ``[wind.events.NAME]`` is."""
    return str(scenario.tables["wind"]["events"][name]["kind"]).replace("_", " ")
