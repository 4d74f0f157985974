"""track(): every tracker of a scenario on the same flight and the same measurements, judged in comparison channels."""

from __future__ import annotations

import bisect
import dataclasses
import math
import typing
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from sim import catalogue, channels, components
from sim.errors import ScenarioError
from sim.flight import Flight
from sim.look_ahead import LookAhead
from sim.observation import SensorRecord, measurements
from sim.parameters import GIVEN, construct
from sim.preparation import Prepared
from sim.scenario import TrackerChoice
from tracking import consistency
from tracking.association import ProbabilisticDataAssociation
from tracking.gaussian import Gaussian, Innovation, Mixture, merge
from tracking.measurement import DebiasedPolar, LinearMeasurement, Stacked
from tracking.track import Measurements, Track, Tracker, follow
from tracking.track import track as run_tracker


class Tracked(NamedTuple):
    """One tracker's record and how it was set up."""

    track: Track
    measurements: Measurements
    law_from: str | None

    def light(self) -> Tracked:
        """With covariances in single precision: they are most of a run's memory, and only figures still read them."""
        return self._replace(track=self.track._replace(cov=self.track.cov.astype(np.float32)))

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


@dataclass(frozen=True)
class AmongFalsePlots:
    """A tracker on the ground plane, fed by probabilistic data association with all plots of one radar.

    The radar's false plots lie the denser the nearer the aircraft is, so each step takes their density anew, at the
    mean place of its own plots.
    """

    tracker: Tracker
    radar: Any

    @property
    def channels(self) -> tuple[str, ...]:
        """Those of the tracker."""
        return self.tracker.channels

    @property
    def modes(self) -> tuple[str, ...]:
        """What the tracker calls its hypotheses, for the report."""
        return tuple(getattr(self.tracker, "modes", ()))

    def begin(self, prior: Gaussian) -> Any:
        """State before the first plot."""
        return self.tracker.begin(prior)

    def step(self, state: Any, dt: float, z: Any | None, R: Any | None) -> tuple[Any, Innovation | None]:
        """Predict by dt, then update with the plots z (c, 3, draws) that share R (3, 3, draws)."""
        if z is None:
            return self.tracker.step(state, dt, None, None)
        made = np.isfinite(z)
        place = np.where(made, z, 0.0).sum(axis=0) / np.maximum(made.sum(axis=0), 1)
        seen = made.any(axis=(0, 1))
        density = np.where(seen, self.radar.clutter_density(*np.where(seen, place, 1.0)), 1.0)  # any, where no plot is
        association = ProbabilisticDataAssociation(self.tracker, density, self.radar.detection)
        return association.step(state, dt, z, R)

    def estimate(self, state: Any) -> Gaussian | Mixture:
        """What the tracker believes."""
        return self.tracker.estimate(state)


def track(
    prepared: Prepared, flight: Flight, records: dict[str, SensorRecord], own: dict[str, Any], number: int = 0
) -> tuple[dict[str, Tracked], dict[str, Any]]:
    """Run the trackers of a scenario, and ``own`` trackers of the caller, over one recorded flight.

    Returns the records and the figures of metrics.json. A tracker sees measurements, the law it is told and the
    route; never the active leg, the phase or the true motion.
    """
    tracked: dict[str, Tracked] = {}
    figures: dict[str, Any] = {}
    choices = {name: (choice.kind, choice.sensors, choice) for name, choice in prepared.scenario.trackers.items()}
    places = tuple(name for name in records if _gives_place(prepared.scenario.sensors[name]))
    choices |= {
        name: ("own", places if _reads_places(tracker) else tuple(records), None) for name, tracker in own.items()
    }
    for name, (kind, sensors, choice) in choices.items():
        record = _between(measurements(records, sensors), -math.inf, float(flight.time[-1]))  # later ones come too late
        tracker, law_from = (
            (_own(prepared, own[name], sensors), None) if choice is None else build(prepared, name, choice)
        )
        figures[name] = {"kind": kind, "law_from": law_from, "overall": {}, "by_phase": {}}
        start = begins(prepared, name, sensors, record, flight)
        if start is None:
            continue  # never in sight: n/a, not an error
        record = _between(record, start, math.inf)
        prior = _prior(prepared, flight, records, name, tracker, start, number)
        watched = {sensor: prepared.scenario.sensors[sensor] for sensor in sensors}
        ahead = LookAhead(tracker, flight, record.arrival, watched)
        tracked[name] = Tracked(run_tracker(tracker, record, prior, start, ahead), record, law_from)
        figures[name]["look_ahead"] = ahead.figures()
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
            figures[name] |= _judge(prepared, flight, sensors, tracked[name])
            tracked[name] = tracked[name].light()
    return tracked, figures


def _reads_places(tracker: Any) -> bool:
    return dataclasses.is_dataclass(tracker) and "measurement" in _given(type(tracker))


