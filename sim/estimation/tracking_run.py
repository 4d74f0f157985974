"""track(): every tracker of a scenario on the same flight and the same measurements, judged in comparison channels."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sim.errors import ScenarioError
from sim.estimation import prior as components
from sim.estimation.batching import alike, apart, as_one, repeated
from sim.estimation.look_ahead import LookAhead
from sim.estimation.setup import adopt, build, chart_height, listened
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.metrics import conformance
from sim.metrics.tracker import tracker_metrics
from sim.observation.record import SensorRecord, measurements
from sim.scenario.model import TrackerChoice
from sim.workers.helper_process import ALONE, SecondProcess
from tracking.conformance import CONFORMANCE
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.track import Measurements, Track, TrackerError, believed, follow, modes_of, stepped
from tracking.track import track as run_tracker


class Tracked(NamedTuple):
    """One tracker's record and how it was set up."""

    track: Track
    measurements: Measurements
    law_from: str | None

    def arrays(self, name: str) -> dict[str, np.ndarray]:
        """For tracks.npz: all draws in single precision (a millimetre), the whole covariance for draw 0."""
        track = self.track
        cov = track.cov if track.cov.ndim == 4 else track.cov[..., None]
        with np.errstate(invalid="ignore"):  # a lost track is a result
            sigma = np.sqrt(np.einsum("kiin->kin", cov))
        arrays = {
            f"{name}.time_s": track.time,
            f"{name}.channels": np.array(track.channels),
            f"{name}.mean": track.mean.astype(np.float32),
            f"{name}.sigma": sigma.astype(np.float32),
            f"{name}.cov_of_draw_0": cov[..., 0],
        }
        if self.track.model_probabilities is not None:
            arrays[f"{name}.model_probabilities"] = self.track.model_probabilities
        return arrays


def track(
    prepared: Prepared,
    flight: Flight,
    records: dict[str, SensorRecord],
    own: dict[str, Any],
    number: int = 0,
    second: SecondProcess = ALONE,
) -> tuple[dict[str, Tracked], dict[str, Any]]:
    """Run the trackers of a scenario, and ``own`` trackers of the caller, over one recorded flight.

    Returns the records and the figures of metrics.json. A tracker sees measurements, the law it is told and the
    route; never the active leg, the phase or the true motion. A second process takes a part of the scenario's own.
    """
    figures: dict[str, Any] = {}
    choices: dict[str, tuple[str, tuple[str, ...], TrackerChoice | None]] = {
        name: (choice.kind, choice.sensors, choice) for name, choice in prepared.scenario.trackers.items()
    }
    choices |= {name: ("own", listened(prepared, name, tracker, records), None) for name, tracker in own.items()}
    heard = {  # what arrives after the flight comes too late
        sensors: _between(measurements(records, sensors), -math.inf, float(flight.time[-1]))
        for sensors in dict.fromkeys(sensors for _, sensors, _ in choices.values())
    }
    entries: list[Entry] = []
    for name, (kind, sensors, choice) in choices.items():
        tracker, law_from = (
            (adopt(prepared, own[name], sensors), None) if choice is None else build(prepared, name, choice)
        )
        figures[name] = {"kind": kind, "law_from": law_from, "overall": {}, "by_phase": {}, "conformance": None}
        start = begins(prepared, name, sensors, heard[sensors], flight)
        if start is not None:  # otherwise never in sight: n/a, not an error
            handover = None if choice is None else choice.handover
            entries.append(Entry(name, tracker, law_from, sensors, start, handover))
    tracked: dict[str, Tracked] = {}
    since = {
        (sensors, start): _between(heard[sensors], start, math.inf)
        for sensors, start in dict.fromkeys((entry.sensors, entry.start) for entry in entries)
    }
    groups = sorted(_twins(entries), key=lambda twins: (twins[0].name in own, -_size(twins)))
    calls = [(prepared, flight, records, since[twins[0].sensors, twins[0].start], twins, number) for twins in groups]
    ours = [call for call, twins in zip(calls, groups, strict=True) if twins[0].name not in own]
    results = second.shared(_followed, ours) + [_followed(*call) for call in calls[len(ours) :]]
    for call, result in zip(calls, results, strict=True):
        for entry, (followed, figure) in zip(call[4], result, strict=True):
            tracked[entry.name] = Tracked(followed, call[3], entry.law_from)
            figures[entry.name] |= figure
    return {name: tracked[name] for name in choices if name in tracked}, figures


class Entry(NamedTuple):
    """A tracker that has something to track."""

    name: str
    tracker: Any
    law_from: str | None
    sensors: tuple[str, ...]
    start: float  # s
    handover: str | None


