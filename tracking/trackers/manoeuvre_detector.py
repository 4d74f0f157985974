"""Kalman filter with a manoeuvre detector, which raises the process noise and lowers it again: adaptive noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, NamedTuple

import numpy as np

from tracking.gaussian import Gaussian, Innovation, predict, update
from tracking.measurement import MeasurementModel
from tracking.monitor import NisMonitor, Window
from tracking.motion import CARTESIAN, ConstantVelocity
from tracking.tree import choose


class Prediction(NamedTuple):
    """One mean with its covariance under either noise; both are one after a measurement."""

    mean: Any  # (4, *B)
    quiet: Any  # (4, 4, *C)
    raised: Any  # (4, 4, *C)
    window: Window
    alarm: Any  # (*B) bool, of the last measurement


@dataclass(frozen=True)
class ManoeuvreDetector:
    """Straight flight whose process noise has two levels, switched by the innovations.

    Before it takes in a measurement the filter sums the NIS that it has at the quiet density over the last ``window``
    measurements. Where the sum is too large for chance, chi-square at ``false_alarm_rate`` for each measurement, this
    measurement is taken in at the ``manoeuvre_density`` instead, from the prediction on that led to it; and so on
    until the sum is small again: the adjustable process noise of Bar-Shalom, Li and Kirubarajan, "Estimation with
    Applications to Tracking and Navigation", 2001, section 11.2, with two levels.

    The defaults are where a search ended on landing patterns under the radar of Volovyk 2022, 30 m and 1 deg every
    0.7 s: so high a level forgets the past, and the filter begins anew.

    Both levels move the mean alike, so that one mean and two covariances are carried from measurement to measurement.
    """

    measurement: Annotated[MeasurementModel, "given"]
    quiet_density: Annotated[float, "m2/s3"] = 0.01
    manoeuvre_density: Annotated[float, "m2/s3"] = 1000.0
    window: int = 5  # measurements
    false_alarm_rate: float = 1e-4
    channels = CARTESIAN

    def __post_init__(self) -> None:
        if not self.quiet_density <= self.manoeuvre_density:
            raise ValueError("manoeuvre_density must not be below quiet_density")
        _ = self._monitor, self._motions  # a bad parameter is told when it is given

    @cached_property
    def _monitor(self) -> NisMonitor:
        return NisMonitor(self.window, self.false_alarm_rate)

    @cached_property
    def _motions(self) -> tuple[ConstantVelocity, ConstantVelocity]:
        return ConstantVelocity(self.quiet_density), ConstantVelocity(self.manoeuvre_density)

    def begin(self, prior: Gaussian) -> Prediction:
        alarm = np.zeros(np.shape(prior.mean)[1:], bool)
        return Prediction(prior.mean, prior.cov, prior.cov, self._monitor.begin(), alarm)

    def step(self, state: Prediction, dt: float, z: Any | None, R: Any | None) -> tuple[Prediction, Innovation | None]:
        if dt > 0.0:
            quiet, raised = (
                predict(Gaussian(state.mean, cov), *motion.transition(dt, state.mean))
                for cov, motion in zip((state.quiet, state.raised), self._motions, strict=True)
            )
            state = state._replace(mean=quiet.mean, quiet=quiet.cov, raised=raised.cov)
        if z is None:
            return state, None
        linear = self.measurement.linearise(z, R, state.mean)
        posterior, innovation = update(Gaussian(state.mean, state.quiet), *linear)
        measured = np.isfinite(innovation.white).any(axis=0)
        window, verdict = self._monitor.step(state.window, innovation)
        alarm = state.alarm if verdict is None else np.where(measured, verdict.alarm, state.alarm)
        if alarm.any():
            wide = update(Gaussian(state.mean, state.raised), *linear)
            posterior, innovation = choose(alarm, wide, (posterior, innovation))
        covs = posterior.cov, posterior.cov
        if not measured.all():  # a run without a measurement keeps both
            covs = np.where(measured, covs[0], state.quiet), np.where(measured, covs[1], state.raised)
        return Prediction(posterior.mean, *covs, window, alarm), innovation

    def estimate(self, state: Prediction) -> Gaussian:
        if state.quiet is state.raised or not state.alarm.any():
            return Gaussian(state.mean, state.quiet)
        return Gaussian(state.mean, np.where(state.alarm, state.raised, state.quiet))
