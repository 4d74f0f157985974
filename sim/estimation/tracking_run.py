"""track(): every tracker of a scenario on the same flight and measurements, compared with the truth."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from sim.errors import ScenarioError
from sim.estimation.batching import can_batch, repeat_runs, runs_of, split_track, stack_trackers
from sim.estimation.look_ahead import LookAhead, Looks, instants_of, look_ahead_rmse
from sim.estimation.many_draws.collected import CollectedTrack, filed, joined_errors
from sim.estimation.own_trackers import set_up
from sim.estimation.prior import prior
from sim.estimation.recorded.judged import judge
from sim.estimation.setup import build, height_profile
from sim.estimation.without_truth.judged import figures_from_plots, with_agreement
from sim.estimation.without_truth.places import places
from sim.estimation.without_truth.predicted_plots import PredictedPlots
from sim.estimation.without_truth.two_plots import two_plot_start
from sim.flight.interpolation import truth_at
from sim.flight.outcomes import ROLLOUT
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.metrics import conformance
from sim.metrics.alarms import monitoring
from sim.metrics.comparison import Compared
from sim.metrics.contrasts.squares import squared_errors
from sim.metrics.error_curves import ErrorCurves, curves_without_truth, error_curves
from sim.metrics.tracker import TrackerErrors, looked_for, plot_errors, skipped, tracker_errors, tracker_metrics
from sim.observation.record import SensorRecord, measurements, of_draws
from sim.observation.sensor import quantity_of
from sim.scenario.budget import TOGETHER
from sim.workers.sharing import ALONE, current
from tracking.conformance import CONFORMANCE
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.track import Measurements, Track, TrackerError, believed, chunks, follow, is_recorded, modes_of, stepped
from tracking.track import track as run_tracker


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


class Watch(NamedTuple):
    """A flight with the records of its sensors: what all its trackers share."""

    prepared: Prepared
    flight: Flight
    records: dict[str, SensorRecord]
    trackers: dict[str, Any]  # of the scenario, which may hand over to each other
    number: int  # of the flight
    parts: tuple[slice, ...]  # of the draws, which go through a tracker one after the other


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
    parts = _parts(flight, records)
    watch = Watch(prepared, flight, records, {one.name: one.tracker for one in of_scenario}, number, parts)
    every = {one.name: one for one in (*of_scenario, *_of_caller(_watched_by(prepared, records), own))}
    once = len(parts) == 1  # what all trackers of the same sensors share is put together once
    arrived = {one.sensors: _arrived(watch, one.sensors, parts[0]) for one in every.values()} if once else {}
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
        begun = [_begins(watch, one, arrived.get(one.sensors), chosen) for chosen in parts]
        start = min((first for first in begun if first is not None), default=None)
        if start is not None:  # otherwise never in sight: n/a, not an error
            entries.append(Entry(*one, start))
    since = {
        (sensors, start): _between(arrived[sensors], _first(flight, start), math.inf)
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
        record = _record(watch, since, group[0], parts[0] if once else slice(0, 1))
        for entry, outcome in zip(group, result, strict=True):
            until = _between(record, -math.inf, float(flight.time[-1]))
            tracked[entry.name] = Tracked(
                entry.tracker, entry.law_from, until, outcome.track, outcome.curves, outcome.rollout, outcome.squares
            )
            figures[entry.name] |= outcome.figures
    if not flight.known:
        known = {entry.name: _sensors_of(watch, entry.sensors) for entry in entries}
        with_agreement(figures, {name: (tracked[name].track, sensors) for name, sensors in known.items()})
    return {name: tracked[name] for name in every if name in tracked}, figures


def _brought(watch: Watch, one: SetUp, arrived: Measurements | None) -> tuple[Tracked, dict[str, Any]]:
    """A track that was made elsewhere, and its figures; ``arrived`` are the looks of its sensors, if they are there."""
    record = _arrived(watch, one.sensors, slice(None)) if arrived is None else arrived
    flight, sensors = watch.flight, _sensors_of(watch, one.sensors)
    if not flight.known:
        raise ScenarioError(
            f"[trackers.{one.name}] a recorded track is judged against a flight, and [record] names none"
        )
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        rows, chart = one.tracker.estimates(flight.utc), height_profile(watch.prepared)
        found = judge(one.name, one.tracker.channels, rows, flight, sensors, chart, record)
    until = _between(record, -math.inf, float(flight.time[-1]))
    own = {**found.figures, **skipped(found.track)}
    return Tracked(one.tracker, None, until, found.track, found.curves, found.rollout, found.squares), own


class SetUp(NamedTuple):
    """A tracker, its assumed law's origin and its sensors."""

    name: str
    kind: str
    tracker: Any
    law_from: str | None
    sensors: tuple[str, ...]
    handover: str | None


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