def _followed(
    prepared: Prepared,
    flight: Flight,
    records: dict[str, SensorRecord],
    record: Measurements,
    twins: list[Entry],
    number: int,
) -> list[tuple[Track, dict[str, Any]]]:
    """What trackers that run as one made of a record, and their figures."""
    first = twins[0]
    prior = _prior(prepared, flight, records, first.name, first.tracker, first.start, number)
    watched = {sensor: prepared.scenario.sensors[sensor] for sensor in first.sensors}
    trackers = [entry.tracker for entry in twins]
    ahead = LookAhead(trackers, flight, record.arrival, watched)
    one = as_one(trackers, record.z.shape[2])
    try:
        tracks = apart(run_tracker(one, *repeated(record, prior, len(twins)), first.start, ahead), len(twins))
        looks = ahead.figures()
    except TrackerError as error:
        raise ScenarioError(f"[trackers.{first.name}] {error}") from error
    found = []
    for entry, followed, looked in zip(twins, tracks, looks, strict=True):
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
            judged = tracker_metrics(flight, watched, chart_height(prepared), followed, record)
            seen = CONFORMANCE.watch(entry.tracker, followed)
            judged["conformance"] = conformance.figures(seen, prepared.departure)
            # covariances are most of a run's memory, and only figures still read them
            light = followed._replace(cov=followed.cov.astype(np.float32))
        found.append((light, {"look_ahead": looked, **judged}))
    return found


def _twins(entries: list[Entry]) -> list[list[Entry]]:
    """The entries, those together that can run as one."""
    groups: list[list[Entry]] = []
    for entry in entries:
        for group in groups:
            same = group[0].sensors == entry.sensors and group[0][4:] == entry[4:]
            if same and alike(group[0].tracker, entry.tracker):
                group.append(entry)
                break
        else:
            groups.append([entry])
    return groups


def _size(twins: list[Entry]) -> int:
    """How many hypotheses run as one: the longest work goes first where it is shared."""
    return sum(len(modes_of(entry.tracker)) or 1 for entry in twins)


def begins(
    prepared: Prepared, name: str, sensors: tuple[str, ...], record: Measurements, flight: Flight
) -> float | None:
    """When a track begins, s: with the first look at the place, or with the flight where the autopilot flies on it.

    A downlink says how the aircraft moves, not where it is, and begins no track. None = no sensor ever saw anything.
    """
    looking = tuple(s for s in sensors if not hasattr(prepared.scenario.sensors[s], "load_factor_sigma"))
    rows = [i for i, channel in enumerate(record.channels) if channel.rpartition(".")[0] in looking]
    seen = np.isfinite(record.z[:, rows]).any(axis=(1, 2)) if len(record.time) else np.zeros(0, bool)
    if not seen.any():
        return None
    if prepared.scenario.autopilot.navigation == name:
        return float(flight.time[0])
    return float(record.arrival[seen].min())


def _between(record: Measurements, first: float, last: float) -> Measurements:
    """What arrives from ``first`` to ``last`` (s)."""
    kept = (record.arrival >= first) & (record.arrival <= last)
    candidates = None if record.candidates is None else record.candidates[kept]
    return Measurements(
        record.channels, record.time[kept], record.arrival[kept], record.z[kept], record.R[kept], candidates
    )


def _prior(
    prepared: Prepared,
    flight: Flight,
    records: dict[str, SensorRecord],
    name: str,
    tracker: Any,
    start: float,
    number: int,
) -> Gaussian:
    """What is known when a track begins: the estimate that is handed over, else the truth with an error."""
    choice = prepared.scenario.trackers.get(name)
    if choice is not None and choice.handover is not None:
        handed = _handed_over(prepared, flight, records, choice.handover, tracker.channels, start, number)
        if handed is not None:
            return handed
    draws = next(iter(records.values())).z.shape[2]
    sensors, seed = prepared.scenario.sensors, prepared.scenario.seed
    try:
        return components.prior(flight, sensors, tracker.channels, start, seed, number, draws)
    except KeyError as error:
        raise ScenarioError(f"[trackers.{name}] nothing is known of its component {error} when it begins") from None


def _handed_over(
    prepared: Prepared,
    flight: Flight,
    records: dict[str, SensorRecord],
    name: str,
    wanted: tuple[str, ...],
    start: float,
    number: int,
) -> Gaussian | None:
    """What tracker ``name`` believes at ``start`` by all that it heard before; None = it had heard nothing yet."""
    choice = prepared.scenario.trackers[name]
    tracker, _ = build(prepared, name, choice)
    record = _between(measurements(records, choice.sensors), -math.inf, math.nextafter(start, -math.inf))
    begun = begins(prepared, name, choice.sensors, record, flight)
    if begun is None:
        return None
    prior = _prior(prepared, flight, records, name, tracker, begun, number)
    try:
        *_, last = follow(tracker, _between(record, begun, math.inf), prior, start=begun)
        estimate = believed(tracker, stepped(tracker, last.state, start - last.time)[0])
    except TrackerError as error:
        raise ScenarioError(f"[trackers.{name}] {error}") from error
    mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
    rows = [tracker.channels.index(component) for component in wanted]
    return Gaussian(mean[rows], cov[np.ix_(rows, rows)])
