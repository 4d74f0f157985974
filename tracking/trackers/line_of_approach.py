"""Line of approach: constant velocity along and across the course line of a localiser, knowing no law."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from tracking.gaussian import Gaussian, Innovation, update
from tracking.measurement import Linear, MeasurementModel
from tracking.motion import CARTESIAN, Transition, constant_velocity
from tracking.trackers.kalman import filtered


@dataclass(frozen=True)
class LineOfApproach:
    """Kalman filter of the way along and across one line, each with its rate, in cartesian components.

    White accelerations drive the two: along by slowing down, across by corrections of the course. The densities are
    tuned on an An-26 that intercepts from 300 m beside the line (ANEES 1.0 on seeds 1 and 2); the autopilot can fly on
    the estimate, whose rate across comes 3 to 4 s late.

    Parameters
    ----------
    zero_azimuth : where the azimuth of its first sensor that measures one is zero: the line, seen from the antenna.
    """

    measurement: Annotated[MeasurementModel, "given"]
    zero_azimuth: Annotated[float, "given"]
    along_density: Annotated[float, "m2/s3"] = 0.3
    across_density: Annotated[float, "m2/s3"] = 1.0
    depends_on_state: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for name in ("along_density", "across_density"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be above 0")

    @property
    def channels(self) -> tuple[str, ...]:
        return CARTESIAN

    def transition(self, dt: float, mean: Any) -> Transition:
        """(F, Q) over dt: those of one axis, turned so that each density acts along its own direction."""
        return _transition(dt, self.zero_azimuth, self.along_density, self.across_density)

    def begin(self, prior: Gaussian) -> Gaussian:
        return prior

    def step(self, state: Gaussian, dt: float, z: Any | None, R: Any | None) -> tuple[Gaussian, Innovation | None]:
        return filtered(self, self.measurement, _conditioned, state, dt, z, R)

    def estimate(self, state: Gaussian) -> Gaussian:
        return state


@functools.lru_cache(maxsize=256)
def _transition(dt: float, zero_azimuth: float, along: float, across: float) -> Transition:
    """Kept, because an autopilot that flies on the estimate asks at every step, and steps are equally long."""
    F, Q = constant_velocity(dt, 1.0)
    c, s = math.cos(zero_azimuth), math.sin(zero_azimuth)
    turn = np.array(((c, -s), (s, c)))
    densities = turn @ np.diag((along, across)) @ turn.T
    return Transition(np.kron(np.eye(2), F), np.kron(densities, Q))


def _conditioned(state: Gaussian, linear: Linear) -> tuple[Gaussian, Innovation]:
    return update(state, *linear)