class Entry(NamedTuple):
    """A tracker that has measurements, and when its track begins."""

    name: str
    kind: str
    tracker: Any
    law_from: str | None
    sensors: tuple[str, ...]
    handover: str | None
    start: float  # s


class Outcome(NamedTuple):
    """The track and figures of one tracker, small enough to be sent between processes."""

    track: Track
    curves: ErrorCurves
    figures: dict[str, Any]
    rollout: Track | None = None
    squares: dict[str, Any] | None = None


Since = dict[tuple[tuple[str, ...], float], Measurements]
"""What trackers take in, by their sensors and the time of their start."""


def run_group(watch: Watch, since: Since, group: list[Entry]) -> list[Outcome]:
    """Tracks and figures of trackers that run as one batch; ``since`` has their record, where draws go in one part."""
    flight, first = watch.flight, group[0]
    begun = _prior(watch, first, first.tracker, first.start)
    sensors = _sensors_of(watch, first.sensors)
    trackers = [entry.tracker for entry in group]
    draws = watch.parts[-1].stop
    found = [Found(CollectedTrack(), [], CollectedTrack(), []) for _ in group]
    ahead: Any = None
    try:
        for chosen in watch.parts:  # a run's estimate depends on no other, but memory does
            some = _record(watch, since, first, chosen)
            if chosen == watch.parts[0]:  # a few draws look ahead, and they are among the first
                ahead = _looking_ahead(watch, first, trackers, some)
            one, count = stack_trackers(trackers, some.z.shape[2]), some.z.shape[2] * len(group)
            shown = ahead if chosen == watch.parts[0] else None
            priors = runs_of(begun, chosen, draws)
            made = run_tracker(one, *repeat_runs(some, priors, len(group)), first.start, shown)
            if made.mean.shape[2] != count:
                raise TrackerError(f"estimate gives {made.mean.shape[2]} draws, not {count}")
            for into, own in zip(found, split_track(made, len(group)), strict=True):
                _collect(into, flight, sensors, own)
        looks = ahead.looks()
    except TrackerError as error:
        raise ScenarioError(f"[trackers.{first.name}] {error}") from error
    if not flight.known:
        tracks = [one.track.whole() for one in found]
        return [
            _judged_by_plots(watch, entry, made, figures_from_plots(made, entry.start, ahead.plots, predicted))
            for entry, made, predicted in zip(group, tracks, looks, strict=True)
        ]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
        errors = [(joined_errors(one.errors), joined_errors(one.rolling_errors)) for one in found]
        plots, rolling_plots = _plots(watch, _looked_at(watch, since, first), sensors, *errors[0])
        judged = []
        for entry, gathered, (against, rolling), looked in zip(group, found, errors, looks, strict=True):
            whole = gathered.track.whole()
            off = TrackerErrors(truth_at(flight, whole.time), against, plots)
            judged.append(_judged(watch, entry, whole, off, looked))
            if rolling:
                judged[-1] = _with_rollout(watch, judged[-1], gathered.rolling.whole(), rolling, rolling_plots)
        return judged


Errors = dict[str, Compared]
"""By comparison channel."""


class Found(NamedTuple):
    """What the parts of the draws gave for one tracker."""

    track: CollectedTrack  # to the end of the flight
    errors: list[Errors]  # of each part
    rolling: CollectedTrack  # after the end of the flight
    rolling_errors: list[Errors]


