"""The still air over a runway: temperature, pressure, density by height, and what airspeeds and altimeters make of it.

The air of a field is the standard atmosphere [ICAO Doc 7488] shifted to the temperature and the QNH that were measured
there. The shift of the temperature is the same at every height; the pressure follows from the weight of that air.

Wings, flaps, gear and pilots know the dynamic pressure only, so their limits are equivalent airspeeds: the true
airspeed times the root of the density over that of the standard sea level. An indicator shows the calibrated airspeed,
which lies above the equivalent one by M^2/8 (1 - p/p0), the compressibility of the air: less than half a per cent below
Mach 0.3 up to 5 km.
Here indicated = calibrated = equivalent; `compressibility` says how wrong that is at a place and a speed.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from aircraft.ranges import Range
from aircraft.state import STANDARD_GRAVITY

Real = Any  # float or array

GAS_CONSTANT = 287.05287  # J/(kg K), of dry air
EARTH_RADIUS = 6356766.0  # m, of geopotential heights in the standard atmosphere
FREEZING = 273.15  # K
STANDARD_TEMPERATURE, STANDARD_PRESSURE = 288.15, 101325.0  # K, Pa, at sea level
STANDARD_DENSITY = STANDARD_PRESSURE / (GAS_CONSTANT * STANDARD_TEMPERATURE)  # kg/m3
HEAT_RATIO = 1.4  # of the specific heats
LAYERS = ((0.0, -0.0065), (11000.0, 0.0), (20000.0, 0.001))  # geopotential m of their base, K/m; up to 32 km
TROPOPAUSE = LAYERS[1][0]
# -89.2 and 56.7 C are the records near the ground [WMO]
TEMPERATURE = Range(least=-90.0, most=60.0, why="nothing colder or hotter was ever measured near the ground")  # degC
# 870 and 1085 hPa are the records at sea level [WMO]
QNH = Range(least=85000.0, most=109000.0, why="nothing lower or higher was ever measured at sea level")  # Pa


@dataclass(frozen=True)
class Air:
    """Air over a runway; heights are true heights above its threshold, m, floats or arrays.

    Without a temperature and with the standard QNH it is the standard atmosphere.
    """

    elevation: Annotated[float, "m"] = 0.0
    temperature: float | None = None  # K, at the threshold; None = standard at that elevation
    # with it an altimeter at the threshold shows the (geopotential) elevation
    qnh: Annotated[float, "Pa"] = STANDARD_PRESSURE

    def __post_init__(self) -> None:
        temperature = None if self.temperature is None else TEMPERATURE.fault(self.temperature - FREEZING)
        if temperature is not None:
            raise ValueError(f"the temperature, in C, {temperature}")
        if (qnh := QNH.fault(self.qnh)) is not None:
            raise ValueError(f"the QNH, in Pa, {qnh}")

    @property
    def is_standard(self) -> bool:
        """Whether this is the standard atmosphere."""
        return self.temperature_shift == 0.0 and self.qnh == STANDARD_PRESSURE

    @functools.cached_property
    def temperature_shift(self) -> float:
        """Temperature in excess of the standard one at every height, K."""
        standard: float = _column(_geopotential(self.elevation), 0.0)[0]
        return 0.0 if self.temperature is None else self.temperature - standard

    @functools.cached_property
    def sea_level_pressure(self) -> float:
        """Pressure, Pa, at sea level under this air (not the QNH, which takes standard air down to there)."""
        _, share = _column(_geopotential(self.elevation), self.temperature_shift)
        return self._field_pressure / float(share)

    @property
    def _field_pressure(self) -> float:
        """Pressure, Pa, at which an altimeter set to the QNH shows the elevation."""
        altitude = _geopotential(self.elevation) + float(_pressure_altitude(self.qnh))
        return STANDARD_PRESSURE * float(_column(altitude, 0.0)[1])

    def temperature_at(self, height: Real) -> Real:
        """K."""
        return _column(_geopotential(self.elevation + height), self.temperature_shift)[0]

    def pressure(self, height: Real) -> Real:
        """Pa."""
        return self.sea_level_pressure * _column(_geopotential(self.elevation + height), self.temperature_shift)[1]

    def density(self, height: Real) -> Real:
        """kg/m3."""
        temperature, share = _column(_geopotential(self.elevation + height), self.temperature_shift)
        return self.sea_level_pressure * share / (GAS_CONSTANT * temperature)

    def equivalent_share(self, height: Real) -> Real:
        """Equivalent over true airspeed: the root of the density over that of the standard sea level."""
        return (self.density(height) / STANDARD_DENSITY) ** 0.5

    def pressure_altitude(self, height: Real) -> Real:
        """What an altimeter set to 1013.25 hPa shows, m, and a transponder reports in Mode C [ICAO Annex 10 IV]."""
        return _pressure_altitude(self.pressure(height))

    def altimeter(self, height: Real) -> Real:
        """What an altimeter set to the QNH shows, m above sea level: in cold air more than the true height."""
        return self.pressure_altitude(height) - _pressure_altitude(self.qnh)

    def compressibility(self, airspeed: Real, height: Real) -> Real:
        """Calibrated over equivalent airspeed, less 1, at a true airspeed, m/s: what is neglected here.

        Exact, by the impact pressure of a subsonic flow, which the indicator takes for that of standard sea level.
        """
        pressure, temperature = self.pressure(height), self.temperature_at(height)
        mach = airspeed / np.sqrt(HEAT_RATIO * GAS_CONSTANT * temperature)
        impact = pressure * ((1.0 + 0.2 * mach * mach) ** 3.5 - 1.0)
        sound = math.sqrt(HEAT_RATIO * GAS_CONSTANT * STANDARD_TEMPERATURE)
        calibrated = sound * np.sqrt(5.0 * ((impact / STANDARD_PRESSURE + 1.0) ** (2.0 / 7.0) - 1.0))
        return calibrated / (airspeed * self.equivalent_share(height)) - 1.0


def _geopotential(altitude: Real) -> Real:
    """Height, m, that gives the same energy under constant gravity."""
    return EARTH_RADIUS * altitude / (EARTH_RADIUS + altitude)


def _column(altitude: Real, shift: float) -> tuple[Real, Real]:
    """Temperature, K, and pressure over that of sea level at a geopotential altitude, m: dp/p = -g dh/(R T)."""
    pick, clip = (math, _clip) if isinstance(altitude, float) else (np, np.clip)
    temperature, exponent = STANDARD_TEMPERATURE + shift, 0.0
    for number, (base, lapse) in enumerate(LAYERS):
        low = -math.inf if number == 0 else base
        high = LAYERS[number + 1][0] if number + 1 < len(LAYERS) else math.inf
        thickness = clip(altitude, low, high) - base
        if lapse == 0.0:
            exponent = exponent - STANDARD_GRAVITY * thickness / (GAS_CONSTANT * temperature)
        else:
            grown = pick.log1p(lapse * thickness / temperature)
            exponent = exponent - STANDARD_GRAVITY / (GAS_CONSTANT * lapse) * grown
        temperature = temperature + lapse * thickness
    return temperature, pick.exp(exponent)


def _clip(value: float, low: float, high: float) -> float:
    return low if value < low else high if value > high else value


def _pressure_altitude(pressure: Real) -> Real:
    """Geopotential altitude, m, of a pressure, Pa, in the standard atmosphere; up to 20 km."""
    lapse = LAYERS[0][1]
    power = -GAS_CONSTANT * lapse / STANDARD_GRAVITY
    below = STANDARD_TEMPERATURE / lapse * ((pressure / STANDARD_PRESSURE) ** power - 1.0)
    temperature, share = _column(TROPOPAUSE, 0.0)
    scale = GAS_CONSTANT * temperature / STANDARD_GRAVITY
    above = TROPOPAUSE - scale * np.log(pressure / (STANDARD_PRESSURE * share))
    return np.where(below <= TROPOPAUSE, below, above)[()]
