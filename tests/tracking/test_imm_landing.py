"""The landing pattern of Volovyk 2022 on a kinematic truth of its own: gains over raw plots, leg by leg.

The truth flies a base leg, a level turn at 15 deg of bank with roll-in, and a final on which it slows down at the
glide path; none of the filters' models is exactly true. Gains are ratios of pooled position RMSE. 40 runs: batches of
130 scatter by 1 % (glide path) to 4 % (turn), so 40 runs scatter by 2 to 7 %.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
import pytest

from tracking.gaussian import Gaussian, merge
from tracking.measurement import ConvertedPolar, DebiasedPolar, ExtendedPolar, wrap
from tracking.track import Measurements, follow
from tracking.trackers.imm import InteractingMultipleModel, improved_set, published_set

RUNS = 40
SCAN = 0.7
SIGMA = (30.0, math.radians(1.0))
BASE, TURN, FINAL, GLIDE = range(4)


class Pattern(NamedTuple):
    position: np.ndarray  # (k, 2, runs)
    velocity: np.ndarray
    leg: np.ndarray  # (k, runs)
    radar: tuple[float, float]


def fly(seed: int, side: float, runs: int = RUNS) -> Pattern:
    """Left-hand (side 1) or right-hand (-1) circuit that lands on a course of 180 deg at the origin."""
    rng = np.random.default_rng(seed)
    step, limit, g = 0.1, math.radians(15.0), 9.80665
    x, y, course = np.full(runs, 13_800.0), np.full(runs, 7_000.0), np.full(runs, -0.5 * math.pi)
    speed, bank = np.full(runs, 72.0), np.zeros(runs)
    turning, aligned, gliding = np.zeros((3, runs), dtype=bool)
    positions, velocities, legs = [], [], []
    push = np.zeros((2, runs))
    for i in range(100_000):
        if i % round(SCAN / step) == 0:
            positions.append(np.stack([x, side * y]))
            velocities.append(np.stack([speed * np.cos(course), side * speed * np.sin(course)]))
            legs.append(np.select([gliding, aligned & (x < 12_000.0), turning], [GLIDE, FINAL, TURN], BASE))
            push = 0.1 * rng.standard_normal((2, runs))
            if (x < 0.0).all():
                break
        turning |= y < 69.0**2 / (g * math.tan(limit)) + 1.8 * speed
        aligned |= turning & (np.abs(wrap(course + math.pi)) < math.radians(8.0))
        gliding |= x < 8_600.0
        off = np.where(aligned, -y, x - 13_800.0)
        drift = np.where(aligned, -np.sin(course), np.cos(course)) * speed
        held = np.clip(-math.radians(0.02) * np.clip(off, -400.0, 400.0) - math.radians(0.5) * drift, -limit, limit)
        wanted = np.where(turning & ~aligned, -limit, held)
        bank = bank + step * np.clip((wanted - bank) / 1.5, -math.radians(5.0), math.radians(5.0))
        schedule = np.select([gliding, turning], [58.0, 69.0], 72.0)
        forward = np.clip(schedule - speed, -0.5 * step, 0.5 * step)
        turned = g * np.tan(bank) / speed + (push[1] * np.cos(course) - push[0] * np.sin(course)) / speed
        speed = speed + forward + step * (push[0] * np.cos(course) + push[1] * np.sin(course))
        course = course + step * turned
        x, y = x + step * speed * np.cos(course), y + step * speed * np.sin(course)
    return Pattern(np.array(positions), np.array(velocities), np.array(legs), (-900.0, -150.0 * side))


def observe(
    pattern: Pattern, seed: int, speed_variance: float = 0.05, believed: float | None = None
) -> tuple[Measurements, Gaussian]:
    """Plots and a hand-over whose velocity errors have one variance and are believed to have another."""
    rng = np.random.default_rng(seed)
    north, east = (pattern.position[:, i] - pattern.radar[i] for i in (0, 1))
    exact = np.stack([np.hypot(north, east), np.arctan2(east, north)], axis=1)
    z = exact + np.array(SIGMA)[:, None] * rng.standard_normal(exact.shape)
    R = np.broadcast_to(np.diag(np.square(SIGMA))[None, :, :, None], (len(z), 2, 2, 1))
    time = SCAN * np.arange(len(z))
    P = np.diag([1e3, speed_variance, 1e3, speed_variance])
    start = np.stack([pattern.position[0], pattern.velocity[0]], axis=1).reshape(4, -1)
    mean = start + np.linalg.cholesky(P) @ rng.standard_normal(start.shape)
    prior = Gaussian(mean, P if believed is None else np.diag([1e3, believed, 1e3, believed]))
    return Measurements(("radar.range", "radar.azimuth"), time, time, z, R), prior


class Judged(NamedTuple):
    gain: dict[str, float]  # position, raw / filtered
    azimuth_gain: dict[str, float]
    anees: dict[str, float]  # of the position pair
    error: np.ndarray  # (k, 2, runs)
    probabilities: np.ndarray  # (k, M, runs)


def judge(pattern: Pattern, measurements: Measurements, prior: Gaussian, form, model_set) -> Judged:
    tracker = InteractingMultipleModel(form(position=pattern.radar, height=0.0), model_set)
    error, anees = np.empty(pattern.position.shape), np.empty(pattern.leg.shape)
    probabilities = np.empty((len(error), len(model_set.models), error.shape[-1]))
    for epoch in follow(tracker, measurements, prior):
        mean, cov = merge(epoch.estimate)
        error[epoch.row] = mean[[0, 2]] - pattern.position[epoch.row]
        block = np.moveaxis(cov[np.ix_([0, 2], [0, 2])], -1, 0)
        y = error[epoch.row].T
        anees[epoch.row] = np.einsum("ri,ri->r", y, np.linalg.solve(block, y[..., None])[..., 0]) / 2.0
        probabilities[epoch.row] = epoch.estimate.weights
    distance, azimuth = measurements.z[:, 0], measurements.z[:, 1]
    origin = np.array(pattern.radar)[None, :, None]
    raw = np.stack([distance * np.cos(azimuth), distance * np.sin(azimuth)], axis=1) + origin - pattern.position
    seen = pattern.position - origin
    bearing = np.arctan2(seen[:, 1], seen[:, 0])
    filtered = np.arctan2((seen + error)[:, 1], (seen + error)[:, 0])
    flying = pattern.position[:, 0] > 0.0
    legs = {"all": flying, "base": pattern.leg == BASE, "turn": pattern.leg == TURN}
    legs |= {"final": pattern.leg == FINAL, "glide": (pattern.leg == GLIDE) & flying}

    def rms(values, chosen):
        return math.sqrt(np.square(values)[chosen].mean())

    def distance_of(e):
        return np.hypot(e[:, 0], e[:, 1])

    return Judged(
        {name: rms(distance_of(raw), leg) / rms(distance_of(error), leg) for name, leg in legs.items()},
        {name: rms(wrap(azimuth - bearing), leg) / rms(wrap(filtered - bearing), leg) for name, leg in legs.items()},
        {name: float(anees[leg].mean()) for name, leg in legs.items()},
        error,
        probabilities,
    )


@pytest.fixture(scope="module")
def left():
    pattern = fly(7, 1.0)
    return pattern, *observe(pattern, 8)


def test_published_filter_gains_little_on_the_glide_path(left):
    """The page: 1.27 +- .08 in position, 1.49 +- .09 in azimuth; a second implementation 1.23 and 1.44."""
    result = judge(*left, ConvertedPolar, published_set(0.01))
    assert result.gain["glide"] == pytest.approx(1.27, abs=0.08)
    assert result.azimuth_gain["glide"] == pytest.approx(1.49, abs=0.09)
    assert result.anees["glide"] > 3.0  # and it does not know: the slowing down is taken for a turn
    after = left[0].leg == GLIDE
    window = after & (np.cumsum(after, axis=0) < 35.0 / SCAN)
    declared = (np.where(window, result.probabilities[:, 1], 0.0) > 0.5).any(axis=0)
    assert declared.mean() > 0.8


def test_more_process_noise_repairs_the_published_filter(left):
    result = judge(*left, ConvertedPolar, published_set(0.3))
    assert result.gain["all"] >= 3.8
    assert result.gain["glide"] >= 2.5
    assert all(0.5 < result.anees[leg] < 1.15 for leg in ("base", "turn", "final", "glide"))
    distance = left[0].position[:, 0]
    bins = np.array([900.0, 1500.0, 2500.0, 4000.0, 6000.0, 8000.0])
    rms = [
        math.sqrt(np.square(result.error).sum(axis=1)[(distance > a) & (distance < b)].mean())
        for a, b in itertools.pairwise(bins)
    ]
    assert (np.diff(rms) > 0.0).all()  # in metres it grows more accurate towards touchdown


def test_conversions_and_the_extended_filter_agree(left):
    """Inside the validity bound all are within 5 % of one another in RMSE."""
    gains = [
        judge(*left, form, published_set(0.3)).gain["all"] for form in (ConvertedPolar, DebiasedPolar, ExtendedPolar)
    ]
    assert max(gains) / min(gains) < 1.05


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["left", "right"])
def test_improved_set_on_either_circuit(side):
    """Asked: 4.2 over all legs and 2.9 on the glide path at the lower end of the interval over runs."""
    pattern = fly(9, side)
    result = judge(pattern, *observe(pattern, 10), DebiasedPolar, improved_set(0.01, 0.05))
    assert result.gain["all"] >= 4.2
    assert result.gain["glide"] >= 2.9
    turn = result.probabilities[:, 3 if side > 0.0 else 2]  # a left-hand circuit turns left
    late = (pattern.leg == TURN) & (np.cumsum(pattern.leg == TURN, axis=0) > 20.0 / SCAN)
    assert turn[pattern.leg == BASE].mean() < 0.15
    assert turn[late].mean() > 0.5


def test_published_set_knows_left_turns_only(left):
    pattern = fly(7, -1.0)
    mirrored = judge(pattern, *observe(pattern, 8), ConvertedPolar, published_set(0.01))
    assert mirrored.gain["all"] < 1.0  # worse than no filter at all


def test_an_honest_prior_makes_up_for_a_bad_hand_over(left):
    """Velocity known to 5 m/s: nine tenths of the gain if the prior says so; claiming 0.2 m/s ruins the base leg.

    The base leg's gain is 4.9 against 2.0 in batches of 130; a few runs that diverge decide it, so that batches of 40
    reach a ratio of 0.36 to 0.69.
    """
    pattern = left[0]
    exact, honest, claimed = (
        judge(pattern, *observe(pattern, 8, *prior), ConvertedPolar, published_set(0.01)).gain
        for prior in ((), (25.0,), (25.0, 0.05))
    )
    assert honest["all"] >= 0.9 * exact["all"]
    assert claimed["base"] <= 0.8 * honest["base"]
