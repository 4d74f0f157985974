"""A tracker as a user writes one; it says what it was given by how far it moves its estimate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tracking.gaussian import Gaussian, Innovation


@dataclass(frozen=True)
class Mine:
    """It keeps the speed of its prior and looks at nothing."""

    law: Any = None
    route: Any = None
    drift: float = 0.0  # m/s

    channels = ("north", "north_rate", "east", "east_rate")

    def begin(self, prior: Gaussian) -> Gaussian:
        return Gaussian(np.array(prior.mean), np.array(prior.cov))

    def step(self, state: Gaussian, dt: float, z: Any, R: Any) -> tuple[Gaussian, Innovation | None]:
        mean = np.array(state.mean)
        mean[0::2] += dt * (mean[1::2] + self.drift)
        return Gaussian(mean, state.cov), None

    def estimate(self, state: Gaussian) -> Gaussian:
        return state
