"""The filters of the ledger of Volovyk 2022: sets of interacting models, and the rivals that the paper names.

Each stands at densities that are written here, whatever the defaults of its kind are. Those of a rival are its best:
`tuning` finds them, on seeds that no row is measured on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.claims.papers.volovyk2022.landing_paths import SCAN
from tracking.measurement import ConvertedPolar, DebiasedPolar
from tracking.motion import ConstantVelocity, Transition
from tracking.track import Tracker
from tracking.trackers.autonomous_models import AutonomousModels
from tracking.trackers.imm import InteractingMultipleModel, ModelSet, improved_set, published_set
from tracking.trackers.kalman import Kalman
from tracking.trackers.manoeuvre_detector import ManoeuvreDetector

RADAR = (1200.0, 150.0)  # m: 900 m past the aiming point, 150 m right of the centreline; ours
PLOTS = ConvertedPolar(position=RADAR, height=0.0)  # as the paper converts them


@dataclass(frozen=True)
class Printed:
    """A published model with another reading of its process noise, Q(dt) = ``noise``."""

    motion: Any
    noise: tuple[tuple[float, ...], ...]

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.motion.channels)

    @property
    def depends_on_state(self) -> bool:
        return bool(self.motion.depends_on_state)

    def transition(self, dt: float, mean: Any) -> Transition:
        """The model's F with the noise as read."""
        return Transition(self.motion.transition(dt, mean).F, np.array(self.noise))


def published(acceleration_density: float) -> ModelSet:
    """The printed set at a density."""
    return published_set(acceleration_density, slow=-0.001, fast=-0.045)


def read_as(noise: Any) -> ModelSet:
    """The published set under another reading of Q."""
    printed = published(0.01)
    rows = tuple(map(tuple, np.asarray(noise, float).tolist()))
    return printed._replace(models=tuple(Printed(model, rows) for model in printed.models))


def through_acceleration() -> Any:
    """B diag(.01, .01) B' with an acceleration held over the scan."""
    column = np.array([[0.5 * SCAN**2], [SCAN]])
    return np.kron(np.eye(2), 0.01 * column @ column.T)


DENSITY, DENSER, IMPROVED = "Q a density of .01", "Q a density of .3", "improved set"
ONE_FILTER, DETECTOR, AUTONOMOUS = "one filter", "one filter with a manoeuvre detector", "autonomous models"
RIVALS = (ONE_FILTER, DETECTOR, AUTONOMOUS)
TUNED: dict[str, dict[str, Any]] = {
    DENSER: {"acceleration_density": 0.3},
    ONE_FILTER: {"acceleration_density": 10.0},
    DETECTOR: {"quiet_density": 0.01, "manoeuvre_density": 1000.0, "window": 5, "false_alarm_rate": 1e-4},
    AUTONOMOUS: {"acceleration_density": 3.0, "least_weight": 0.01},
}


def made(name: str, **parameters: Any) -> Tracker:
    """A filter whose parameters are searched, with others than it has."""
    if name == DENSER:
        return InteractingMultipleModel(PLOTS, published(**parameters))
    if name == ONE_FILTER:
        return Kalman(PLOTS, ConstantVelocity(**parameters))
    if name == DETECTOR:
        return ManoeuvreDetector(PLOTS, **parameters)
    return AutonomousModels(
        PLOTS, published(parameters["acceleration_density"]), least_weight=parameters["least_weight"]
    )


FILTERS: dict[str, Tracker] = {
    DENSITY: InteractingMultipleModel(PLOTS, published(0.01)),
    "Q of B diag(.01) B'": InteractingMultipleModel(PLOTS, read_as(through_acceleration())),
    "Q .01 I": InteractingMultipleModel(PLOTS, read_as(0.01 * np.eye(4))),
    IMPROVED: InteractingMultipleModel(
        DebiasedPolar(position=RADAR, height=0.0), improved_set(0.01, 0.05, -0.5, math.radians(15.0))
    ),
    **{name: made(name, **parameters) for name, parameters in TUNED.items()},
}
