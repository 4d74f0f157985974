"""track(): every tracker of a scenario on the same flight and the same measurements, judged in comparison channels."""

from __future__ import annotations

import dataclasses
import typing
from typing import Annotated, Any, NamedTuple

import numpy as np

from sim import catalogue, channels
from sim.errors import ScenarioError
from sim.flight import Flight
from sim.observation import SensorRecord, measurements
from sim.parameters import GIVEN, construct
from sim.preparation import Prepared
from sim.randomness import stream
from sim.scenario import TrackerChoice
from tracking.gaussian import Gaussian
from tracking.measurement import DebiasedPolar, LinearMeasurement, Stacked
from tracking.motion import CARTESIAN
from tracking.track import Measurements, Track
from tracking.track import track as run_tracker

PRIOR_POSITION, PRIOR_RATE = 100.0, 5.0  # m, m/s: what the unit that hands over knows
ELLIPSE, LOST_AFTER = 1 - 1e-6, 10  # a track is lost after so many epochs outside this ellipse


class Tracked(NamedTuple):
    """One tracker's record and how it was set up."""

    track: Track
    measurements: Measurements
    law_from: str | None

    def arrays(self, name: str) -> dict[str, np.ndarray]:
        """For tracks.npz."""
        return {
            f"{name}.time_s": self.track.time,
            f"{name}.channels": np.array(self.track.channels),
            f"{name}.mean": self.track.mean,
            f"{name}.cov": self.track.cov,
        }


def track(
    prepared: Prepared, flight: Flight, records: dict[str, SensorRecord], own: dict[str, Any]
) -> tuple[dict[str, Tracked], dict[str, Any]]:
    """Run the trackers of a scenario, and ``own`` trackers of the caller, over one recorded flight.

    Returns the records and the figures of metrics.json. A tracker sees measurements, the law it is told and the
    route; never the active leg, the phase or the true motion.
    """
    tracked: dict[str, Tracked] = {}
    figures: dict[str, Any] = {}
    choices = dict(prepared.scenario.trackers)
    for name, choice in choices.items():
        record = measurements(records, choice.sensors)
        if not len(record.time):
            figures[name] = {"kind": choice.kind, "law_from": None, "overall": {}, "by_phase": {}}
            continue
        tracker, law_from = build(prepared, name, choice)
        tracked[name] = Tracked(_follow(prepared, flight, name, tracker, record), record, law_from)
        figures[name] = {
            "kind": choice.kind,
            "law_from": law_from,
            **_judge(prepared, flight, choice.sensors, tracked[name]),
        }
    for name, tracker in own.items():
        sensors = tuple(records)
        record = measurements(records, sensors)
        tracked[name] = Tracked(_follow(prepared, flight, name, tracker, record), record, None)
        figures[name] = {"kind": "own", "law_from": None, **_judge(prepared, flight, sensors, tracked[name])}
    return tracked, figures


def build(prepared: Prepared, name: str, choice: TrackerChoice) -> tuple[Any, str | None]:
    """A tracker with what the simulation gives it, and where the law it is told comes from (None = it needs none)."""
    cls = catalogue.load("trackers", choice.kind)
    wanted = _given(cls)
    supplied: dict[str, Any] = {}
    law_from = None
    if "law" in wanted:
        supplied["law"], law_from = _told(prepared.law, choice)
    if "route" in wanted:
        supplied["route"] = prepared.route
    if "measurement" in wanted:
        supplied["measurement"] = _measurement(prepared, name, choice.sensors)
    missing = [field for field, required in wanted.items() if required and field not in supplied]
    if missing:
        raise ScenarioError(
            f"[trackers.{name}] kind '{choice.kind}' needs {', '.join(missing)}, which no scenario gives"
        )
    try:
        return construct(cls, choice.table, **supplied), law_from
    except ValueError as error:
        raise ScenarioError(f"[trackers.{name}] {error}") from None


def _given(cls: type) -> dict[str, bool]:
    """Fields that the simulation fills, and whether they must be filled."""
    hints = typing.get_type_hints(cls, include_extras=True)
    return {
        field.name: field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        for field in dataclasses.fields(cls)
        if typing.get_origin(hints[field.name]) is Annotated and GIVEN in hints[field.name].__metadata__
    }


def _told(law: Any, choice: TrackerChoice) -> tuple[Any, str]:
    """The law that flies, or the one that the file tells instead: absolute values (SI) or factors."""
    changes = {}
    for key, value in choice.law.items():
        attribute = key.removesuffix("_factor")
        if not hasattr(law, attribute):
            names = [f"{field.name}_factor" for field in dataclasses.fields(law)]
            raise ScenarioError(f"law of a tracker: no key '{key}'; allowed: {', '.join(names)}")
        changes[attribute] = value * getattr(law, attribute) if key.endswith("_factor") else value
    return dataclasses.replace(law, **changes), "told wrong" if changes else "autopilot"


def _measurement(prepared: Prepared, name: str, sensors: tuple[str, ...]) -> Any:
    """How the plots of its sensors become positions; a radar without elevation takes the height from the chart."""
    models = []
    for sensor_name in sensors:
        sensor = prepared.scenario.sensors[sensor_name]
        if sensor.channels == ("north", "east"):
            models.append(LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))))
        elif sensor.channels[:2] == ("range", "azimuth"):
            north, east, up = sensor.antenna
            height = None if "elevation" in sensor.channels else prepared.route.legs[0].height - up
            models.append(DebiasedPolar((north, east), sensor.zero_azimuth, height))
        else:
            raise ScenarioError(f"[trackers.{name}] sensors: '{sensor_name}' gives no position")
    return models[0] if len(models) == 1 else Stacked(tuple(models))


