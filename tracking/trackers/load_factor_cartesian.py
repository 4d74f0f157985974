"""Position and velocity aided by downlinked load factors: the cartesian relative of the load-factor tracker.

The print's idea without its polar algebra: the downlinked load factors give the horizontal acceleration, which is a
known input of a cartesian state. Gravity, Coriolis and centripetal terms need no care in axes that do not turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np

from tracking.azimuth_acceleration import horizontal_acceleration
from tracking.gaussian import Gaussian, Innovation, predict, update
from tracking.integrators import integrators
from tracking.measurement import MeasurementModel
from tracking.motion import CARTESIAN
from tracking.trackers.elevation import row_of
from tracking.trackers.load_factor import DOWNLINK, either

Array = Any

AXES = ((0, 1, 4), (2, 3, 5))  # position, rate and acceleration of north and of east in the state


class Aided(NamedTuple):
    """(north, north_rate, east, east_rate, north and east acceleration), and what the downlink last said."""

    gaussian: Gaussian
    downlinked: Array  # (2, *B) m/s2 north and east, NaN = silent for too long
    clock: Array  # s since then, () or (*B)


@dataclass(frozen=True)
class LoadFactorCartesian:
    """Kalman filter of the cartesian state whose acceleration is the downlinked one plus a residual [Glistin, eq. (1)].

    The residual is a first-order Markov process. When the downlink falls silent it takes over the last acceleration
    and goes on with kinematic noise; when the downlink speaks again it measures the acceleration up to the residual.

    Parameters
    ----------
    measurement : of the rows of z that are no downlinked quantity.
    measured : names of the rows of z; the six of ``tracking.trackers.load_factor.DOWNLINK`` must be among them.
    residual_density, kinematic_density : of the acceleration that is not known, at low frequency.
    """

    measurement: Annotated[MeasurementModel, "given"]
    measured: Annotated[tuple[str, ...], "given"]
    residual_density: Annotated[float, "m2/s3"] = 0.1
    residual_correlation_time: Annotated[float, "s"] = 10.0
    kinematic_density: Annotated[float, "m2/s3"] = 60.0
    kinematic_correlation_time: Annotated[float, "s"] = 20.0
    dropout: Annotated[float, "s"] = 2.0

    def __post_init__(self) -> None:
        for quantity in DOWNLINK:
            row_of(quantity, self.measured)
        if len(self._radar) != self.measurement.rows:
            raise ValueError(f"the measurement model reads {self.measurement.rows} rows, z has {len(self._radar)}")
        for name in ("residual_correlation_time", "kinematic_correlation_time", "dropout"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be above 0")
        for name in ("residual_density", "kinematic_density"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must not be negative")

    @cached_property
    def _downlink(self) -> list[int]:
        return [row_of(quantity, self.measured) for quantity in DOWNLINK]

    @cached_property
    def _radar(self) -> list[int]:
        return [row for row in range(len(self.measured)) if row not in self._downlink]

    @property
    def channels(self) -> tuple[str, ...]:
        return CARTESIAN

    def begin(self, prior: Gaussian) -> Aided:
        if len(prior.mean) != 4:
            raise ValueError(f"the prior must have the 4 states {', '.join(CARTESIAN)}")
        mean = np.concatenate([prior.mean, np.zeros_like(prior.mean[:2])])
        cov = np.zeros((6, 6, *prior.cov.shape[2:]))
        cov[:4, :4] = prior.cov
        cov[4, 4] = cov[5, 5] = self.kinematic_density / (2.0 * self.kinematic_correlation_time)
        return Aided(Gaussian(mean, cov), np.full((2, *prior.mean.shape[1:]), np.nan), 0.0)

    def step(self, state: Aided, dt: float, z: Any | None, R: Any | None) -> tuple[Aided, Innovation | None]:
        heard = None if z is None else np.isfinite(np.asarray(z)[self._downlink]).all(axis=0)
        known, clock = state.downlinked, state.clock + dt
        if heard is not None and heard.any():
            n_x, n_y, n_z, bank, path, course = np.asarray(z)[self._downlink]
            spoken = np.stack(horizontal_acceleration(n_x, n_y, n_z, bank, path, -course))
            known = np.where(heard, spoken, known)
            clock = 0.0 if heard.all() else np.where(heard, 0.0, clock)
        known = np.where(clock > self.dropout, np.nan, known)
        gaussian = self._moved(state.gaussian, state.downlinked, known, dt)
        innovation = None
        if z is not None:
            gaussian, innovation = self._plot(gaussian, np.asarray(z), R)
        return Aided(gaussian, known, clock), innovation

    def estimate(self, state: Aided) -> Gaussian:
        return Gaussian(state.gaussian.mean[:4], state.gaussian.cov[:4, :4])

    def _moved(self, gaussian: Gaussian, before: Array, now: Array, dt: float) -> Gaussian:
        """The state dt later, the downlinked acceleration running evenly from ``before`` to ``now``."""
        silent = np.isnan(now).any(axis=0)
        if silent.all():
            return self._kinematic(gaussian, dt)
        fresh = np.isnan(before) & np.isfinite(now)
        if fresh.any():  # the downlink speaks again: it measures the acceleration up to the residual
            variance = 0.5 * self.residual_density / self.residual_correlation_time
            gaussian, _ = update(gaussian, np.where(fresh, now, np.nan), np.eye(2, 6, 4), variance * np.eye(2))
            before = np.where(fresh, now, before)
        north, north_rate, east, east_rate, *accelerations = np.broadcast_arrays(*gaussian.mean, before[0])[:6]
        residual = [acceleration - known for acceleration, known in zip(accelerations, before, strict=True)]
        speed, way = 0.5 * (before + now) * dt, (2.0 * before + now) * dt**2 / 6.0
        aided = predict(
            Gaussian(np.stack([north, north_rate, east, east_rate, *residual]), gaussian.cov),
            *_planar(self.residual_correlation_time, self.residual_density, dt),
            np.stack([way[0], speed[0], way[1], speed[1], *now]),
        )
        return either(silent, self._kinematic(gaussian, dt), aided) if silent.any() else aided

    def _kinematic(self, gaussian: Gaussian, dt: float) -> Gaussian:
        return predict(gaussian, *_planar(self.kinematic_correlation_time, self.kinematic_density, dt))

    def _plot(self, gaussian: Gaussian, z: Array, R: Array) -> tuple[Gaussian, Innovation]:
        rows = np.array(self._radar)
        linear = self.measurement.linearise(z[rows], np.asarray(R)[rows[:, None], rows], gaussian.mean[:4])
        H = np.concatenate([linear.H, np.zeros((len(linear.H), 2, *linear.H.shape[2:]))], axis=1)
        return update(gaussian, linear.z, H, linear.R)


@lru_cache(maxsize=1024)
def _planar(memory: float, density: float, dt: float) -> tuple[Array, Array]:
    """(F, Q) (6, 6) of position, rate and first-order Markov acceleration on both axes."""
    one = integrators(3, memory, density / memory**2, dt)
    F, Q = np.zeros((6, 6)), np.zeros((6, 6))
    for axis in AXES:
        F[np.ix_(axis, axis)], Q[np.ix_(axis, axis)] = one
    F.flags.writeable = Q.flags.writeable = False
    return F, Q
