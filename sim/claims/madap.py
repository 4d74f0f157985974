"""MADAP, an outside judge: the published errors of operational trackers beside those of ours on the same manoeuvres."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sim.claims.ledger import Claim, Reading
from sim.claims.plots import Curve, Plot
from sim.claims.verdict import Printed, number
from sim.randomness import stream
from sim.truths.madap import BANKS, KNOT, NAUTICAL_MILE, SPEEDS, Madap
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.intervals import Interval, mean_interval, rmse
from tracking.measurement import LinearMeasurement
from tracking.motion import ConstantVelocity
from tracking.track import Measurements, follow
from tracking.trackers.imm import InteractingMultipleModel
from tracking.trackers.kalman import Kalman


class Radar(NamedTuple):
    """A surveillance radar; the guidelines publish ranges of accuracy and period, no sites: these are ours."""

    north: float  # m
    east: float  # m
    period: float  # s
    first: float  # s
    range_sigma: float  # m
    azimuth_sigma: float  # rad


def _radar(north: float, east: float, period: float, first: float, sigma: float, angle: float) -> Radar:
    return Radar(north, east, period, first, sigma, math.radians(angle))


SINGLE = (_radar(0.0, 0.0, 6.0, 1.0, 60.0, 0.15),)
SEVERAL = (
    *SINGLE,
    _radar(60e3, -30e3, 8.0, 2.5, 44.0, 0.11),
    _radar(-40e3, 60e3, 10.0, 4.0, 70.0, 0.13),
    _radar(70e3, 70e3, 12.0, 5.5, 77.0, 0.18),
)
PLANE = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
TRACKERS: dict[str, Any] = {
    "imm": InteractingMultipleModel(PLANE),
    "constant_velocity": Kalman(PLANE, ConstantVelocity(10.0)),
}
STEP = 0.5  # s, of the truth's record; every scan is a multiple
MOST = 100  # runs of the sixteen flights: each is some five hundred scans of each of them
SETTLED = 60.0  # s, of the track's initiation
PRIOR = np.array([300.0, 20.0, 300.0, 20.0])  # m, m/s


class Found(NamedTuple):
    """Errors (epochs of all flights, runs) with the phase of each epoch."""

    position: Any  # NM
    speed: Any  # kt
    heading: Any  # deg
    turning: Any  # (epochs,)


def seen(radars: tuple[Radar, ...], state: Any, runs: int, generator: np.random.Generator) -> tuple[Any, Measurements]:
    """Rows of the truth at all scans, and the converted plots of an ensemble."""
    looks = sorted(
        (t, i) for i, radar in enumerate(radars) for t in np.arange(radar.first, state.time[-1], radar.period)
    )
    rows = np.array([round(t / STEP) for t, _ in looks])
    z, R = np.empty((len(rows), 2, runs)), np.empty((len(rows), 2, 2, runs))
    for k, ((_, which), row) in enumerate(zip(looks, rows, strict=True)):
        radar = radars[which]
        north, east = state.north[row] - radar.north, state.east[row] - radar.east
        noise = generator.standard_normal((2, runs))
        distance = np.hypot(north, east) + radar.range_sigma * noise[0]
        azimuth = np.arctan2(east, north) + radar.azimuth_sigma * noise[1]
        cos, sin = np.cos(azimuth), np.sin(azimuth)
        z[k] = radar.north + distance * cos, radar.east + distance * sin
        along, across = radar.range_sigma**2, (distance * radar.azimuth_sigma) ** 2
        mixed = (along - across) * cos * sin
        R[k] = [[along * cos**2 + across * sin**2, mixed], [mixed, along * sin**2 + across * cos**2]]
    time = STEP * rows
    return rows, Measurements(("plots.north", "plots.east"), time, time, z, R)


@lru_cache(maxsize=8)
def flown(seed: int, runs: int, radars: tuple[Radar, ...], tracker: str) -> Found:
    """One tracker on the sixteen flights."""
    parts = []
    for speed in SPEEDS:
        for bank in BANKS:
            flight = Madap(speed, bank).fly(step=STEP)
            state = flight.state
            name = f"madap.{len(radars)}.{speed / KNOT:.0f}.{math.degrees(bank):.0f}"
            generator = stream(seed, 0, 0, name)
            rows, plots_ = seen(radars, state, runs, generator)
            truth = np.array([state.north, state.velocity_north, state.east, state.velocity_east])
            start = truth[:, 0, None] + PRIOR[:, None] * generator.standard_normal((4, runs))
            position, velocity, course = [], [], []
            for epoch in follow(TRACKERS[tracker], plots_, Gaussian(start, np.diag(PRIOR**2)), start=0.0):
                estimate = epoch.estimate
                mean = merge(estimate).mean if isinstance(estimate, Mixture) else estimate.mean
                north, north_rate, east, east_rate = truth[:, rows[epoch.row]]
                position.append(np.hypot(mean[0] - north, mean[2] - east) / NAUTICAL_MILE)
                velocity.append((np.hypot(mean[1], mean[3]) - math.hypot(north_rate, east_rate)) / KNOT)
                off = np.arctan2(mean[3], mean[1]) - math.atan2(east_rate, north_rate)
                course.append(np.degrees(np.angle(np.exp(1j * off))))
            settled = plots_.time >= SETTLED
            turning = flight.phase[rows] == 1
            parts.append([np.array(values)[settled] for values in (position, velocity, course, turning)])
    return Found(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def error(quantity: str, statistic: str, radars: tuple[Radar, ...], tracker: str) -> Any:
    """Measure of the mean, the standard deviation or the RMS of an error over all flights."""

    def measured(seed: int, runs: int) -> Interval:
        values = getattr(flown(seed, min(runs, MOST), radars, tracker), quantity)
        if statistic == "mean":
            return mean_interval(values.mean(axis=0))
        if statistic == "sigma":
            return rmse(((values - values.mean()) ** 2).mean(axis=0))
        return rmse((values**2).mean(axis=0))

    return measured


def share(quantity: str, limit: float, turning: bool, radars: tuple[Radar, ...], tracker: str) -> Any:
    """Measure of the share of epochs with an error within a limit, per cent."""

    def measured(seed: int, runs: int) -> Interval:
        found = flown(seed, min(runs, MOST), radars, tracker)
        chosen = getattr(found, quantity)[found.turning == turning]
        return mean_interval(100.0 * (np.abs(chosen) <= limit).mean(axis=0))

    return measured


def met(text: str, good: int) -> Printed:
    """A published figure that a tracker should meet: as good as its digits, or better."""
    exact = number(text)
    return exact._replace(high=math.inf) if good > 0 else exact._replace(low=-math.inf)


def rows_of(name: str, words: str, printed: Printed, unit: str, where: str, measure: Any) -> Iterator[Claim]:
    """The row that is judged, of the improved models, and the one beside it."""
    for tracker in TRACKERS:
        judged = tracker == "imm"
        yield Claim(
            name if judged else f"{name}_{tracker}",
            words,
            where,
            printed,
            (Reading(tracker.replace("_", " "), measure(tracker)),),
            unit,
            truth="kinematic",
            geometry_by="ours",
            first_runs=10,
            overlooked=not judged,
            note="Radar sites are ours. Refuted: the tracker, made for a landing pattern, falls short.",
        )


def _claims() -> Iterator[Claim]:
    for side, radars, where, figures in (
        ("single", SINGLE, "single radar", ("0.13", "0.13", "12.7", "12.2")),
        ("multi", SEVERAL, "multi-radar", ("0.06", "0.08", "4.4", "9.4")),
    ):
        kinds = (
            ("position", "position", "mean", "NM"),
            ("position_sigma", "position", "sigma", "NM"),
            ("speed", "speed", "rms", "kt"),
            ("heading", "heading", "rms", "deg"),
        )
        for (name, quantity, statistic, unit), printed in zip(kinds, figures, strict=True):
            yield from rows_of(
                f"{side}_{name}",
                f"{quantity} error, {statistic}, {where}",
                met(printed, -1),
                unit,
                where,
                lambda tracker, q=quantity, s=statistic, r=radars: error(q, s, r, tracker),
            )
    for name, quantity, limits, unit, several, single in (
        ("position_shares", "position", (0.25, 1.0), "NM", ("99.5", "100"), ("95.9", "100")),
        ("speed_shares", "speed", (20.0, 70.0), "kt", ("99.6", "100"), ("95.1", "99.4")),
        ("heading_shares", "heading", (10.0, 90.0), "deg", ("98.0", "99.9"), ("95.9", "99.8")),
    ):
        for radars, where, figures in ((SEVERAL, "multi-radar", several), (SINGLE, "single radar", single)):
            for turning, limit, printed in zip((False, True), limits, figures, strict=True):
                part = "manoeuvres" if turning else "straights"
                suffix = ("" if radars is SEVERAL else "_single") + ("_manoeuvre" if turning else "")
                yield from rows_of(
                    name + suffix,
                    f"{quantity} within {limit:g} {unit} on {part}, {where}",
                    met(printed, 1),
                    "%",
                    where,
                    lambda tracker, q=quantity, m=limit, t=turning, r=radars: share(q, m, t, r, tracker),
                )


CLAIMS: tuple[Claim, ...] = tuple(_claims())


def plots(seed: int) -> Iterator[Plot]:
    """The flights; the guidelines have no figure of them."""
    curves = []
    for speed in SPEEDS:
        state = Madap(speed, BANKS[1]).fly(step=STEP).state
        curves.append(Curve(f"{speed / KNOT:.0f} kt", state.north / NAUTICAL_MILE, state.east / NAUTICAL_MILE))
    places = ([r.north / NAUTICAL_MILE for r in SEVERAL], [r.east / NAUTICAL_MILE for r in SEVERAL])
    yield Plot(
        "flights",
        "Four of the sixteen, bank 30 deg",
        "Dots are the radars, chosen here.",
        "north, NM",
        "east, NM",
        (*curves, Curve("radars", *places, "dots")),
        equal=True,
    )