def _own(prepared: Prepared, tracker: Any, names: tuple[str, ...]) -> Any:
    """A caller's tracker; one with a ``measurement`` (an adapted filterpy object, say) reads this scenario's radars."""
    sensors = {name: prepared.scenario.sensors[name] for name in names}
    cluttered = _with_clutter(sensors)
    if cluttered:
        raise ScenarioError(f"a tracker of the caller cannot listen to '{cluttered[0]}', which has clutter")
    if not _reads_places(tracker):
        return tracker
    return dataclasses.replace(tracker, measurement=measurement_model(sensors, chart_height(prepared), "own"))


def build(prepared: Prepared, name: str, choice: TrackerChoice) -> tuple[Any, str | None]:
    """A tracker with what the simulation gives it, and where the law it is told comes from (None = it needs none).

    Raises ``ScenarioError`` where its sensors do not give what it needs.
    """
    cls = catalogue.load("trackers", choice.kind)
    wanted = _given(cls)
    sensors = {sensor: prepared.scenario.sensors[sensor] for sensor in choice.sensors}
    supplied: dict[str, Any] = {}
    law_from = None
    if "law" in wanted:
        supplied["law"], law_from = _told(prepared.law, name, choice)
    if "route" in wanted:
        supplied["route"] = prepared.route
    if "measurement" in wanted:
        places = {s: sensor for s, sensor in sensors.items() if "measured" not in wanted or _gives_place(sensor)}
        supplied["measurement"] = measurement_model(places, chart_height(prepared), name)
    if "measured" in wanted:
        supplied["measured"] = tuple(f"{s}.{channel}" for s, sensor in sensors.items() for channel in sensor.channels)
    if "zero_azimuth" in wanted:
        radar = next((sensor for sensor in sensors.values() if hasattr(sensor, "zero_azimuth")), None)
        if radar is None:
            raise ScenarioError(f"[trackers.{name}] kind '{choice.kind}' needs a sensor that measures an azimuth")
        supplied["zero_azimuth"] = radar.zero_azimuth
    missing = [field for field, required in wanted.items() if required and field not in supplied]
    if missing:
        raise ScenarioError(f"[trackers.{name}] kind '{choice.kind}' needs {missing[0]}, which no scenario gives")
    if choice.association is not None and ("measurement" not in wanted or "measured" in wanted):
        raise ScenarioError(f"[trackers.{name}] association: kind '{choice.kind}' does not track on the ground plane")
    try:
        tracker = construct(cls, choice.table, **supplied)
    except ValueError as error:
        raise ScenarioError(f"[trackers.{name}] {error}") from None
    if choice.association is None:
        if _with_clutter(sensors):
            raise ScenarioError(
                f"[trackers.{name}] sensors: '{_with_clutter(sensors)[0]}' has clutter; "
                'set association = "probabilistic", with it as the only sensor'
            )
        return tracker, law_from
    return AmongFalsePlots(tracker, _cluttered(name, sensors)), law_from


def _cluttered(name: str, sensors: dict[str, Any]) -> Any:
    """The one sensor of a tracker that associates."""
    radar = next(iter(sensors.values()))
    if len(sensors) > 1 or not _with_clutter(sensors):
        raise ScenarioError(
            f"[trackers.{name}] association: needs exactly one sensor, a radar with clutter above 0; "
            f"it has {', '.join(sensors)}"
        )
    if not radar.detection > 0.0:
        raise ScenarioError(f"[trackers.{name}] association: its radar never detects the target (detection = 0)")
    return radar


def _with_clutter(sensors: dict[str, Any]) -> list[str]:
    """Sensors whose looks hold false plots."""
    return [name for name, sensor in sensors.items() if getattr(sensor, "clutter", 0.0) > 0.0]


def _given(cls: type) -> dict[str, bool]:
    """Fields that the simulation fills, and whether they must be filled."""
    hints = typing.get_type_hints(cls, include_extras=True)
    return {
        field.name: field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        for field in dataclasses.fields(cls)
        if typing.get_origin(hints[field.name]) is Annotated and GIVEN in hints[field.name].__metadata__
    }


def _gives_place(sensor: Any) -> bool:
    return sensor.channels == ("north", "east") or sensor.channels[:2] == ("range", "azimuth")


def check(prepared: Prepared) -> None:
    """Build every tracker once, so that what cannot be tracked is told before anything flies."""
    choices = prepared.scenario.trackers
    built = {name: build(prepared, name, choice)[0] for name, choice in choices.items()}
    for name, choice in choices.items():
        before, chain = choice.handover, [name]
        while before is not None:
            if before in chain:
                raise ScenarioError(
                    f"[trackers.{name}] handover: goes round in a circle, {' <- '.join([*chain, before])}"
                )
            chain.append(before)
            before = choices[before].handover
        if choice.handover is not None:
            lacking = [c for c in built[name].channels if c not in built[choice.handover].channels]
            if lacking:
                raise ScenarioError(f"[trackers.{name}] handover: '{choice.handover}' does not estimate {lacking[0]}")


