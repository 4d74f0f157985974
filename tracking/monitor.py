"""Does a tracker still follow what it measures? Accuracy monitoring, lock and conformance are one question.

The NIS of a tracker whose model holds is chi-square with one degree of freedom per channel measured, independent from
epoch to epoch, so that its sum over a window is chi-square too: exactly for a linear Gaussian filter, nearly for the
moment-matched innovation of an IMM. Where the prediction of a measurement is itself far from Gaussian, as in a filter
of switching noise, large sums are commoner (12 % of the epochs where 1 % was stated): ask for a lower rate there.

A manoeuvre that the model does not know, a target that left the route whose law the tracker assumes, a sensor worse
than its R, a lost target: all raise it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from scipy.special import chdtri, gammaincc

from tracking.gaussian import Gaussian, Innovation, Mixture, merge
from tracking.track import Track, Tracker
from tracking.tree import choose

Array = Any


class Window(NamedTuple):
    """The last epochs at which something was measured, newest last."""

    nis: tuple[Array, ...]  # (*B) each
    degrees: tuple[Array, ...]  # (*B) each, channels measured


class Verdict(NamedTuple):
    """What the window says."""

    probability: Array  # (*B) of so large a sum if the model holds; 1 where nothing was measured, NaN of a lost run
    alarm: Array  # (*B) bool


class Alarms(NamedTuple):
    """The verdicts along a record, at its k epochs at which anything was measured."""

    time: Array  # (k,) s
    looked: Array  # (k, *B) bool, in which runs something was measured
    alarm: Array  # (k, *B) bool


@dataclass(frozen=True)
class NisMonitor:
    """Alarm when the sum of NIS over the last ``window`` epochs is too large for chance.

    ``false_alarm_rate`` is the probability of an alarm at each epoch at which something is measured, while the model
    holds. Neighbouring windows overlap, so alarms come in bursts and their onsets are rarer.
    """

    window: int = 10  # epochs
    false_alarm_rate: float = 1e-4

    def __post_init__(self) -> None:
        if self.window < 1:
            raise ValueError("window must be at least 1 epoch")
        if not 0.0 < self.false_alarm_rate < 1.0:
            raise ValueError("false_alarm_rate must lie between 0 and 1")

    def begin(self) -> Window:
        """Nothing measured yet."""
        return Window((), ())

    def step(self, window: Window, innovation: Innovation | None) -> tuple[Window, Verdict | None]:
        """Add one epoch; no verdict where there was no measurement."""
        if innovation is None:
            return window, None
        degrees = np.isfinite(innovation.white).sum(axis=0)
        nis = _counted(innovation.nis, degrees)
        window = Window((*window.nis, nis)[-self.window :], (*window.degrees, degrees)[-self.window :])
        freedom, total = sum(window.degrees), sum(window.nis)
        with np.errstate(invalid="ignore"):
            known = (freedom > 0) | np.isnan(total)
            probability = np.where(known, gammaincc(0.5 * np.maximum(freedom, 1), 0.5 * total), 1.0)
        return window, Verdict(probability, ~(probability >= self.false_alarm_rate))  # NaN is an alarm

    def watch(self, track: Track) -> Alarms:
        """The verdicts of ``step`` along the record of a tracker, all at once.

        A sum is compared with the quantile of its chi-square, one for each number of channels that a window can hold.
        """
        degrees = np.isfinite(track.white).sum(axis=1)
        nis = _counted(np.asarray(track.nis), degrees)
        looked = (degrees > 0) | np.isnan(nis)
        epochs = looked.reshape(len(looked), -1).any(axis=1)
        nis, degrees, looked = nis[epochs], degrees[epochs], looked[epochs]
        total, freedom = np.zeros_like(nis), np.zeros_like(degrees)
        for lag in reversed(range(min(self.window, len(nis)))):  # the oldest first, as in ``step``
            total[lag:] += nis[: len(nis) - lag]
            freedom[lag:] += degrees[: len(nis) - lag]
        limit = chdtri(np.arange(1.0, freedom.max(initial=0) + 1.0), self.false_alarm_rate)
        with np.errstate(invalid="ignore"):
            alarm = ~(total <= np.concatenate(([np.inf], limit))[freedom])  # NaN is an alarm
        return Alarms(np.asarray(track.time)[epochs], looked, alarm)


MONITOR = NisMonitor(window=10, false_alarm_rate=1e-3)
"""What watches every tracker of a run: one look in a thousand is alarmed while the model holds."""


class MonitoredState(NamedTuple):
    """A tracker's state with what the monitor saw."""

    tracker: Any
    window: Window
    probability: Array  # (*B) of the last verdict
    restarts: Array  # (*B)


@dataclass(frozen=True)
class Monitored:
    """Any tracker under a `NisMonitor`, restarted from a wide prior in the runs in which it alarms.

    A restart keeps the estimate's mean, forgets its covariance for ``wide``, takes in the present measurement and
    empties the window. A tracker's state must be (nested tuples of) arrays with the runs on the last axis.
    """

    tracker: Annotated[Tracker, "given"]
    wide: Annotated[Any, "given"]  # (n, n) covariance to restart from
    monitor: NisMonitor = NisMonitor()

    @property
    def channels(self) -> tuple[str, ...]:
        return self.tracker.channels

    def begin(self, prior: Gaussian) -> MonitoredState:
        batch = np.shape(prior.mean)[1:]
        return MonitoredState(
            self.tracker.begin(prior), self.monitor.begin(), np.ones(batch), np.zeros(batch, dtype=int)
        )

    def step(
        self, state: MonitoredState, dt: float, z: Any | None, R: Any | None
    ) -> tuple[MonitoredState, Innovation | None]:
        followed, innovation = self.tracker.step(state.tracker, dt, z, R)
        window, verdict = self.monitor.step(state.window, innovation)
        if verdict is None:
            return MonitoredState(followed, window, state.probability, state.restarts), None
        if np.any(verdict.alarm):
            followed = choose(verdict.alarm, self._restarted(state, dt, z, R, followed), followed)
            window = choose(verdict.alarm, _emptied(window), window)
        return MonitoredState(followed, window, verdict.probability, state.restarts + verdict.alarm), innovation

    def estimate(self, state: MonitoredState) -> Gaussian | Mixture:
        return self.tracker.estimate(state.tracker)

    def _restarted(self, state: MonitoredState, dt: float, z: Any, R: Any, followed: Any) -> Any:
        mean = _mean(self.tracker.estimate(followed))
        if not np.isfinite(mean).all():  # what cannot be followed is predicted from before
            before = _mean(self.tracker.estimate(self.tracker.step(state.tracker, dt, None, None)[0]))
            mean = np.where(np.isfinite(mean), mean, before)
        wide = np.asarray(self.wide, dtype=float)
        wide = wide.reshape(*wide.shape, *(1,) * (mean.ndim - 1))
        return self.tracker.step(self.tracker.begin(Gaussian(mean, wide)), 0.0, z, R)[0]


def _counted(nis: Array, degrees: Array) -> Array:
    """NIS of an epoch as a window keeps it: no measurement adds nothing, and a lost run (NaN) stays lost."""
    return np.where((degrees > 0) | np.isnan(nis), nis, 0.0)


def _emptied(window: Window) -> Window:
    return Window(tuple(map(np.zeros_like, window.nis)), tuple(map(np.zeros_like, window.degrees)))


def _mean(estimate: Gaussian | Mixture) -> Array:
    return merge(estimate).mean if isinstance(estimate, Mixture) else estimate.mean
