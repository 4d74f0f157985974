"""What theory says about a map before anything is flown: the borders that its figures draw."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from sim.errors import ScenarioError
from sim.scenario import Scenario


class Theory(NamedTuple):
    """A border in the plane of two axes, in the spelling of files."""

    x: str  # addresses of the axes
    y: str
    label: str
    border: Callable[[Any, Scenario, np.ndarray], np.ndarray]  # (law, scenario, values of x) -> values of y


def orbit_border(law: Any, scenario: Scenario, wind: np.ndarray) -> np.ndarray:
    """The cross-track limit above which the law orbits, m, in a wind that blows away from the line, m/s.

    Far out the bank returns to zero on some course only if k1 min(z_max, offset) < k2 min(zdot_max, closing speed), and
    the closing speed is at most the airspeed less the wind [Vasylyev 2003, eq. (4)].
    """
    airspeed = min(leg.speed for leg in scenario.route.legs)  # type: ignore[union-attr]
    closing = np.minimum(law.cross_track_rate_limit, np.maximum(airspeed - wind, 0.0))
    border = law.k2 / law.k1 * closing
    return np.where(border < abs(scenario.start.cross_track), border, math.inf)


def energy_border(law: Any, scenario: Scenario, places: np.ndarray) -> np.ndarray:
    """The strength of a microburst, m/s, above which full power cannot hold speed and glide path, over its place, m.

    Through the air the energy height changes by V ((thrust - drag) / weight - F), and on the glide path it must fall by
    V sin(glide path): no power holds both once F, over a kilometre, exceeds the steepest climb and the glide path.
    """
    from sim.preparation import prepare
    from sim.windshear import steepest_climb, worst_on_the_glide_path

    prepared = prepare(scenario)
    landing = prepared.autopilot.landing
    if landing is None or "burst" not in scenario.wind.events:
        raise ScenarioError(f'{scenario.name}: theory "energy" needs a landing pattern and a [wind.events.burst]')
    reserve = steepest_climb(prepared) + math.sin(scenario.runway.glide_path)
    burst = dataclasses.replace(scenario.wind.events["burst"], peak=1.0, at=None, lasts=None)

    def strength(place: float) -> float:
        there = dataclasses.replace(burst, past_threshold=place)
        worst = worst_on_the_glide_path(there, scenario.runway, landing.approach_speed, landing.gate.height)
        return reserve / worst if worst > 0.0 else math.inf

    return np.array([strength(float(place)) for place in places])


THEORIES = {
    "energy": Theory(
        "wind.events.burst.past_threshold_m",
        "wind.events.burst.peak_mps",
        "theory: F over 1 km = steepest climb + glide path",
        energy_border,
    ),
    "orbit": Theory(
        "wind.speed_mps",
        "autopilot.law.cross_track_limit_m",
        "theory: k1 z_max = k2 (V - wind)",
        orbit_border,
    ),
}


def border(name: str, scenario: Scenario, x: np.ndarray) -> np.ndarray:
    """Values of y on the border of a theory, over values of x."""
    from sim.preparation import prepare

    return THEORIES[name].border(prepare(scenario).law, scenario, x)
