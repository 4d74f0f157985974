"""The figures of a recorded track, by the same metrics as those of trackers that run here."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from sim.errors import ScenarioError
from sim.estimation.recorded.chain import Chain, Rows, chained
from sim.estimation.recorded.completeness import completeness
from sim.flight.interpolation import truth_at
from sim.flight.outcomes import ROLLOUT
from sim.flight.record import Flight
from sim.metrics.contrasts.squares import squared_errors
from sim.metrics.error_curves import ErrorCurves, error_curves
from sim.metrics.tracker import TrackerErrors, plot_errors, tracker_errors, tracker_metrics
from tracking.height_profile import Charted
from tracking.track import Measurements, Track

SAME = 1 / 128  # s: an estimate is of a look that arrived at its time; of the stamps of ASTERIX this is one step
FAR = 50e3  # m: a track that never comes so near is not of this flight
WITHOUT_COVARIANCE = "anees, lost_fraction: the file states no covariance of north and east"
WITHOUT_PREDICTION = "look_ahead, anis: a recorded track has no prediction"


class JudgedTrack(NamedTuple):
    """A recorded track as it is kept."""

    track: Track  # to the end of the flight
    curves: ErrorCurves
    rollout: Track | None
    squares: dict[str, Any]
    figures: dict[str, Any]


def judge(
    name: str, channels: tuple[str, ...], rows: Rows, flight: Flight, sensors: dict[str, Any], chart: Charted,
    looks: Measurements,
) -> JudgedTrack:  # fmt: skip
    """Set the rows of a file against the truth of a flight.

    Parameters
    ----------
    channels : components of the estimates
    sensors : those that the track was made from
    looks : theirs, in order of arrival, the roll-out too

    Raises ``ScenarioError`` in one sentence for a track that is not of this flight.
    """
    whole, end = flight.whole, float(flight.time[-1])
    first, last = float(whole.time[0]), float(whole.time[-1])
    within = (rows.time >= first) & (rows.time <= last)
    if not within.any():
        raise ScenarioError(
            f"[trackers.{name}] its estimates are of {rows.time.min():.1f} s to {rows.time.max():.1f} s, and the "
            f"flight lasts from {first:.1f} s to {last:.1f} s"
        )
    rows = rows.chosen(within)

    def place_at(time: np.ndarray) -> np.ndarray:
        return truth_at(whole, time).position[:2].T

    try:
        chain = chained(rows, looks.z.shape[2], place_at)
    except ValueError as error:
        raise ScenarioError(f"[trackers.{name}] its file {error}") from None
    away = _away(chain, place_at)
    if not away < FAR:
        raise ScenarioError(
            f"[trackers.{name}] its estimates never come nearer to the aircraft than {away / 1e3:.0f} km: "
            "is it the track of another flight?"
        )
    flying, rolling = chain.rows(chain.time <= end), chain.rows(chain.time > end)
    track = _track(channels, flying)
    errors = _errors(flight, sensors, chart, track, flying, looks)
    figures = {"look_ahead": {}, **tracker_metrics(flight, track, errors), "anis": None}
    squares = squared_errors(flight, track, errors)
    rolled = None
    if len(rolling.time):
        rolled = _track(channels, rolling)
        late = _errors(whole, sensors, chart, rolled, rolling, looks)
        for table, own in ((figures, tracker_metrics), (squares, squared_errors)):
            by_phase = own(whole, rolled, late)["by_phase"]
            table["by_phase"] |= {phase: found for phase, found in by_phase.items() if phase == ROLLOUT}
    before = looks.rows(slice(0, int(np.searchsorted(looks.arrival, end, "right"))))
    figures["track"] = completeness(flying, before)
    figures["not_known"] = [WITHOUT_PREDICTION, *((WITHOUT_COVARIANCE,) if rows.cov is None else ())]
    return JudgedTrack(track, error_curves(flight, sensors, track, errors), rolled, squares, figures)


def _away(chain: Chain, place_at: Any) -> float:
    """m of the estimate that is nearest to the aircraft."""
    east = chain.mean.shape[1] // 2
    error = chain.mean[:, [0, east]] - place_at(chain.time)[:, :, None]
    return float(np.nanmin(np.hypot(error[:, 0], error[:, 1]), initial=math.inf))


def _track(channels: tuple[str, ...], chain: Chain) -> Track:
    k, n, draws = chain.mean.shape
    cov = np.full((k, n, n, draws), np.nan)
    place = np.array([channels.index("north"), channels.index("east")])
    cov[:, place[:, None], place[None, :]] = chain.cov
    nothing = np.zeros((k, draws))
    return Track(channels, chain.time, chain.mean, cov, np.full((k, 0, draws), np.nan), nothing, nothing, None)


def _errors(
    flight: Flight, sensors: dict[str, Any], chart: Charted, track: Track, chain: Chain, looks: Measurements
) -> TrackerErrors:
    """Errors of a track at its own epochs, beside those of the looks that arrived then."""
    found = tracker_errors(flight, sensors, track, plot_errors(flight, sensors, chart, _looks_at(chain.time, looks)))
    return found._replace(present=chain.present)


def _looks_at(time: np.ndarray, looks: Measurements) -> Measurements:
    """The looks that arrived at times (k,); NaN where none did."""
    after = np.clip(np.searchsorted(looks.arrival, time), 1, len(looks.arrival) - 1)
    nearer = np.abs(looks.arrival[after - 1] - time) <= np.abs(looks.arrival[after] - time)
    row = np.where(nearer, after - 1, after)
    same = np.abs(looks.arrival[row] - time) <= SAME
    z = np.where(same[:, None, None], looks.z[row], np.nan)
    taken = np.where(same, looks.time[row], time)
    return Measurements(looks.channels, np.minimum(taken, time), time, z, looks.R[row])
