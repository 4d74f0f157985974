"""Name suffix -> SI. Suffixed names occur only at the edges: files, command line, reports, JSBSim properties."""

from __future__ import annotations

import math

SUFFIXES: dict[str, tuple[str, float]] = {
    # suffix: (SI unit, factor to SI)
    "m": ("m", 1.0),
    "km": ("m", 1000.0),
    "ft": ("m", 0.3048),
    "nmi": ("m", 1852.0),
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "hz": ("Hz", 1.0),
    "mps": ("m/s", 1.0),
    "kmh": ("m/s", 1 / 3.6),
    "kt": ("m/s", 1852.0 / 3600.0),
    "fpm": ("m/s", 0.3048 / 60.0),
    "fps": ("m/s", 0.3048),
    "mps2": ("m/s2", 1.0),
    "g": ("m/s2", 9.80665),
    "deg": ("rad", math.pi / 180),
    "rad": ("rad", 1.0),
    "degps": ("rad/s", math.pi / 180),
    "deg_per_m": ("rad/m", math.pi / 180),
    "deg_per_mps": ("rad/(m/s)", math.pi / 180),
    "m2": ("m2", 1.0),
    "m2ps3": ("m2/s3", 1.0),
    "deg2ps3": ("rad2/s3", (math.pi / 180) ** 2),
    "deg2": ("rad2", (math.pi / 180) ** 2),
    "kg": ("kg", 1.0),
    "lb": ("kg", 0.45359237),
    "lbf": ("N", 4.4482216152605),
    "n": ("N", 1.0),
    "c": ("degC", 1.0),
    "hpa": ("Pa", 100.0),
    "db": ("dB", 1.0),
}

WORDS: dict[str, str] = {  # what editors call the unit of a key
    "m": "metres",
    "km": "kilometres",
    "ft": "feet",
    "nmi": "nautical miles",
    "s": "seconds",
    "ms": "milliseconds",
    "hz": "hertz",
    "mps": "metres per second",
    "kmh": "kilometres per hour",
    "kt": "knots",
    "fpm": "feet per minute",
    "fps": "feet per second",
    "mps2": "metres per second squared",
    "g": "multiples of standard gravity",
    "deg": "degrees",
    "rad": "radians",
    "degps": "degrees per second",
    "deg_per_m": "degrees per metre",
    "deg_per_mps": "degrees per metre per second",
    "m2ps3": "square metres per second cubed",
    "deg2ps3": "square degrees per second cubed",
    "deg2": "square degrees",
    "kg": "kilograms",
    "lb": "pounds",
    "lbf": "pounds force",
    "n": "newtons",
    "c": "degrees Celsius",
    "hpa": "hectopascals",
    "db": "decibels",
}

MAGNITUDES: dict[str, tuple[float, float]] = {
    # SI unit: least size of what is not zero, and greatest; a number beyond is a slip of the pen, and ends in overflow
    "m": (1e-6, 1e7),
    "s": (1e-6, 1e9),
    "Hz": (1e-6, 1e6),
    "m/s": (1e-6, 1e5),
    "m/s2": (1e-9, 1e5),
    "rad": (1e-9, 1e4),
    "rad/s": (1e-12, 1e4),
    "rad/m": (1e-12, 1e3),
    "rad/(m/s)": (1e-12, 1e3),
    "m2": (1e-12, 1e14),
    "m2/s3": (1e-12, 1e9),
    "rad2/s3": (1e-21, 1e3),
    "rad2": (1e-21, 1e3),
    "kg": (1e-3, 1e7),
    "N": (1e-3, 1e9),
    "degC": (1e-6, 1e3),
    "Pa": (1e-3, 1e7),
    "dB": (1e-6, 1e3),
}
PLAIN = (1e-12, 1e12)  # of a number without a unit

PREFERRED = (
    "m",
    "s",
    "mps",
    "mps2",
    "deg",
    "degps",
    "deg_per_m",
    "deg_per_mps",
    "m2ps3",
    "deg2ps3",
    "deg2",
    "kg",
    "hz",
    "db",
    "n",
    "c",
    "hpa",
)


def spellings(name: str, unit: str) -> dict[str, float]:
    """Every legal file key of a quantity with its factor to SI, the preferred spelling first.

    Raises ``ValueError`` when no suffix has this unit.
    """
    found = {suffix: factor for suffix, (si, factor) in SUFFIXES.items() if si == unit}
    if not found:
        known = ", ".join(dict.fromkeys(si for si, _ in SUFFIXES.values()))
        raise ValueError(f"the unit '{unit}' of '{name}' is not one of {known}")
    first = next(suffix for suffix in (*PREFERRED, *found) if suffix in found)
    return {f"{name}_{suffix}": found[suffix] for suffix in (first, *(s for s in found if s != first))}


def preferred(name: str, unit: str) -> tuple[str, float]:
    """File key and factor to SI that reports and resolved scenarios use."""
    return next(iter(spellings(name, unit).items()))
