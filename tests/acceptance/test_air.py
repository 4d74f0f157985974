"""Hot and high: three aircraft at four elevations in standard air and 25 K warmer, with the speeds of a chart."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
import pytest

from aircraft.air import FREEZING, STANDARD_DENSITY, Air
from sim.errors import ScenarioError
from sim.experiment import fly
from sim.flight.preparation import prepare
from sim.metrics.flight import flight_metrics
from sim.scenario.reading import read

pytestmark = pytest.mark.acceptance
AIRCRAFT = ("an26_pattern", "c172x", "a320")
ELEVATIONS = (0.0, 1500.0, 2500.0, 4061.0)
WARMER = (0.0, 25.0)  # K than the standard
SPEEDS = ("downwind_speed", "turn_speed", "approach_speed")
WITHIN = 0.02  # of the true speed and the radius: the air between runway and pattern, and the lag of the turn
FASTER = 1.02  # what a true speed is beside the same indicated one at 400 m


class Flown(NamedTuple):
    """What one flight shows."""

    outcome: str
    final_over_stall: float
    equivalent: float  # m/s, on the glide path about 240 m up
    true: float
    radius: float  # m, at the full bank of the turn to final
    density: float  # kg/m3, at the runway


def tables(name: str, elevation: float, warmer: float, **aircraft: float) -> tuple[dict[str, object], float]:
    """Overrides that move a bundled pattern: its speeds as indicated ones, its lengths with the radius of its turns."""
    celsius = float(Air(elevation).temperature_at(0.0)) + warmer - FREEZING
    density = float(Air(elevation, celsius + FREEZING).density(0.0))
    bundled, wider = read(name).route, FASTER**2 * STANDARD_DENSITY / density
    return {
        "runway.elevation_m": elevation,
        "air.temperature_c": celsius,
        **{f"route.indicated_{key}_mps": getattr(bundled, key) for key in SPEEDS},
        "route.downwind_abeam_m": wider * bundled.downwind_abeam,
        "route.base_distance_m": wider * bundled.base_distance,
        **{f"aircraft.{key}": value for key, value in aircraft.items()},
    }, density


def flown(name: str, elevation: float, warmer: float, **aircraft: float) -> Flown:
    """Fly it; raises ``ScenarioError`` where the aircraft cannot."""
    overrides, density = tables(name, elevation, warmer, **aircraft)
    prepared = prepare(read(name, overrides))
    flight = fly(prepared, 0)
    figures = flight_metrics(flight, prepared.scenario.runway, prepared.law.bank_limit, prepared.stall_speed)
    state = flight.state
    turning = flight.during("final_turn") & (np.abs(np.abs(np.degrees(state.bank)) - 15.0) < 0.1)
    rate = np.abs(np.gradient(np.unwrap(state.course), state.time))[turning]
    low = flight.during("glide") & (state.height > 210.0) & (state.height < 270.0)  # below, it slows down to land
    return Flown(
        flight.outcome,
        figures["final_over_stall"],
        float(state.equivalent_airspeed[low].mean()),
        float(state.airspeed[low].mean()),
        float(np.mean(state.ground_speed[turning] / rate)),
        density,
    )


@pytest.mark.parametrize("name", AIRCRAFT)
def test_hot_and_high(row, name):
    sea_level, landed = flown(name, 0.0, 0.0), []
    for warmer in WARMER:
        for elevation in ELEVATIONS:
            place = f"{name} at {elevation:.0f} m, standard{f' + {warmer:.0f} K' if warmer else ''}"
            try:
                one = flown(name, elevation, warmer)
            except ScenarioError as error:
                lacking = re.search(r"needs more than full power: [0-9]+ kW lack", str(error))
                row(f"{place}: refused", "names the power that lacks", str(error).rpartition(": ")[2], bool(lacking))
                assert lacking
                continue
            landed += [(elevation, warmer)] if one.outcome == "landed" else []
            margin = one.final_over_stall
            row(f"{place}: final over the stall speed", ">= 1.3", f"{margin:.3f}, {one.outcome}", margin >= 1.3)
            assert margin >= 1.3
            apart = one.equivalent - sea_level.equivalent
            row(f"{place}: equivalent speed, m/s beside sea level", "<= 0.5", f"{apart:+.2f}", abs(apart) <= 0.5)
            assert abs(apart) <= 0.5
            share = sea_level.density / one.density
            speed, radius = one.true / sea_level.true / math.sqrt(share), one.radius / sea_level.radius / share
            met = max(abs(speed - 1.0), abs(radius - 1.0)) <= WITHIN
            row(
                f"{place}: true speed by 1/sqrt(density), radius by 1/density",
                "1 +- 0.02",
                f"{speed:.4f}, {radius:.4f}",
                met,
            )
            assert met
    if name == "an26_pattern":
        row("An-26 at 20 t lands at 2500 m, standard", "landed", str((2500.0, 0.0) in landed), (2500.0, 0.0) in landed)
        assert (2500.0, 0.0) in landed


def test_la_paz(row):
    """True speeds that once flew at 1.145 of the stall speed, the same by the chart, and what lacks power."""
    true = {f"route.{key}_mps": value for key, value in zip(SPEEDS, (72, 69, 58), strict=True)}
    with pytest.raises(ScenarioError, match="indicated_turn_speed_mps") as told:
        prepare(read("an26_pattern", {"runway.elevation_m": 4061, **true}))
    row("an26 at 4061 m by true speeds of sea level", "refused with the remedy", str(told.value), True)
    one = flown("an26_pattern", 4061.0, 0.0)
    met = one.outcome == "landed" and one.final_over_stall >= 1.3
    row("An-26 at 20 t, 4061 m, by the chart", "landed, >= 1.3 Vs", f"{one.outcome}, {one.final_over_stall:.3f}", met)
    assert met
    with pytest.raises(ScenarioError, match=r"needs more than full power: [0-9]+ kW lack") as lacking:
        flown("an26_pattern", 4900.0, 30.0, mass_kg=24000)
    row("An-26 at 24 t, 4900 m, standard + 30 K", "names the power that lacks", str(lacking.value), True)