def _told(law: Any, name: str, choice: TrackerChoice) -> tuple[Any, str]:
    """The law that flies, or the one that the file tells instead: absolute values (SI) or factors."""
    changes = {}
    fields = [field.name for field in dataclasses.fields(law)]
    for key, value in choice.law.items():
        attribute = key.removesuffix("_factor")
        if attribute not in fields:
            names = ", ".join(f"{field}_factor" for field in fields)
            raise ScenarioError(f"[trackers.{name}.law] {key}: no such key; allowed: {names}")
        changes[attribute] = value * getattr(law, attribute) if key.endswith("_factor") else value
    return dataclasses.replace(law, **changes), "told wrong" if changes else "autopilot"


def chart_height(prepared: Prepared) -> float:
    """Height that a radar without elevation takes for granted, m."""
    return prepared.route.legs[0].height


def measurement_model(sensors: dict[str, Any], height: float, name: str) -> Any:
    """How the plots of sensors become positions."""
    models: list[Any] = []
    for sensor_name, sensor in sensors.items():
        if sensor.channels == ("north", "east"):
            models.append(LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))))
        elif sensor.channels[:2] == ("range", "azimuth"):
            north, east, up = sensor.antenna
            known = None if "elevation" in sensor.channels else height - up
            models.append(DebiasedPolar((north, east), sensor.zero_azimuth, known))
        else:
            raise ScenarioError(
                f"[trackers.{name}] sensors: '{sensor_name}' measures {', '.join(sensor.channels)}, "
                f"which is no position"
            )
    return models[0] if len(models) == 1 else Stacked(tuple(models))


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
    *_, last = follow(tracker, _between(record, begun, math.inf), prior, start=begun)
    state, _ = tracker.step(last.state, start - last.time, None, None)
    estimate = tracker.estimate(state)
    mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
    rows = [tracker.channels.index(component) for component in wanted]
    return Gaussian(mean[rows], cov[np.ix_(rows, rows)])


def _judge(prepared: Prepared, flight: Flight, names: tuple[str, ...], tracked: Tracked) -> dict[str, Any]:
    sensors = {name: prepared.scenario.sensors[name] for name in names}
    track, record = tracked.track, tracked.measurements
    truth = channels.truth_at(flight, track.time)
    order = np.argsort(record.arrival, kind="stable")
    cov = track.cov if track.cov.ndim == 4 else track.cov[..., None]
    errors = channels.compare(flight, truth, track.channels, track.mean, cov, sensors)
    taken = channels.truth_at(flight, record.time[order])  # a plot is judged when it was true, an estimate now
    plots = channels.raw(flight, taken, record.channels, record.z[order], sensors, chart_height(prepared))
    figures: dict[str, Any] = {"overall": {}, "by_phase": {}}
    for channel, compared in errors.items():
        squares = channels.squared(compared)
        measured = channels.squared(plots[channel]) if channel in plots else np.full_like(squares, np.nan)
        looked = np.isfinite(measured).any(axis=1) if channel in plots else np.ones(len(squares), bool)
        if not looked.any():
            continue
        figures["overall"][channel] = _figure(squares[looked], measured[looked])
        for index in np.unique(truth.phase[looked]):
            chosen = looked & (truth.phase == index)
            by_phase = figures["by_phase"].setdefault(flight.phases[index], {})
            by_phase[channel] = _figure(squares[chosen], measured[chosen])
    first = next(iter(errors.values()), None)
    if first is not None:
        dimension = first.error.shape[1]
        squares = channels.normalised(first)
        anees = consistency.mean_interval(np.mean(squares, axis=0) / dimension)
        figures |= {"anees": anees.value, "anees_low": anees.low, "anees_high": anees.high}
        figures["lost_fraction"] = float(np.mean(consistency.lost(squares, dimension)))
        figures["lost_time_s"] = _lost_time(track.time, squares, dimension)
    rows = np.isfinite(track.white).sum(axis=1)
    if rows.any():
        figures["anis"] = float(np.sum(np.where(rows > 0, track.nis, 0.0)) / rows.sum())
    return figures


def _lost_time(time: np.ndarray, squares: np.ndarray, dimension: int) -> float | None:
    """When the first of the draws was lost, s; None = never."""
    before = bisect.bisect_left(
        range(len(time)), True, key=lambda k: consistency.lost(squares[: k + 1], dimension).any()
    )
    return float(time[before]) if before < len(time) else None


def _figure(squares: np.ndarray, raw: np.ndarray) -> dict[str, float | None]:
    """RMSE over epochs and draws with an interval over draws, beside that of the raw measurements."""
    own = consistency.rmse(squares.mean(axis=0))
    figure: dict[str, float | None] = {"rmse": own.value, "low": own.low, "high": own.high, "raw": None, "gain": None}
    finite = np.isfinite(raw)
    if finite.any():
        figure["raw"] = float(np.sqrt(np.mean(raw[finite])))
        common = float(np.sqrt(np.mean(squares[finite])))
        figure["gain"] = figure["raw"] / common if common else None
    return figure
