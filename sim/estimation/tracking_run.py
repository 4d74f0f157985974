"""track(): every tracker of a scenario on the same flight and measurements, compared with the truth."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from sim.errors import ScenarioError
from sim.estimation.batching import can_batch, repeat_runs, runs_of, split_track, stack_trackers
from sim.estimation.look_ahead import LookAhead, instants_of
from sim.estimation.many_draws.collected import CollectedTrack, joined_errors
from sim.estimation.own_trackers import set_up
from sim.estimation.recorded.judged import judge
from sim.estimation.setup import build, height_profile
from sim.estimation.tracked.beginning import begins_by, prior_of
from sim.estimation.tracked.outcome import Outcome, Tracked, judged_by_plots, judged_by_truth, with_rollout
from sim.estimation.tracked.parts import Found, collect, errors_of_plots
from sim.estimation.tracked.watch import (
    Entry,
    SetUp,
    Since,
    Watch,
    arrived_at,
    between,
    first_taken,
    looked_at,
    parts_of,
    sensors_of,
    taken_in,
)
from sim.estimation.without_truth.judged import figures_from_plots, with_agreement
from sim.estimation.without_truth.places import places
from sim.estimation.without_truth.predicted_plots import PredictedPlots
from sim.flight.interpolation import truth_at
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.metrics.tracker import TrackerErrors, skipped
from sim.observation.record import SensorRecord, measurements
from sim.workers.sharing import ALONE, current
from tracking.track import Measurements, TrackerError, is_recorded, modes_of
from tracking.track import track as run_tracker


def track(
    prepared: Prepared,
    flight: Flight,
    records: dict[str, SensorRecord],
    own: Mapping[str, Any],
    number: int = 0,
) -> tuple[dict[str, Tracked], dict[str, Any]]:
    """Run the trackers of a scenario, and ``own`` trackers of the caller, over one recorded flight.

    Returns the records and the figures of metrics.json. A tracker sees measurements, its assumed law and the route;
    never the active leg, the phase or the true motion.
    """
    figures: dict[str, Any] = {}
    of_scenario = list(_of_scenario(prepared))
    parts = parts_of(flight, records)
    watch = Watch(prepared, flight, records, {one.name: one.tracker for one in of_scenario}, number, parts)
    every = {one.name: one for one in (*of_scenario, *_of_caller(_watched_by(prepared, records), own))}
    once = len(parts) == 1  # what all trackers of the same sensors share is put together once
    arrived = {one.sensors: arrived_at(watch, one.sensors, parts[0]) for one in every.values()} if once else {}
    entries: list[Entry] = []
    tracked: dict[str, Tracked] = {}
    for one in every.values():
        figures[one.name] = {
            "kind": one.kind, "law_from": one.law_from, "overall": {}, "by_phase": {}, "conformance": None,
            "monitor": None,
        }  # fmt: skip
        if is_recorded(one.tracker):
            if one.tracker.flight == number:
                tracked[one.name], found = _brought(watch, one, arrived.get(one.sensors))
                figures[one.name] |= found
            continue
        begun = [begins_by(watch, one, arrived.get(one.sensors), chosen) for chosen in parts]
        start = min((first for first in begun if first is not None), default=None)
        if start is not None:  # otherwise never in sight: n/a, not an error
            entries.append(Entry(*one, start))
    since = {
        (sensors, start): between(arrived[sensors], first_taken(flight, start), math.inf)
        for sensors, start in dict.fromkeys((entry.sensors, entry.start) for entry in entries)
        if once
    }
    alike = _groups(entries) if once else [[entry] for entry in entries]  # of many draws side by side gains nothing
    groups = sorted(alike, key=lambda group: (group[0].name in own, -_size(group)))
    ours = [(group,) for group in groups if group[0].name not in own]
    sharing = current() if once else ALONE  # a second process would hold a second copy of the records
    results = sharing.in_order(run_group, ours, (watch, since))
    results += [run_group(watch, since, group) for group in groups[len(ours) :]]
    for group, result in zip(groups, results, strict=True):
        record = taken_in(watch, since, group[0], parts[0] if once else slice(0, 1))
        for entry, outcome in zip(group, result, strict=True):
            until = between(record, -math.inf, float(flight.time[-1]))
            tracked[entry.name] = Tracked(
                entry.tracker, entry.law_from, until, outcome.track, outcome.curves, outcome.rollout, outcome.squares
            )
            figures[entry.name] |= outcome.figures
    if not flight.known:
        known = {entry.name: sensors_of(watch, entry.sensors) for entry in entries}
        with_agreement(figures, {name: (tracked[name].track, sensors) for name, sensors in known.items()})
    return {name: tracked[name] for name in every if name in tracked}, figures


def _brought(watch: Watch, one: SetUp, arrived: Measurements | None) -> tuple[Tracked, dict[str, Any]]:
    """A track that was made elsewhere, and its figures; ``arrived`` are the looks of its sensors, if they are there."""
    record = arrived_at(watch, one.sensors, slice(None)) if arrived is None else arrived
    flight, sensors = watch.flight, sensors_of(watch, one.sensors)
    if not flight.known:
        raise ScenarioError(
            f"[trackers.{one.name}] a recorded track is judged against a flight, and [record] names none"
        )
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        rows, chart = one.tracker.estimates(flight.utc), height_profile(watch.prepared)
        found = judge(one.name, one.tracker.channels, rows, flight, sensors, chart, record)
    until = between(record, -math.inf, float(flight.time[-1]))
    own = {**found.figures, **skipped(found.track)}
    return Tracked(one.tracker, None, until, found.track, found.curves, found.rollout, found.squares), own


def _of_scenario(prepared: Prepared) -> Iterator[SetUp]:
    for name, choice in prepared.scenario.trackers.items():
        yield SetUp(name, choice.kind, *build(prepared, name, choice), choice.sensors, choice.handover)


def _watched_by(prepared: Prepared, records: dict[str, SensorRecord]) -> Prepared:
    """As if the sensors that have a record were all."""
    sensors = {name: sensor for name, sensor in prepared.scenario.sensors.items() if name in records}
    return dataclasses.replace(prepared, scenario=dataclasses.replace(prepared.scenario, sensors=sensors))


def _of_caller(prepared: Prepared, own: Mapping[str, Any]) -> Iterator[SetUp]:
    """Trackers of the caller, with what they are to be given."""
    for name, given in own.items():
        made = set_up(prepared, name, given)
        yield SetUp(name, "own", made.tracker, made.law_from, made.sensors, None)


def run_group(watch: Watch, since: Since, group: list[Entry]) -> list[Outcome]:
    """Tracks and figures of trackers that run as one batch; ``since`` has their record, where draws go in one part."""
    flight, first = watch.flight, group[0]
    begun = prior_of(watch, first, first.tracker, first.start)
    sensors = sensors_of(watch, first.sensors)
    trackers = [entry.tracker for entry in group]
    draws = watch.parts[-1].stop
    found = [Found(CollectedTrack(), [], CollectedTrack(), []) for _ in group]
    ahead: Any = None
    try:
        for chosen in watch.parts:  # a run's estimate depends on no other, but memory does
            some = taken_in(watch, since, first, chosen)
            if chosen == watch.parts[0]:  # a few draws look ahead, and they are among the first
                ahead = _looking_ahead(watch, first, trackers, some)
            one, count = stack_trackers(trackers, some.z.shape[2]), some.z.shape[2] * len(group)
            shown = ahead if chosen == watch.parts[0] else None
            priors = runs_of(begun, chosen, draws)
            made = run_tracker(one, *repeat_runs(some, priors, len(group)), first.start, shown)
            if made.mean.shape[2] != count:
                raise TrackerError(f"estimate gives {made.mean.shape[2]} draws, not {count}")
            for into, own in zip(found, split_track(made, len(group)), strict=True):
                collect(into, flight, sensors, own)
        looks = ahead.looks()
    except TrackerError as error:
        raise ScenarioError(f"[trackers.{first.name}] {error}") from error
    if not flight.known:
        tracks = [one.track.whole() for one in found]
        return [
            judged_by_plots(watch, entry, made, figures_from_plots(made, entry.start, ahead.plots, predicted))
            for entry, made, predicted in zip(group, tracks, looks, strict=True)
        ]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
        errors = [(joined_errors(one.errors), joined_errors(one.rolling_errors)) for one in found]
        plots, rolling_plots = errors_of_plots(watch, looked_at(watch, since, first), sensors, *errors[0])
        judged = []
        for entry, gathered, (against, rolling), looked in zip(group, found, errors, looks, strict=True):
            whole = gathered.track.whole()
            off = TrackerErrors(truth_at(flight, whole.time), against, plots)
            judged.append(judged_by_truth(watch, entry, whole, off, looked))
            if rolling:
                judged[-1] = with_rollout(watch, judged[-1], gathered.rolling.whole(), rolling, rolling_plots)
        return judged


def _looking_ahead(watch: Watch, first: Entry, trackers: list[Any], record: Measurements) -> Any:
    """What is shown the epochs of batched trackers, and predicts from some of them."""
    flight, sensors = watch.flight, sensors_of(watch, first.sensors)
    if flight.known:
        return LookAhead(trackers, flight, instants_of(flight, watch.records), record.arrival, sensors)
    seen = places(watch.prepared, sensors, measurements(watch.records, first.sensors))
    return PredictedPlots(trackers, record.arrival, seen)


def _groups(entries: list[Entry]) -> list[list[Entry]]:
    """The entries, those together that can run as one."""
    groups: list[list[Entry]] = []
    for entry in entries:
        for group in groups:
            same = group[0][4:] == entry[4:]  # sensors, handover and start
            if same and can_batch(group[0].tracker, entry.tracker):
                group.append(entry)
                break
        else:
            groups.append([entry])
    return groups


def _size(group: list[Entry]) -> int:
    """How many hypotheses run as one: the longest work goes first where it is shared."""
    return sum(len(modes_of(entry.tracker)) or 1 for entry in group)
