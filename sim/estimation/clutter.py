"""A tracker among false plots: association between one radar's plots and any tracker on the ground plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tracking.association import ProbabilisticDataAssociation
from tracking.gaussian import Gaussian, Innovation, Mixture
from tracking.track import Tracker, modes_of


@dataclass(frozen=True)
class AmongFalsePlots:
    """A tracker on the ground plane, fed by probabilistic data association with all plots of one radar.

    The density of false plots on the ground grows as the aircraft comes nearer, so each step evaluates it at the mean
    position of its own plots.
    """

    tracker: Tracker
    radar: Any

    @property
    def channels(self) -> tuple[str, ...]:
        """Those of the tracker."""
        return self.tracker.channels

    @property
    def modes(self) -> tuple[str, ...]:
        """What the tracker calls its hypotheses, for the report."""
        return modes_of(self.tracker)

    def begin(self, prior: Gaussian) -> Any:
        """State before the first plot."""
        return self.tracker.begin(prior)

    def step(self, state: Any, dt: float, z: Any | None, R: Any | None) -> tuple[Any, Innovation | None]:
        """Predict by dt, then update with the plots z (c, 3, draws) that share R (3, 3, draws)."""
        if z is None:
            return self.tracker.step(state, dt, None, None)
        made = np.isfinite(z)
        place = np.where(made, z, 0.0).sum(axis=0) / np.maximum(made.sum(axis=0), 1)
        seen = made.any(axis=(0, 1))
        density = np.where(seen, self.radar.clutter_density(*np.where(seen, place, 1.0)), 1.0)  # any, where no plot is
        association = ProbabilisticDataAssociation(self.tracker, density, self.radar.detection)
        return association.step(state, dt, z, R)

    def estimate(self, state: Any) -> Gaussian | Mixture:
        """What the tracker believes."""
        return self.tracker.estimate(state)
