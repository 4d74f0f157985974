"""What theory says about a map before anything is flown: the borders that its figures draw."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

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


THEORIES = {
    "orbit": Theory(
        "wind.speed_mps",
        "autopilot.law.cross_track_limit_m",
        "theory: k1 z_max = k2 (V - wind)",
        orbit_border,
    )
}


def border(name: str, scenario: Scenario, x: np.ndarray) -> np.ndarray:
    """Values of y on the border of a theory, over values of x."""
    from sim.preparation import prepare

    return THEORIES[name].border(prepare(scenario).law, scenario, x)
