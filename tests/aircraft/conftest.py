import math

import pytest

from aircraft.airframe import load
from aircraft.trim import trim


@pytest.fixture
def steady():
    """A steady state of an aircraft by name, flaps in degrees."""

    def of(model, airspeed, path_deg=0.0, flaps_deg=0.0, gear=0.0, height=400.0, **loading):
        return trim(
            load(model, **loading), airspeed, math.radians(path_deg), height, math.radians(flaps_deg), float(gear)
        )

    return of
