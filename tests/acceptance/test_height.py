"""Routes that change height, watched by radars that measure none and by radars with Mode C, at full size."""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from sim.estimation.assumed_height import height_cost
from sim.estimation.setup import height_profile, measurement_model
from sim.experiment import evaluate, fly
from sim.flight.interpolation import truth_at
from sim.flight.preparation import prepare
from sim.observation.record import observe
from sim.scenario.reading import read
from tracking.height_profile import ChartHeight

pytestmark = pytest.mark.acceptance
DRAWS = 130
RADAR = {"kind": "surveillance_radar", "position_m": [36_000, 4000, 10]}
MODE_C = {"height": "mode_c"}
TRACKERS = ("imm", "kalman", "saturated_control")
COLD = {"temperature_c": -20}  # at the standard QNH, for which charts give their correction


def route(heights: tuple[int, int], sensor: Any = None, air: Any = None) -> Any:
    """The An-26 along 45 km at 80 m/s, at two heights."""
    points = ((0, 0), (20_000, 0), (45_000, 0.1))
    legs = [
        {"from_m": list(start), "to_m": list(end), "speed_mps": 80, "height_m": height}
        for start, end, height in zip(points[:-1], points[1:], heights, strict=True)
    ]
    tables = {
        "name": "heights",
        "draws": DRAWS,
        "aircraft": {"model": "an26", "mass_kg": 20_000},
        "air": air or {},
        "route": {"kind": "legs", "legs": legs},
        "start": {"leg": 0},
        "sensors": {"radar": {**RADAR, **(sensor or {})}},
        "trackers": {name: {"kind": name, "sensors": ["radar"]} for name in TRACKERS},
    }
    return prepare(read(tables))


@cache
def flight(heights: tuple[int, int]) -> Any:
    return fly(route(heights), 0)


@cache
def figures(heights: tuple[int, int], **sensor: Any) -> dict[str, tuple[float, float, float]]:
    """(RMSE m, ANEES, lost) of each tracker."""
    found = evaluate(route(heights, sensor), flight(heights)).trackers
    return {
        name: (its["overall"]["position_m"]["rmse"], its["anees"], its["lost_fraction"]) for name, its in found.items()
    }


@pytest.mark.parametrize(("what", "heights"), [("descending", (2000, 600)), ("climbing", (600, 2000))])
def test_two_heights_against_one(what, heights, row):
    one, two = figures((2000, 2000)), figures(heights)
    for name in TRACKERS:
        share, anees, lost = two[name][0] / one[name][0], two[name][1], two[name][2]
        met = share <= 1.3 and anees <= 1.5 and lost == 0.0
        row(
            f"{what}, {name}, no height measured: RMSE over that at one height; ANEES; lost",
            "<= 1.3; <= 1.5; none (imm)",
            f"{share:.2f}; {anees:.2f} (at one height {one[name][1]:.2f}); {lost:.0%}",
            met,
        )
        assert met


@pytest.mark.parametrize("step", [25, 100])
def test_mode_c(step, row):
    """An ANEES below 0.9 is that of the same tracker at one height: its process noise is made for turns."""
    one, two = figures((2000, 2000)), figures((2000, 600), **MODE_C, height_step_ft=step)
    for name in TRACKERS:
        rmse, anees, lost = two[name]
        asked = "0.9-1.2; <= 1.3; none" if name == "imm" else "shown; <= 1.3; none"
        row(
            f"descending, {name}, Mode C in steps of {step} ft: ANEES; RMSE over that at one height; lost",
            asked,
            f"{anees:.2f} (at one height {one[name][1]:.2f}); {rmse / one[name][0]:.2f}; {lost:.0%}",
            (name != "imm" or anees >= 0.9) and anees <= 1.2 and rmse <= 1.3 * one[name][0] and lost == 0.0,
        )
        assert rmse <= 1.3 * one[name][0]
        assert anees <= 1.2
        assert abs(anees - one[name][1]) <= 0.05  # intervals of an ANEES over 130 draws are as wide
        assert lost == 0.0


