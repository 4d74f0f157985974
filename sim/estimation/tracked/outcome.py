"""What is kept of a tracker: its track, its curves and its figures."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.estimation.look_ahead import Looks, look_ahead_rmse
from sim.estimation.many_draws.collected import filed
from sim.estimation.tracked.parts import Errors
from sim.estimation.tracked.watch import Entry, Watch, sensors_of
from sim.flight.interpolation import truth_at
from sim.flight.outcomes import ROLLOUT
from sim.metrics import conformance
from sim.metrics.alarms import monitoring
from sim.metrics.contrasts.squares import squared_errors
from sim.metrics.error_curves import ErrorCurves, curves_without_truth, error_curves
from sim.metrics.tracker import TrackerErrors, skipped, tracker_metrics
from tracking.conformance import CONFORMANCE
from tracking.track import Measurements, Track


class Tracked(NamedTuple):
    """One tracker as it was set up, its measurements, its track and its errors."""

    tracker: Any
    law_from: str | None
    measurements: Measurements  # where the draws go through it in parts, those of the first draw
    track: Track  # to the end of the flight
    curves: ErrorCurves
    rollout: Track | None = None  # after the landing; None = nothing was measured then
    squares: dict[str, Any] | None = None  # its squared errors by time (metrics.contrasts), where it is contrasted

    def __repr__(self) -> str:
        """One line; a tracker may hold filters, and its track thousands of covariances."""
        law = "" if self.law_from is None else f", law from {self.law_from}"
        return f"<Tracked by {type(self.tracker).__name__}{law}: {self.track!r}>"


class Outcome(NamedTuple):
    """The track and figures of one tracker, small enough to be sent between processes."""

    track: Track
    curves: ErrorCurves
    figures: dict[str, Any]
    rollout: Track | None = None
    squares: dict[str, Any] | None = None


def joined(first: Track, second: Track) -> Track:
    """One track after another as one."""
    parts = zip(first[1:], second[1:], strict=True)
    return Track(first.channels, *(None if a is None or b is None else np.concatenate((a, b)) for a, b in parts))


def judged_by_truth(watch: Watch, entry: Entry, made: Track, errors: TrackerErrors, looked: Looks) -> Outcome:
    """One track with its figures and curves; ``looked`` are the figures of its look-ahead."""
    figures = {
        "look_ahead": look_ahead_rmse(looked),
        **tracker_metrics(watch.flight, made, errors),
        **_watched(watch, entry, made),
    }
    sensors = sensors_of(watch, entry.sensors)
    curves = error_curves(watch.flight, sensors, made, errors)
    contrasted = any(entry.name in (one.of, one.against) for one in watch.prepared.scenario.contrasts)
    squares = {**squared_errors(watch.flight, made, errors), "look_ahead": looked} if contrasted else None
    if squares is not None and len(watch.parts) > 1:
        squares = filed(squares)
    return Outcome(made, curves, figures, squares=squares)


def judged_by_plots(watch: Watch, entry: Entry, made: Track, figures: dict[str, Any]) -> Outcome:
    """One track with its figures and curves where no truth is known."""
    curves = curves_without_truth(watch.flight, sensors_of(watch, entry.sensors), made)
    return Outcome(made._replace(cov=made.cov.astype(np.float32)), curves, figures | _watched(watch, entry, made))


def with_rollout(watch: Watch, judged: Outcome, rolling: Track, own: Errors, plots: Errors) -> Outcome:
    """What was found of a tracker with its figures in the roll-out: a phase of its own, not in the others."""
    whole = watch.flight.whole
    errors = TrackerErrors(truth_at(whole, rolling.time), own, plots)
    figures = _with_phase(judged.figures, tracker_metrics(whole, rolling, errors))
    squares = judged.squares
    if squares is not None:
        after = squared_errors(whole, rolling, errors)
        squares = _with_phase(squares, filed(after) if len(watch.parts) > 1 else after)
    return judged._replace(figures=figures, rollout=rolling, squares=squares)


def _with_phase(tables: dict[str, Any], rolling: dict[str, Any]) -> dict[str, Any]:
    """Tables of a tracker with what another has of the roll-out."""
    own = {phase: table for phase, table in rolling["by_phase"].items() if phase == ROLLOUT}
    return {**tables, "by_phase": {**tables["by_phase"], **own}}


def _watched(watch: Watch, entry: Entry, made: Track) -> dict[str, Any]:
    """What tests on a track found."""
    seen = CONFORMANCE.watch(entry.tracker, made)
    return {
        "conformance": conformance.figures(seen, watch.prepared.departure, watch.flight.is_recorded),
        "monitor": monitoring.figures(made, watch.prepared.fault(entry.sensors)),
        **skipped(made),
    }
