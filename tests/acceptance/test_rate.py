"""The rate of the equations of motion: measured again for aircraft of every size."""

from __future__ import annotations

import pytest

from aircraft.data import data
from sim.cli import fleet
from sim.studies.convergence import FINEST, SHARE

pytestmark = pytest.mark.acceptance


@pytest.mark.parametrize("model", ["an26", "A320", "B747"])
def test_the_rate_of_an_aircraft_is_that_of_the_convergence_test(row, model):
    found = fleet.converged(model)
    told = "; ".join(
        f"{key.removeprefix('at_').replace('_hz', ' Hz')} {100.0 * far[0]:.2f} % ({far[1]}, {far[2]})"
        for key, far in found.items()
        if key != "rate_hz"
    )
    met = found["rate_hz"] == data(model).rate
    asked = f"{data(model).rate:.0f} Hz: the lowest within {100.0 * SHARE:g} % of every limit, else 120 Hz"
    row(f"{model}: largest difference from {FINEST:.0f} Hz", asked, told, met)
    assert met