def _collect(found: Found, flight: Flight, sensors: dict[str, Any], made: Track) -> None:
    """Take in the track of some draws, with its errors where a truth is known."""
    if not flight.known:
        found.track.add(made)
        return
    before, rolling = _parted(made, float(flight.time[-1]))
    for part, whole, into, errors in (
        (before, flight, found.track, found.errors),
        (rolling, flight.whole, found.rolling, found.rolling_errors),
    ):
        if part is not None:
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
                errors.append(tracker_errors(whole, sensors, part, {}).estimates)
                # covariances are most of a run's memory, and only maps still read them
                into.add(part._replace(cov=part.cov.astype(np.float32)))


def _plots(
    watch: Watch, record: Measurements, sensors: dict[str, Any], errors: Errors, rolling: Errors
) -> tuple[Errors, Errors]:
    """Errors of what trackers were given, to the end of the flight and after it, as far as theirs are compared."""
    flight, chart = watch.flight, height_profile(watch.prepared)
    end = float(flight.time[-1])
    until, after = _between(record, -math.inf, end), _between(record, math.nextafter(end, math.inf), math.inf)
    plots = looked_for(errors, plot_errors(flight, sensors, chart, until))
    return plots, looked_for(rolling, plot_errors(flight.whole, sensors, chart, after)) if rolling else {}


def _looking_ahead(watch: Watch, first: Entry, trackers: list[Any], record: Measurements) -> Any:
    """What is shown the epochs of batched trackers, and predicts from some of them."""
    flight, sensors = watch.flight, _sensors_of(watch, first.sensors)
    if flight.known:
        return LookAhead(trackers, flight, instants_of(flight, watch.records), record.arrival, sensors)
    seen = places(watch.prepared, sensors, measurements(watch.records, first.sensors))
    return PredictedPlots(trackers, record.arrival, seen)


def _parted(track: Track, end: float) -> tuple[Track, Track | None]:
    """A track to the end of the flight, and after it; None where it has nothing after it."""
    if not len(track.time) or track.time[-1] <= end:
        return track, None
    count = int(np.searchsorted(track.time, end, side="right"))
    before, after = ([None if part is None else part[side] for part in track[1:]] for side in (
        slice(None, count), slice(count, None)
    ))  # fmt: skip
    return Track(track.channels, *before), Track(track.channels, *after)


def joined(first: Track, second: Track) -> Track:
    """One track after another as one."""
    parts = zip(first[1:], second[1:], strict=True)
    return Track(first.channels, *(None if a is None or b is None else np.concatenate((a, b)) for a, b in parts))


def _with_rollout(watch: Watch, judged: Outcome, rolling: Track, own: Errors, plots: Errors) -> Outcome:
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


def _judged(watch: Watch, entry: Entry, made: Track, errors: TrackerErrors, looked: Looks) -> Outcome:
    """One track with its figures and curves; ``looked`` are the figures of its look-ahead."""
    figures = {
        "look_ahead": look_ahead_rmse(looked),
        **tracker_metrics(watch.flight, made, errors),
        **_watched(watch, entry, made),
    }
    sensors = _sensors_of(watch, entry.sensors)
    curves = error_curves(watch.flight, sensors, made, errors)
    contrasted = any(entry.name in (one.of, one.against) for one in watch.prepared.scenario.contrasts)
    squares = {**squared_errors(watch.flight, made, errors), "look_ahead": looked} if contrasted else None
    if squares is not None and len(watch.parts) > 1:
        squares = filed(squares)
    return Outcome(made, curves, figures, squares=squares)


def _judged_by_plots(watch: Watch, entry: Entry, made: Track, figures: dict[str, Any]) -> Outcome:
    """One track with its figures and curves where no truth is known."""
    curves = curves_without_truth(watch.flight, _sensors_of(watch, entry.sensors), made)
    return Outcome(made._replace(cov=made.cov.astype(np.float32)), curves, figures | _watched(watch, entry, made))


def _watched(watch: Watch, entry: Entry, made: Track) -> dict[str, Any]:
    """What tests on a track found."""
    seen = CONFORMANCE.watch(entry.tracker, made)
    return {
        "conformance": conformance.figures(seen, watch.prepared.departure, watch.flight.is_recorded),
        "monitor": monitoring.figures(made, watch.prepared.fault(entry.sensors)),
        **skipped(made),
    }


