"""Parameters of the rivals of the interacting models, and of these themselves, on a seed that no row reports."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from sim.claims.papers.volovyk2022.experiment import LEGS, by_run, errors, experiment
from sim.claims.papers.volovyk2022.filters import TUNED, made
from sim.claims.papers.volovyk2022.landing_paths import JSBSIM, LEFT

SEED = 1
CASES = ((LEFT, 40), (JSBSIM, 3))  # truth and runs, or flights
WORTH = 1e-3  # share of the mean square error below which a step is no gain
DECADES = tuple(float(f"{10.0 ** (0.5 * half):.0e}") for half in range(-12, 11))  # ..., 0.1, 0.3, 1, 3, ...
GRID: dict[str, tuple[float, ...]] = {
    **dict.fromkeys(("acceleration_density", "quiet_density", "manoeuvre_density"), DECADES),
    "window": (1, 2, 3, 5, 7, 10, 14, 20, 30),
    "false_alarm_rate": (*(value for value in DECADES if value < 0.1), 0.1, 0.2, 0.4, 0.6, 0.8),
    "least_weight": tuple(value for value in DECADES if value < 0.3),
}


@lru_cache(maxsize=1024)
def cost(name: str, parameters: tuple[tuple[str, float], ...]) -> float:
    """Product of the mean square position errors over the whole pattern, of the point mass and of JSBSim."""
    product = 1.0
    for truth, runs in CASES:
        data = experiment(SEED, runs, truth)
        among = np.isin(data.phase, LEGS["all"])
        product *= float(by_run(errors(made(name, **dict(parameters)), data).own["position"], among).mean())
    return product


def tune(name: str, start: dict[str, Any] | None = None) -> dict[str, Any]:
    """The parameters that no neighbour on the grid betters, from those in use or from others."""
    best = TUNED[name] if start is None else start

    def worth(parameters: dict[str, Any]) -> float:
        return cost(name, tuple(parameters.items()))

    while worth(better := min(neighbours(best), key=worth)) < (1.0 - WORTH) * worth(best):
        best = better
    return best


def neighbours(parameters: dict[str, Any]) -> list[dict[str, Any]]:
    """Parameters one step away on the grid, as far as they are such that a filter takes."""
    found = []
    for name, value in parameters.items():
        grid = GRID[name]
        place = grid.index(value)
        found += [{**parameters, name: grid[i]} for i in (place - 1, place + 1) if 0 <= i < len(grid)]
    return [one for one in found if one.get("quiet_density", 0.0) <= one.get("manoeuvre_density", 0.0)]
