"""A user's own filterpy filter as a tracker: designed and stepped there, run over ensembles here.

Taken: `filterpy.kalman.KalmanFilter`, and `filterpy.kalman.IMMEstimator` over KalmanFilters. They are matrices, so one
batched filter serves all runs. Not taken: extended, unscented, cubature, ensemble and the other filters, because they
call the user's own functions on one column vector at a time, which cannot be batched; and a KalmanFilter with
fading memory (alpha) or correlated noises (M), which is another filter.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from tracking.gaussian import Gaussian
from tracking.measurement import LinearMeasurement
from tracking.motion import CARTESIAN, Motion, Transition
from tracking.trackers.imm import InteractingMultipleModel, ModelSet
from tracking.trackers.kalman import Kalman

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class FixedMotion:
    """A transition designed for one period; several periods are as many predictions.

    Without a period every step is one prediction, as in filterpy's own loop.
    """

    F: Annotated[Rows, "given"]
    Q: Annotated[Rows, "given"]
    channels: Annotated[tuple[str, ...], "given"]
    period: Annotated[float | None, "given"] = None
    depends_on_state = False

    def __post_init__(self) -> None:
        n = len(self.channels)
        F, Q = np.array(self.F), np.array(self.Q)
        if F.shape != (n, n) or Q.shape != (n, n):
            raise ValueError(f"F and Q must be ({n}, {n}) for the channels {', '.join(self.channels)}")
        scale = np.sqrt(np.outer(np.diag(Q), np.diag(Q))) if (np.diag(Q) >= 0.0).all() else None
        if scale is None or (np.abs(Q - Q.T) > 1e-9 * scale).any():
            raise ValueError("Q must be symmetric with no negative variance")
        if self.period is not None and not self.period > 0.0:
            raise ValueError("period must be positive")

    def transition(self, dt: float, mean: Any) -> Transition:
        steps = 1 if self.period is None else round(dt / self.period)
        if self.period is not None and abs(dt - steps * self.period) > 1e-6 * self.period:
            raise ValueError(f"F was designed for {self.period:g} s; {dt:g} s is no multiple of it")
        F, Q = np.array(self.F), np.array(self.Q)
        total, noise = np.eye(len(F)), np.zeros_like(Q)
        for _ in range(steps):
            total, noise = F @ total, F @ noise @ F.T + Q
        return Transition(total, noise)


def from_filterpy(
    source: Any, channels: tuple[str, ...] = CARTESIAN, period: float | None = None
) -> Kalman | InteractingMultipleModel:
    """Tracker with the F, Q, H (and M, mu) of a filterpy ``KalmanFilter`` or ``IMMEstimator`` over such.

    Parameters
    ----------
    source : the filterpy object; it is read once and not changed.
    channels : names of its state components.
    period : s, for which F was designed; None applies F once per measurement.

    The accuracy R of each measurement comes with the measurement. `prior_of` gives the object's own x and P.

    Raises
    ------
    TypeError : the class cannot be batched.
    ValueError : the object uses what another filter would need.
    """
    from filterpy.kalman import IMMEstimator, KalmanFilter

    if isinstance(source, IMMEstimator):
        filters = list(source.filters)
        for member in filters:
            _check(member, KalmanFilter)
        if any(not np.array_equal(member.H, filters[0].H) for member in filters):
            raise ValueError("the filters of the IMMEstimator must share H")
        if any(not np.array_equal(member.R, filters[0].R) for member in filters):
            raise ValueError("the filters of the IMMEstimator must share R; hypotheses about R are another tracker")
        models = tuple(FixedMotion(_rows(member.F), _rows(member.Q), channels, period) for member in filters)
        model_set = ModelSet(models, _rows(source.M), tuple(float(weight) for weight in source.mu))
        return InteractingMultipleModel(LinearMeasurement(_rows(filters[0].H)), model_set)
    _check(source, KalmanFilter)
    motion = FixedMotion(_rows(source.F), _rows(source.Q), channels, period)
    return Kalman(LinearMeasurement(_rows(source.H)), motion)


def prior_of(source: Any) -> Gaussian:
    """The x and P that a filterpy object holds now."""
    return Gaussian(np.array(source.x, dtype=float).reshape(-1), np.array(source.P, dtype=float))


@lru_cache(maxsize=256)
def constant_velocity(dt: float, acceleration_density: float) -> Motion:
    """Planar constant velocity for one period, with the noise as filterpy designs it."""
    F = np.kron(np.eye(2), [[1.0, dt], [0.0, 1.0]])
    noise = _discretization().Q_continuous_white_noise
    Q = noise(dim=2, dt=dt, spectral_density=acceleration_density, block_size=2)
    return FixedMotion(_rows(F), _rows(Q), CARTESIAN)


@lru_cache(maxsize=1)
def _discretization() -> Any:
    """filterpy's module of process noise alone: its package imports scipy.stats, which takes as long as a flight."""
    package = find_spec("filterpy")
    assert package is not None
    assert package.origin is not None
    spec = spec_from_file_location("discretization", Path(package.origin).parent / "common" / "discretization.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _check(source: Any, kalman_filter: Any) -> None:
    if source.__class__ is not kalman_filter:
        raise TypeError(
            f"{type(source).__name__} cannot be batched over runs: it is no set of matrices; "
            "from_filterpy takes KalmanFilter and IMMEstimator over KalmanFilters"
        )
    if source.alpha != 1.0:
        raise ValueError("a KalmanFilter with fading memory (alpha other than 1) is not supported")
    if np.any(source.M):
        raise ValueError("a KalmanFilter with correlated process and measurement noise (M) is not supported")
    if callable(source.F) or np.ndim(source.F) != 2 or np.ndim(source.H) != 2:
        raise ValueError("F and H of the KalmanFilter must be set to matrices first")


def _rows(matrix: Any) -> Rows:
    return tuple(tuple(float(entry) for entry in row) for row in np.atleast_2d(np.asarray(matrix, dtype=float)))