@pytest.mark.parametrize("step", [25, 100])
def test_plots_with_mode_c_err_as_they_say(step, row):
    """The plots' own normalised error: here no process noise hides an R that is too large or too small."""
    prepared = route((2000, 600), {**MODE_C, "height_step_ft": step})
    own = flight((2000, 600))
    record = observe(own, prepared.scenario.sensors, 1, draws=DRAWS)["radar"]
    model = measurement_model(prepared, prepared.scenario.sensors, "imm")
    truth = truth_at(own, record.time)
    errors = []
    for z, R, position, velocity in zip(record.z, record.R, truth.position.T, truth.velocity.T, strict=True):
        mean = np.repeat([[position[0]], [velocity[0]], [position[1]], [velocity[1]]], DRAWS, axis=1)
        seen = model.linearise(z, R, mean)
        off = seen.z - np.einsum("ij...,j...->i...", seen.H, mean)
        R = np.broadcast_to(seen.R if seen.R.ndim > 2 else seen.R[..., None], (2, 2, DRAWS))
        errors.append(np.einsum("in,ijn,jn->n", off, np.linalg.inv(R.T).T, off).mean() / 2.0)
    found = float(np.mean(errors))
    what = f"descending, Mode C in steps of {step} ft: normalised squared error of the plots themselves"
    row(what, "0.9-1.1", f"{found:.3f}", 0.9 <= found <= 1.1)
    assert 0.9 <= found <= 1.1


def test_mode_c_on_the_pattern(row):
    """With turns, for which its models are made, the improved IMM is as sure as it should be."""
    prepared = prepare(read("an26_pattern", {"sensors.terminal.height": "mode_c"}))
    found = evaluate(prepared, fly(prepared, 0)).trackers
    for name in ("improved_imm", "intent_imm", "saturated_control"):
        anees = found[name]["anees"]
        asked = "0.9-1.2" if name == "improved_imm" else "shown"
        row(f"an26_pattern, {name}, terminal radar with Mode C: ANEES", asked, f"{anees:.2f}", anees <= 1.2)
    assert 0.9 <= found["improved_imm"]["anees"] <= 1.2


def test_a_cold_day_stays_in_mode_c(row):
    """-20 C at the threshold: what is told is too high by 15 % of the height."""
    prepared = route((2000, 600), MODE_C, COLD)
    own = flight((2000, 600))
    record = observe(own, prepared.scenario.sensors, 1, draws=DRAWS)["radar"]
    height = np.interp(record.time, own.time, own.state.height)
    off = np.mean(record.z[:, 2], axis=1) - height
    correction = height * (15.0 + 20.0) / (273.0 - 20.0 - 0.5 * 0.0065 * height)  # ICAO Doc 8168, above sea level
    error = float(np.abs(off - correction).max() / correction.max())
    what = "Mode C at -20 C: its error against the cold-temperature correction of charts, share of the largest"
    row(what, "< 5 %", f"{error:.1%}", error < 0.05)
    assert error < 0.05


class Leg0(NamedTuple):
    """The height of the first leg everywhere: what was taken for granted before."""

    height: float

    def at(self, north: Any, *motion: Any) -> ChartHeight:
        """The same anywhere."""
        return ChartHeight(np.full_like(north, self.height), np.zeros_like(north))


@pytest.mark.parametrize("position", [(2000, 3000, 10), (300, 800, 10)])
def test_near_the_runway(position, row):
    """The normal pattern: what the assumed height makes of the ground range, on the flight, without noise."""
    prepared = prepare(read("an26_pattern", {"sensors.terminal.position_m": list(position)}))
    own, radar = fly(prepared, 0), prepared.scenario.sensors["terminal"]
    record = observe(own, {"terminal": radar}, 1)["terminal"]

    def metres(chart: Any) -> float:
        cost = height_cost(own, chart, radar, record)
        place = np.array([np.interp(cost.time, own.time, own.state[i]) for i in (1, 2, 3)])
        off = place - np.array(radar.antenna)[:, None]
        slant = np.sqrt((off**2).sum(axis=0))
        return float((cost.cost * radar.range_sigma * slant / np.hypot(off[0], off[1])).max())

    before, now = metres(Leg0(400.0)), metres(height_profile(prepared))
    row(
        f"an26_pattern, radar {math.dist(position[:2], (300, 0)):.0f} m from the aiming point: largest error of the "
        "ground range by the assumed height, m",
        "less than with the height of leg 0; <= half of 60 m",
        f"{now:.1f} (with the height of leg 0: {before:.1f})",
        now < before and now <= 30.0,
    )
    assert now < 0.5 * before
    assert now <= 30.0
