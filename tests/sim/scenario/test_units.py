"""Suffixes: judged by the definitions of the units."""

from __future__ import annotations

import math

import pytest

from aircraft.units import SUFFIXES, preferred, spellings


@pytest.mark.parametrize(
    ("suffix", "si"),
    [
        ("ft", 0.3048),
        ("nmi", 1852.0),
        ("kt", 1852 / 3600),
        ("fpm", 0.00508),
        ("deg", math.pi / 180),
        ("g", 9.80665),
        ("kmh", 1000 / 3600),
    ],
)
def test_factors_are_the_defined_ones(suffix, si):
    assert SUFFIXES[suffix][1] == pytest.approx(si, rel=1e-15)  # one rounding of the quotient


def test_the_preferred_spelling_comes_first():
    assert preferred("speed", "m/s")[0] == "speed_mps"
    assert next(iter(spellings("angle", "rad"))) == "angle_deg"


def test_an_unknown_unit_is_refused():
    with pytest.raises(ValueError, match="the unit 'furlong' of"):
        spellings("x", "furlong")