def _follow(prepared: Prepared, flight: Flight, name: str, tracker: Any, record: Measurements) -> Track:
    """Begin at the first epoch, at the truth and a draw of the prior's error."""
    first = channels.truth_at(flight, record.time[:1])
    states = {
        "north": (first.position[0, 0], PRIOR_POSITION),
        "east": (first.position[1, 0], PRIOR_POSITION),
        "north_rate": (first.velocity[0, 0], PRIOR_RATE),
        "east_rate": (first.velocity[1, 0], PRIOR_RATE),
    }
    unknown = [channel for channel in tracker.channels if channel not in states]
    if unknown:
        raise ScenarioError(f"[trackers.{name}] no prior for its component '{unknown[0]}' in a scenario")
    mean, sigma = (np.array([states[channel][i] for channel in tracker.channels]) for i in (0, 1))
    draws = record.z.shape[2]
    seed = prepared.scenario.seed
    # one prior error per draw, the same for every tracker: it belongs to the unit that hands over
    standard = np.stack(
        [stream(seed, 0, draw, "prior").standard_normal(len(CARTESIAN)) for draw in range(draws)], axis=1
    )
    rows = [CARTESIAN.index(channel) for channel in tracker.channels]
    prior = Gaussian(mean[:, None] + sigma[:, None] * standard[rows], np.diag(sigma**2))
    return run_tracker(tracker, record, prior, start=float(record.arrival.min()))


def _judge(prepared: Prepared, flight: Flight, sensors: tuple[str, ...], tracked: Tracked) -> dict[str, Any]:
    from tracking import consistency  # imports scipy.stats, which a run without trackers does not need

    truth = channels.truth_at(flight, tracked.track.time)
    cov = tracked.track.cov if tracked.track.cov.ndim == 4 else tracked.track.cov[..., None]
    errors = channels.compare(flight, truth, tracked.track.channels, tracked.track.mean, cov)
    plots = channels.raw(flight, truth, _plots(prepared, sensors, tracked.measurements, truth))
    present = ~np.isnan(tracked.measurements.z).all(axis=(1, 2))
    figures: dict[str, Any] = {"overall": {}, "by_phase": {}}
    for channel, compared in errors.items():
        squares, raw_squares = channels.squared(compared), channels.squared(plots[channel])
        figures["overall"][channel] = _figure(squares[present], raw_squares[present])
        for index in np.unique(truth.phase[present]):
            chosen = present & (truth.phase == index)
            by_phase = figures["by_phase"].setdefault(flight.phases[index], {})
            by_phase[channel] = _figure(squares[chosen], raw_squares[chosen])
    first = next(iter(errors.values()), None)
    if first is not None:
        normalised = channels.normalised(first) / first.error.shape[1]
        anees = consistency.mean_interval(np.nanmean(normalised[present], axis=0))
        figures |= {"anees": anees.value, "anees_low": anees.low, "anees_high": anees.high}
        figures["lost_fraction"] = _lost(normalised * first.error.shape[1], first.error.shape[1])
    measured = np.isfinite(tracked.track.white).sum(axis=1)
    nis = np.where(measured > 0, tracked.track.nis, np.nan)
    figures["anis"] = (
        float(np.nanmean(nis / np.where(measured > 0, measured, np.nan))) if (measured > 0).any() else None
    )
    return figures


def _figure(squares: np.ndarray, raw: np.ndarray) -> dict[str, float | None]:
    """RMSE over epochs and draws with an interval over draws, beside that of the raw measurements."""
    from tracking import consistency

    finite = np.isfinite(raw)
    if not finite.any():
        return {"rmse": None, "low": None, "high": None, "raw": None, "gain": None}
    own = consistency.rmse(squares.mean(axis=0))
    measured = float(np.sqrt(np.mean(raw[finite])))
    common = float(np.sqrt(np.mean(squares[finite])))
    return {
        "rmse": own.value,
        "low": own.low,
        "high": own.high,
        "raw": measured,
        "gain": measured / common if common else None,
    }


def _plots(prepared: Prepared, sensors: tuple[str, ...], record: Measurements, truth: channels.Truth) -> np.ndarray:
    """North and east (k, 2, draws) of the first sensor that measured at each epoch."""
    k, _, draws = record.z.shape
    plots = np.full((k, 2, draws), np.nan)
    row = 0
    for name in sensors:
        sensor = prepared.scenario.sensors[name]
        m = len(sensor.channels)
        z = record.z[:, row : row + m]
        row += m
        if sensor.channels == ("north", "east"):
            found = z
        else:
            north, east, up = sensor.antenna
            if m == 3:
                ground = z[:, 0] * np.cos(z[:, 2])
            else:
                chart = prepared.route.legs[0].height - up
                ground = np.sqrt(np.maximum(z[:, 0] ** 2 - chart**2, 0.0))
            bearing = z[:, 1] + sensor.zero_azimuth
            found = np.stack((north + ground * np.cos(bearing), east + ground * np.sin(bearing)), axis=1)
        plots = np.where(np.isnan(plots), found, plots)
    return plots


def _lost(normalised: np.ndarray, dimension: int) -> float:
    """Share of draws that were outside their own ellipse for a while, or not finite."""
    from scipy.stats import chi2

    outside = ~(normalised <= chi2.ppf(ELLIPSE, dimension))
    streak, longest = np.zeros(outside.shape[1]), np.zeros(outside.shape[1])
    for row in outside:
        streak = (streak + 1) * row
        longest = np.maximum(longest, streak)
    return float(np.mean(longest >= LOST_AFTER))