def _sensors_of(watch: Watch, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: watch.prepared.scenario.sensors[name] for name in names}


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


def _parts(flight: Flight, records: dict[str, SensorRecord]) -> tuple[slice, ...]:
    """The draws that go through a tracker at once; without a truth, all."""
    draws = next((record.z.shape[2] for record in records.values()), 0)
    return tuple(chunks(draws, TOGETHER)) if flight.known and draws else (slice(0, draws),)


def _arrived(watch: Watch, sensors: tuple[str, ...], chosen: slice) -> Measurements:
    """What some draws of sensors measured; what would arrive after the flight and its roll-out is left out."""
    record = measurements(of_draws(watch.records, chosen), sensors)
    return _between(record, -math.inf, float(watch.flight.whole.time[-1]))


def _record(watch: Watch, since: Since, entry: Entry, chosen: slice) -> Measurements:
    """What some draws of a tracker take in, from its start on."""
    whole = since.get((entry.sensors, entry.start))
    if whole is not None:
        return whole
    return _between(_arrived(watch, entry.sensors, chosen), _first(watch.flight, entry.start), math.inf)


def _looked_at(watch: Watch, since: Since, entry: Entry) -> Measurements:
    """What all draws of a tracker take in; where that is not put together once, with the accuracies of one draw."""
    if since:
        return since[entry.sensors, entry.start]
    plain = {
        name: record._replace(R=record.R[..., 0] if record.R.ndim == 4 else record.R)
        for name, record in watch.records.items()
    }
    return _record(watch._replace(records=plain), since, entry, slice(0, watch.parts[-1].stop))


def _begins(watch: Watch, one: SetUp, arrived: Measurements | None, chosen: slice) -> float | None:
    """When a track of some draws begins, s; None = it never does. ``arrived`` is what they measured, where known."""
    record = _arrived(watch, one.sensors, chosen) if arrived is None else arrived
    seen = _between(record, -math.inf, float(watch.flight.time[-1]))
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
    begun = two_plot_start(watch.prepared, one.name, _sensors_of(watch, one.sensors), record, one.tracker.channels)
    if begun is None or not (record.arrival > begun.time).any():
        raise ScenarioError(
            f"[trackers.{one.name}] a track without truth begins from two plots and is judged by those after, and "
            f"{', '.join(one.sensors)} gave {len(record.time)}"
        )
    return begun.time


def _first(flight: Flight, start: float) -> float:
    """From when on a track takes in what arrives: two plots with which it begins are in it already."""
    return start if flight.known else math.nextafter(start, math.inf)


def _between(record: Measurements, first: float, last: float) -> Measurements:
    """What arrives from ``first`` to ``last`` (s): views, since a record is in order of arrival."""
    arrival = record.arrival
    return record.rows(
        slice(int(np.searchsorted(arrival, first, "left")), int(np.searchsorted(arrival, last, "right")))
    )


def _prior(watch: Watch, one: SetUp | Entry, tracker: Any, start: float) -> Gaussian:
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
        begun = two_plot_start(watch.prepared, one.name, _sensors_of(watch, one.sensors), seen, tracker.channels)
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
    last = math.nextafter(_first(watch.flight, start), -math.inf)
    record = _between(measurements(watch.records, choice.sensors), -math.inf, last)
    if watch.flight.known:
        begun = begins(watch.prepared, name, choice.sensors, record, watch.flight)
    else:
        found = two_plot_start(watch.prepared, name, _sensors_of(watch, choice.sensors), record, tracker.channels)
        begun = None if found is None or not (record.arrival > found.time).any() else found.time
    if begun is None:
        return None
    before = _prior(watch, one, tracker, begun)
    try:
        *_, last_epoch = follow(tracker, _between(record, _first(watch.flight, begun), math.inf), before, start=begun)
        estimate = believed(tracker, stepped(tracker, last_epoch.state, start - last_epoch.time)[0])
    except TrackerError as error:
        raise ScenarioError(f"[trackers.{name}] {error}") from error
    mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
    rows = [tracker.channels.index(component) for component in wanted]
    return Gaussian(mean[rows], cov[np.ix_(rows, rows)])
