"""Trackers on arrivals that look like recorded ones: ``python -m tests.tuning.arrival_trackers`` prints the table.

Trackers are tuned on even seeds and judged on odd ones; on the generator ``heading`` nothing is ever tuned. A radar
with Mode C sees each flight from 250 s before its last turn to 200 s behind it. Position errors count in three parts:
vectors (240 s before the last turn), capture (the turn and 20 s behind it), established (what follows). All flights and
draws are one batch.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.modes.radio_beacon import RadioBeacon
from autopilot.route import Leg, Route
from sim.flight.interpolation import truth_at
from sim.flight.record import Flight
from sim.observation.sensors.surveillance_radar import ALTIMETRY_SIGMA, STEPS, SurveillanceRadar
from sim.scenario.tables import Runway
from tests.tuning.arrivals import by_heading, by_law
from tests.tuning.look_alikes import SETTLING, final_route, look_alikes
from tracking.consistency import lost
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.height_profile import MeasuredHeight
from tracking.intervals import Interval, bootstrap
from tracking.measurement import DebiasedPolar, MeasurementModel
from tracking.track import Epoch, Measurements, chunks, track
from tracking.trackers.imm import InteractingMultipleModel
from tracking.trackers.intent_imm import IntentImm
from tracking.trackers.kalman import Kalman
from tracking.trackers.saturated_control import SaturatedControl
from tracking.tree import narrowed

PARTS = ("vectors", "capture", "established")
LEAD, BEFORE, BEHIND = 12.0, 240.0, 200.0  # s: in which a track settles, of vectors, behind the turn
PRIOR = np.array((100.0, 5.0, 100.0, 5.0))  # m, m/s, as of the unit that hands over
AHEAD = 60.0  # s
STRIDES = (20.0, 40.0)  # s, in which it is predicted, as on a page of a run
LOOK_EVERY, LOOKING = 3, 2  # epochs between looks ahead, draws that look

RADARS = {
    # so far from the flights that plots err as those of the recorded ones do: 121, 101 and 83 m in the three parts
    "law": SurveillanceRadar(position=(14e3, 5e3, 10.0), height="mode_c", runway=Runway(heading=by_law.FINAL_COURSE)),
    "heading": SurveillanceRadar(
        period=5.0,
        range_sigma=80.0,
        azimuth_sigma=math.radians(0.08),
        position=(-12e3, -9e3, 40.0),
        height="mode_c",
        height_step=STEPS[1],
        runway=Runway(heading=by_heading.FINAL_COURSE),
    ),
}
# the laws that the recipe designs for the scenario a320 at a bank limit of 25 deg
ASSUMED = LateralNavigation(math.radians(0.1488), math.radians(1.772), math.radians(25.0), 762.0, 85.9)
BEACON = RadioBeacon(5.195, 3.958, math.radians(25.0), math.radians(22.86))

Factory = Callable[[MeasurementModel, Any, Any], Any]  # of a tracker: measurement, route and law that it is given
TRACKERS: dict[str, Factory] = {
    "kalman q 3": lambda measurement, route, law: Kalman(measurement, acceleration_density=3.0),
    "imm": lambda measurement, route, law: InteractingMultipleModel(measurement),
    "imm 25 deg .05 .5": lambda measurement, route, law: InteractingMultipleModel(
        measurement, straight_density=0.05, manoeuvre_density=0.5, bank=math.radians(25.0)
    ),
    "intent_imm": lambda measurement, route, law: IntentImm(law, route, measurement, (BEACON,)),
    "saturated_control": lambda measurement, route, law: SaturatedControl(law, route, measurement),
}
LAW_FREE = "imm 25 deg .05 .5"  # the best of those without a law, against which the others are set


class Scene(NamedTuple):
    """Flights as one radar sees them, every one beginning at time 0: n flights, each with so many draws of noise."""

    flights: list[Flight]
    route: Any
    measurement: MeasurementModel
    plots: Measurements  # (k, 3, n * draws), flight by flight
    prior: Gaussian
    truth: Any  # (k, 4, n) north, its rate, east, its rate; NaN behind the end of a record
    ahead: Any  # (k, 2, n) north and east `AHEAD` later
    part: Any  # (k, n) index into PARTS, -1 = not judged
    turning: Any  # (k, n) bool, within the last turn
    draws: int


class Score(NamedTuple):
    """What one tracker did."""

    squares: Any  # (3, n) m2, mean square of the position error by part and flight; NaN = it has no such part
    anees: Any  # (3, n) of the position, 1 = as good as it says
    lost: Any  # (n, draws) bool
    ahead: Any  # errors of the predictions made within the turns, m; (0,) where none were asked for


def scene(kind: str, seed: int, count: int, draws: int) -> Scene:
    """Look-alikes of a generator under its radar."""
    return watched(look_alikes(kind, seed, count), RADARS[kind], seed, draws)


def arrival(flight: Flight) -> tuple[float, float]:
    """The part of a flight that is judged and the `LEAD` before, s."""
    first, last = _capture(flight)
    return first - LEAD - BEFORE, last + BEHIND


Window = Callable[[Flight], tuple[float, float]]  # of a flight: from when to when it is watched, s


def watched(flights: list[Flight], radar: SurveillanceRadar, seed: int, draws: int, window: Window = arrival) -> Scene:
    """Flights under a radar that gives ``range, azimuth, height``; every record begins at time 0."""
    generator = np.random.default_rng([seed, 8])
    windows = [window(flight) for flight in flights]
    windows = [
        (max(a, float(f.time[0])), min(b, float(f.time[-1]))) for f, (a, b) in zip(flights, windows, strict=True)
    ]
    spans = [_capture(flight) for flight in flights]
    time = radar.period * np.arange(math.ceil(max(last - first for first, last in windows) / radar.period))
    n, k = len(flights), len(time)
    exact, truth = np.full((k, 3, n), np.nan), np.full((k, 4, n), np.nan)
    later, part = np.full((k, 2, n), np.nan), np.full((k, n), -1)
    heights = np.full((k, n), np.nan)
    for i, (flight, (began, ends), span) in enumerate(zip(flights, windows, spans, strict=True)):
        own = began + time
        there = own <= ends
        found = truth_at(flight, own[there])
        north, east, heights[there, i] = found.position
        truth[there, :, i] = np.stack((north, found.velocity[0], east, found.velocity[1]), axis=1)
        exact[there, :, i] = radar.truth(found.state).T
        known = own + AHEAD <= flight.time[-1]
        later[known, :, i] = truth_at(flight, own[known] + AHEAD).position[:2].T
        part[there, i] = np.searchsorted(span, own[there])  # vectors, capture, established
        part[own < began + LEAD, i] = -1
    began, first, last = np.array([(window[0], *span) for window, span in zip(windows, spans, strict=True)]).T
    turning = (began + time[:, None] >= first) & (began + time[:, None] <= last - SETTLING)
    R = radar.covariance()
    noise = np.sqrt(np.diag(R))[:2, None, None] * generator.standard_normal((k, 2, n, draws))
    plots = np.empty((k, 3, n, draws))
    plots[:, :2] = exact[:, :2, :, None] + noise
    altimetry = ALTIMETRY_SIGMA * generator.standard_normal((n, draws))
    plots[:, 2] = radar.reported_height(heights[:, :, None], altimetry)
    channels = tuple(f"radar.{name}" for name in radar.channels)
    record = Measurements(channels, time, time, plots.reshape(k, 3, -1), np.broadcast_to(R, (k, 3, 3)))
    start = truth[0, :, :, None] + PRIOR[:, None, None] * generator.standard_normal((4, n, draws))
    prior = Gaussian(start.reshape(4, -1), np.diag(PRIOR**2))
    north, east, up = radar.antenna
    measurement = MeasuredHeight(DebiasedPolar((north, east), radar.zero_azimuth), up)
    route = final_route(radar.runway.heading)
    return Scene(flights, route, measurement, record, prior, truth, later, part, turning, draws)


def _capture(flight: Flight) -> tuple[float, float]:
    """When the capture of a flight begins and ends, s."""
    rows = np.flatnonzero(flight.during("capture"))
    return float(flight.time[rows[0]]), float(flight.time[rows[-1]])


def score(seen: Scene, factory: Factory, law: Any = ASSUMED, route: Any = None, look_ahead: bool = True) -> Score:
    """One tracker on all flights of a scene; ``route`` is another one than the final approach that is flown."""
    tracker = factory(seen.measurement, seen.route if route is None else route, law)
    n, draws = seen.truth.shape[-1], seen.draws
    truth = np.repeat(seen.truth, draws, axis=-1)
    errors, nees, ahead = [], [], []
    for runs in chunks(n * draws, 1200):
        watch = _Ahead(tracker, seen, runs) if look_ahead else None
        prior = Gaussian(seen.prior.mean[:, runs], seen.prior.cov)
        found = track(tracker, seen.plots.runs(runs), prior, watch=watch)
        place = [tracker.channels.index(name) for name in ("north", "east")]
        off = found.mean[:, place] - truth[:, ::2, runs]
        a, b, c = (np.asarray(found.cov)[:, place[i], place[j]] for i, j in ((0, 0), (0, 1), (1, 1)))
        errors.append(off[:, 0] ** 2 + off[:, 1] ** 2)
        nees.append((c * off[:, 0] ** 2 - 2.0 * b * off[:, 0] * off[:, 1] + a * off[:, 1] ** 2) / (a * c - b * b))
        ahead += [] if watch is None else watch.errors
    squares, normalised = (np.concatenate(values, axis=-1).reshape(-1, n, draws) for values in (errors, nees))
    unjudged = np.where((seen.part >= 0)[:, :, None], normalised, 0.0)
    means = (_by_part(seen, values) for values in (squares, normalised / 2.0))
    return Score(*means, lost(unjudged, 2), np.concatenate(ahead) if ahead else np.zeros(0))


def _by_part(seen: Scene, values: Any) -> Any:
    """(3, n) mean of values (k, n, draws) over the epochs of each part, and over the draws."""
    masks = [np.where(seen.part == index, 1.0, np.nan)[:, :, None] for index in range(len(PARTS))]
    with np.errstate(invalid="ignore"):
        return np.stack([_mean(values * mask) for mask in masks])


def _mean(values: Any) -> Any:
    """(n,) mean over epochs and draws, NaN where there are none."""
    asked = ~np.isnan(values)
    total, count = np.where(asked, values, 0.0).sum(axis=(0, 2)), asked.sum(axis=(0, 2))
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


class _Ahead:
    """Watches a tracker and predicts from some epochs within the turns."""

    def __init__(self, tracker: Any, seen: Scene, runs: slice) -> None:
        self.tracker, self.seen = tracker, seen
        self.runs = np.arange(seen.prior.mean.shape[-1])[runs]
        self.errors: list[Any] = []

    def __call__(self, epoch: Epoch) -> None:
        """Predict from this epoch, if it is one of those chosen."""
        if epoch.row % LOOK_EVERY:
            return
        own, draw = np.divmod(self.runs, self.seen.draws)
        later = self.seen.ahead[epoch.row][:, own]
        rows = np.flatnonzero(self.seen.turning[epoch.row, own] & np.isfinite(later[0]) & (draw < LOOKING))
        if not rows.size:
            return
        state = narrowed(epoch.state, len(own), rows)
        for stride in STRIDES:
            state, _ = self.tracker.step(state, stride, None, None)
        found = self.tracker.estimate(state)
        mean = (merge(found) if isinstance(found, Mixture) else found).mean
        place = [self.tracker.channels.index(name) for name in ("north", "east")]
        self.errors.append(np.hypot(*(mean[place] - later[:, rows])))


def raw(seen: Scene) -> Score:
    """The plots themselves, each by itself; they have no doubts and no future."""
    n, draws = seen.truth.shape[-1], seen.draws
    truth = np.repeat(seen.truth, draws, axis=-1)
    squares = []
    for z, R, exactly in zip(seen.plots.z, seen.plots.R, truth, strict=True):
        place = seen.measurement.linearise(z, R[:, :, None], exactly).z
        squares.append(((place - exactly[::2]) ** 2).sum(axis=0))
    by_part = _by_part(seen, np.array(squares).reshape(-1, n, draws))
    return Score(by_part, np.full_like(by_part, np.nan), np.zeros((n, draws), bool), np.zeros(0))


def wrong_routes(course: float) -> dict[str, Any]:
    """The final approach told wrong: beside the true one, turned about the threshold, and that of another runway."""
    north, east = -math.sin(course), math.cos(course)
    return {
        "384 m beside": moved_route(final_route(course), 384.0 * north, 384.0 * east),
        "0.5 deg off": final_route(course + math.radians(0.5)),
        "20 km beside": moved_route(final_route(course), 20e3 * north, 20e3 * east),
    }


def moved_route(route: Route, north: float, east: float) -> Route:
    """A route of one leg, moved by so many metres."""
    (leg,) = route.legs
    (a, b), (c, d) = leg.start, leg.end
    return Route((Leg((a + north, b + east), (c + north, d + east), leg.speed, leg.height),))


def recorded_scene(tracks: Path, runway: Path, seed: int, draws: int) -> Scene:
    """The flights of a file of recordings under the radar of ``law``, placed at their runway; those with a capture."""
    from sim.flight.recording.flights import recorded
    from sim.scenario.reading import read_runway

    place, _ = read_runway(runway)
    flights = [flight for flight in recorded(tracks, runway).values() if flight.during("capture").any()]
    return watched(flights, replace(RADARS["law"], runway=place), seed, draws)


def ratio(reference: Score, own: Score, part: str | None, seed: int = 0) -> Interval:
    """RMSE of the reference over that of a tracker on the same flights and draws, with a bootstrap over flights.

    ``part`` None = all three together, each flight by its mean squares.
    """
    rows = slice(None) if part is None else slice(PARTS.index(part), PARTS.index(part) + 1)

    def statistic(first: Any, second: Any) -> Any:
        return np.sqrt(np.nansum(first) / np.nansum(second))

    return bootstrap(statistic, (reference.squares[rows], own.squares[rows]), np.random.default_rng(seed))


def rmse(own: Score, part: str) -> float:
    """m, over flights and draws."""
    return float(np.sqrt(np.nanmean(own.squares[PARTS.index(part)])))


@cache
def scored(kind: str, seed: int, count: int, draws: int) -> dict[str, Score]:
    """The trackers of this page on one scene."""
    seen = scene(kind, seed, count, draws)
    return {"raw": raw(seen), **{name: score(seen, factory) for name, factory in TRACKERS.items()}}


def lines(found: dict[str, Score], law_free: str = LAW_FREE) -> Iterator[str]:
    """The table of one scene."""
    yield "| tracker | vectors | capture | established | ANEES v/c/e | lost % | 60 s ahead | capture x | overall x |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for name, own in found.items():
        errors = " | ".join(f"{rmse(own, part):.0f}" for part in PARTS)
        if name == "raw":
            yield f"| {name} | {errors} | | | | | |"
            continue
        anees = " / ".join(f"{np.nanmean(own.anees[row]):.2f}" for row in range(len(PARTS)))
        ahead = f"{np.median(own.ahead):.0f}" if own.ahead.size else "-"
        better = [ratio(found[law_free], own, part) for part in ("capture", None)]
        told = " | ".join(f"{one.value:.3f} ({one.low:.3f}-{one.high:.3f})" for one in better)
        yield f"| {name} | {errors} | {anees} | {100.0 * own.lost.mean():.1f} | {ahead} | {told} |"


def main() -> None:
    """Print the table for a seed on both generators."""
    seed, count, draws = (int(sys.argv[i]) if len(sys.argv) > i else value for i, value in ((1, 1), (2, 60), (3, 4)))
    for kind in RADARS:
        print(f"\n{kind}, seed {seed}, {count} flights x {draws} draws")
        print("\n".join(lines(scored(kind, seed, count, draws))))


if __name__ == "__main__":
    main()
