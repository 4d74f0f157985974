"""A run for Stone Soup, and its tracks for ``judge``: the only place that knows the package, which is optional.

Its state space here is ours: north, north rate, east, east rate from the threshold, so that its x is north, its y east,
and a bearing turns clockwise from north, as azimuths do.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from datetime import datetime, timedelta
from typing import Any, NamedTuple

import numpy as np

from sim.errors import OutputError
from sim.estimation.setup import height_profile
from sim.flight.interpolation import truth_at
from sim.interchange.clocks import Stamps
from sim.interchange.estimates import Estimates
from sim.metrics.comparison import plotted
from sim.observation.record import SensorRecord
from sim.results.estimates import refuse_draw, track_of
from sim.results.result import Result

STATE = ("north", "north_rate", "east", "east_rate")
PLACE, VELOCITY = (0, 2), (1, 3)  # rows of it: Stone Soup's mapping and velocity_mapping
MICROSECONDS = 6  # digits behind the point of a second: no two states of a path have one stamp
START = datetime(2026, 1, 1)  # time 0 of a flight, unless told


class StoneSoup(NamedTuple):
    """One draw of a run as objects of Stone Soup; stamps are rounded to its microsecond."""

    truth: Any  # GroundTruthPath, at every record, look and estimate; None where nothing is known
    detections: dict[str, list[tuple[datetime, set[Any]]]]  # by sensor, as its trackers take them: each look with plots
    tracks: dict[str, Any]  # Track by tracker
    left: tuple[str, ...]  # sensors and trackers that are no place on the ground plane, in sentences


def to_stonesoup(result: Result, draw: int = 0, start: datetime = START) -> StoneSoup:
    """The truth, the detections and the tracks of one draw of the noise for Stone Soup.

    A radar's detection is bearing and range on the ground, with the covariance that the sensor states: a slant range is
    brought to the ground by the elevation or height that the radar measures, or else at the planned height, as our
    trackers do. A sensor that measures north and east gives them as they are. ``start`` is the time 0 of the flight.

    Raises ``OutputError`` in one sentence where Stone Soup is missing, and for a draw that the run has not.
    """
    if importlib.util.find_spec("stonesoup") is None:
        raise OutputError("to_stonesoup needs Stone Soup: pip install 'shortfinal[stonesoup]'")
    refuse_draw(draw, result.scenario.draws)
    detections: dict[str, list[tuple[datetime, set[Any]]]] = {}
    tracks: dict[str, Any] = {}
    left: list[str] = []
    for name, record in result.records.items():
        looks = _detections(result, name, record, draw, start)
        if looks is None:
            left.append(f"sensor '{name}' measures {', '.join(record.channels)}, which is no place")
        else:
            detections[name] = looks
    times = [result.flight.whole.time, *(record.time for record in result.records.values())]
    for name, one in result.tracks.items():
        found = track_of(one, draw)
        if not {"north", "east"} <= {*found.channels}:
            left.append(f"tracker '{name}' does not estimate north and east")
            continue
        rows = [found.channels.index(channel) for channel in STATE if channel in found.channels]
        cov = found.cov[:, rows][:, :, rows, 0]
        tracks[name] = _track(name, _stamps(found.time, start), found.mean[:, rows, 0], cov)
        times.append(found.time)
    stamped = np.unique(np.round(np.concatenate(times), MICROSECONDS))
    truth = _truth(result, stamped, start) if result.flight.known else None
    return StoneSoup(truth, detections, tracks, tuple(left))


def from_stonesoup(
    *tracks: Any,
    start: datetime = START,
    mapping: tuple[int, int] = PLACE,
    velocity_mapping: tuple[int, int] | None = VELOCITY,
) -> Estimates:
    """Tracks of Stone Soup as estimates that ``judge`` takes: ``from_stonesoup(track).save("mine.csv")``.

    The first track is of draw 0 of the noise, the next of draw 1, and so on. States without a covariance, or with NaN
    in it, state none; those without a finite place are left out.

    Parameters
    ----------
    start : time 0 of the flight, as it was given to `to_stonesoup`
    mapping, velocity_mapping : which components of a state are north and east, and their rates; None = no rates

    Raises ``ValueError`` for tracks without any state.
    """
    rows = [(draw, state) for draw, track in enumerate(tracks) for state in track]
    place = np.array([[_component(state, row) for row in mapping] for _, state in rows]).reshape(-1, 2)
    sound = np.isfinite(place).all(axis=1)
    rows = [row for row, good in zip(rows, sound, strict=True) if good]
    if not rows:
        raise ValueError("the tracks have no state that says a place")
    states = [state for _, state in rows]
    velocity = None
    if velocity_mapping is not None:
        velocity = np.array([[_component(state, row) for row in velocity_mapping] for state in states])
    cov = np.array([_covariance(state, mapping) for state in states])
    return Estimates(
        Stamps(False, np.array([(state.timestamp - start).total_seconds() for state in states])),
        np.array([draw for draw, _ in rows]),
        None,
        place[sound],
        None,
        velocity,
        cov if np.isfinite(cov).any() else None,
    )


def _component(state: Any, row: int) -> float:
    return float(state.mean[row, 0])


def _covariance(state: Any, mapping: tuple[int, int]) -> np.ndarray:
    """(2, 2) m2 of the place; NaN where the state says none."""
    covariance = getattr(state, "covar", None)
    return np.full((2, 2), np.nan) if covariance is None else np.asarray(covariance, float)[np.ix_(mapping, mapping)]


def _stamps(time: np.ndarray, start: datetime) -> list[datetime]:
    return [start + timedelta(seconds=one) for one in time.tolist()]


def _truth(result: Result, time: np.ndarray, start: datetime) -> Any:
    from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState

    truth = truth_at(result.flight.whole, time)
    rows = np.array((truth.position[0], truth.velocity[0], truth.position[1], truth.velocity[1])).T
    stamps = _stamps(time, start)
    return GroundTruthPath(
        [GroundTruthState(row, timestamp=stamp) for row, stamp in zip(rows, stamps, strict=True)], id="truth"
    )


def _track(name: str, stamps: list[datetime], mean: np.ndarray, cov: np.ndarray) -> Any:
    from stonesoup.types.state import GaussianState
    from stonesoup.types.track import Track

    states = [GaussianState(*state) for state in zip(mean, cov, stamps, strict=True)]
    return Track(states, id=name)


class Plots(NamedTuple):
    """What the plots of a sensor say of one draw: c of them in each of k looks, NaN = fewer."""

    value: np.ndarray  # (k, c, 2) north and east, or bearing from the zero of the sensor and range on the ground
    cov: np.ndarray  # (k, c, 2, 2)


def _detections(
    result: Result, name: str, record: SensorRecord, draw: int, start: datetime
) -> list[tuple[datetime, set[Any]]] | None:
    """The looks of a sensor, each with its plots, false ones too; None for one that says no place."""
    from stonesoup.types.detection import Detection

    z = record.z[:, None] if record.candidates is None else record.candidates
    R = record.R if record.R.ndim == 3 else record.R[..., draw if record.R.shape[3] > 1 else 0]
    sensor = result.scenario.sensors[name]
    found = plots_of(result, sensor, record.channels, z[..., draw], R)
    if found is None:
        return None
    model = _linear if {"north", "east"} <= {*record.channels} else _polar
    looks = []
    for stamp, values, covs in zip(_stamps(record.time, start), *found, strict=True):
        said = np.isfinite(values).all(axis=1)
        plots = (
            Detection(value, timestamp=stamp, measurement_model=model(sensor, cov), metadata={"sensor": name})
            for value, cov in zip(_typed(values[said], model is _polar), covs[said], strict=True)
        )
        looks.append((stamp, {*plots}))
    return looks


def _typed(values: np.ndarray, polar: bool) -> Iterator[Any]:
    from stonesoup.types.angle import Bearing
    from stonesoup.types.array import StateVector

    for first, second in values.tolist():
        yield StateVector([Bearing(first) if polar else first, second])


def _linear(sensor: Any, cov: np.ndarray) -> Any:
    from stonesoup.models.measurement.linear import LinearGaussian

    return LinearGaussian(ndim_state=len(STATE), mapping=PLACE, noise_covar=cov)


def _polar(sensor: Any, cov: np.ndarray) -> Any:
    from stonesoup.models.measurement.nonlinear import CartesianToBearingRange
    from stonesoup.types.array import StateVector

    return CartesianToBearingRange(
        ndim_state=len(STATE),
        mapping=PLACE,
        noise_covar=cov,
        translation_offset=StateVector(sensor.antenna[:2]),
        rotation_offset=StateVector([0.0, 0.0, sensor.zero_azimuth]),
    )


def plots_of(result: Result, sensor: Any, channels: tuple[str, ...], z: np.ndarray, R: np.ndarray) -> Plots | None:
    """Plots (k, c, m) with their covariance (k, m, m) on the ground plane; None for what is no place.

    A slant range r at the height h over the antenna, or the elevation e, is g = sqrt(r^2 - h^2) = r cos e on the
    ground, and its error r dr / g - h dh / g, or cos e dr - r sin e de. Without either the planned height is taken.
    """
    row = {channel: z[:, :, number] for number, channel in enumerate(channels)}
    place = plotted(row, sensor, height_profile(result.prepared))
    if place is None:
        return None
    if {"north", "east"} <= {*channels}:
        J = np.zeros((*z.shape[:2], 2, len(channels)))
        J[:, :, 0, channels.index("north")] = J[:, :, 1, channels.index("east")] = 1.0
        return Plots(np.moveaxis(place, 0, 2), _spread(J, R))
    north, east, up = sensor.antenna
    ground = np.hypot(place[0] - north, place[1] - east)
    J = np.zeros((*z.shape[:2], 2, len(channels)))
    J[:, :, 0, channels.index("azimuth")] = 1.0
    with np.errstate(divide="ignore", invalid="ignore"):  # over the antenna there is no bearing
        if "elevation" in channels:
            J[:, :, 1, channels.index("range")] = np.cos(row["elevation"])
            J[:, :, 1, channels.index("elevation")] = -row["range"] * np.sin(row["elevation"])
        else:
            J[:, :, 1, channels.index("range")] = row["range"] / ground
            if "height" in channels:
                J[:, :, 1, channels.index("height")] = (up - row["height"]) / ground
    return Plots(np.stack((row["azimuth"], ground), axis=2), _spread(J, R))


def _spread(J: np.ndarray, R: np.ndarray) -> np.ndarray:
    """(k, c, 2, 2) J R J' of plots with the slopes J (k, c, 2, m)."""
    return np.asarray(np.einsum("kcim,kmn,kcjn->kcij", J, np.nan_to_num(R), J))
