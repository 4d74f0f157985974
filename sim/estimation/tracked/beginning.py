"""When a track begins, and with what."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim.errors import ScenarioError
from sim.estimation.prior import prior
from sim.estimation.tracked.watch import Entry, SetUp, Watch, arrived_at, between, first_taken, sensors_of
from sim.estimation.without_truth.two_plots import two_plot_start
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.observation.record import measurements
from sim.observation.sensor import quantity_of
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.track import Measurements, TrackerError, believed, follow, stepped


def begins_by(watch: Watch, one: SetUp, arrived: Measurements | None, chosen: slice) -> float | None:
    """When a track of some draws begins, s; None = it never does. ``arrived`` is what they measured, where known."""
    record = arrived_at(watch, one.sensors, chosen) if arrived is None else arrived
    seen = between(record, -math.inf, float(watch.flight.time[-1]))
    if watch.flight.known:
        return begins(watch.prepared, one.name, one.sensors, seen, watch.flight)
    return _begun_by_plots(watch, one, seen)


def begins(
    prepared: Prepared, name: str, sensors: tuple[str, ...], record: Measurements, flight: Flight
) -> float | None:
    """When a track begins, s: with the first look at the place, or with the flight where the autopilot flies on it.

    A sensor that says how the aircraft moves and not where it is, such as a downlink, begins no track. None = no place
    sensor ever saw anything.
    """
    known = prepared.scenario.sensors
    place_sensors = {s for s in sensors if any(quantity_of(channel).place for channel in known[s].channels)}
    rows = [i for i, channel in enumerate(record.channels) if channel.rpartition(".")[0] in place_sensors]
    seen = np.isfinite(record.z[:, rows]).any(axis=(1, 2)) if len(record.time) else np.zeros(0, bool)
    if not seen.any():
        return None
    if prepared.scenario.autopilot.navigation == name:
        return float(flight.time[0])
    return float(record.arrival[seen].min())


def _begun_by_plots(watch: Watch, one: SetUp, record: Measurements) -> float:
    """When a track begins of which only plots are known, s: with the second of them.

    Raises ``ScenarioError`` for fewer plots than it takes.
    """
    begun = two_plot_start(watch.prepared, one.name, sensors_of(watch, one.sensors), record, one.tracker.channels)
    if begun is None or not (record.arrival > begun.time).any():
        raise ScenarioError(
            f"[trackers.{one.name}] a track without truth begins from two plots and is judged by those after, and "
            f"{', '.join(one.sensors)} gave {len(record.time)}"
        )
    return begun.time


def prior_of(watch: Watch, one: SetUp | Entry, tracker: Any, start: float) -> Gaussian:
    """What is known when a track begins: the estimate that is handed over, else the truth with an error.

    Without a truth it is what two plots say.
    """
    scenario = watch.prepared.scenario
    if one.handover is not None:
        handed = _handed_over(watch, one.handover, tracker.channels, start)
        if handed is not None:
            return handed
    if not watch.flight.known:
        seen = measurements(watch.records, one.sensors)
        begun = two_plot_start(watch.prepared, one.name, sensors_of(watch, one.sensors), seen, tracker.channels)
        assert begun is not None, "a track begins with its second plot"
        return begun.prior
    draws = next(iter(watch.records.values())).z.shape[2]
    try:
        return prior(watch.flight, scenario.sensors, tracker.channels, start, scenario.seed, watch.number, draws)
    except KeyError as error:
        raise ScenarioError(f"[trackers.{one.name}] nothing is known of its component {error} when it begins") from None


def _handed_over(watch: Watch, name: str, wanted: tuple[str, ...], start: float) -> Gaussian | None:
    """The estimate of tracker ``name`` at ``start`` from all measurements before; None = it had none yet.

    Without a truth those at ``start`` are in it, because the track that it begins takes in none of them.
    """
    tracker, choice = watch.trackers[name], watch.prepared.scenario.trackers[name]
    one = SetUp(name, choice.kind, tracker, None, choice.sensors, choice.handover)
    last = math.nextafter(first_taken(watch.flight, start), -math.inf)
    record = between(measurements(watch.records, choice.sensors), -math.inf, last)
    if watch.flight.known:
        begun = begins(watch.prepared, name, choice.sensors, record, watch.flight)
    else:
        found = two_plot_start(watch.prepared, name, sensors_of(watch, choice.sensors), record, tracker.channels)
        begun = None if found is None or not (record.arrival > found.time).any() else found.time
    if begun is None:
        return None
    before = prior_of(watch, one, tracker, begun)
    try:
        *_, last_epoch = follow(
            tracker, between(record, first_taken(watch.flight, begun), math.inf), before, start=begun
        )
        estimate = believed(tracker, stepped(tracker, last_epoch.state, start - last_epoch.time)[0])
    except TrackerError as error:
        raise ScenarioError(f"[trackers.{name}] {error}") from error
    mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
    rows = [tracker.channels.index(component) for component in wanted]
    return Gaussian(mean[rows], cov[np.ix_(rows, rows)])
