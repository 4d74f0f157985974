"""What the least significant bits of ASTERIX are multiples of, in SI, and fields that several categories have."""

from __future__ import annotations

import math

from aircraft.units import SUFFIXES
from sim.interchange.asterix.items import Explicit, Field, fixed

DEGREE = math.radians(1.0)
FOOT, NAUTICAL_MILE, FEET_PER_MINUTE = (SUFFIXES[unit][1] for unit in ("ft", "nmi", "fpm"))
TURN = 2.0 * math.pi / 65536.0  # rad, of an angle in 16 bits
TICK = 1.0 / 128.0  # s, of a time of day
FLIGHT_LEVEL = 25.0 * FOOT  # a quarter of a hundred feet
SPEED = NAUTICAL_MILE / 16384.0  # m/s, of a speed over the ground

SOURCE = fixed(Field("sac", 8), Field("sic", 8))
TIME = fixed(Field("time", 24, TICK))
ADDRESS = fixed(Field("address", 24))
IDENTIFICATION = fixed(Field("letters", 48))  # eight letters of six bits
EXPLICIT = Explicit()
