"""Filters cheaper and dearer than two hypotheses, as a micro-computer would be programmed: accuracy against operations.

The authors name as their next work filters that use how much larger an anomaly is than the noise, and that cost less.
Each filter here is one step of plain arithmetic, so that it runs on arrays of runs, where its errors are measured, and
on numbers that count (`tracking.operations`). Angles are in deviations of the measurement and rates in deviations per
period, so that a prediction only adds. Both sides of a decision are counted.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache, lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from sim.claims.angle_channel import INCREMENT, PRIOR, SIGMA, VARIANCE, drawn
from sim.claims.papers.kychak2011.experiment import (
    FACTOR,
    LONG,
    PRINTED_CHAIN,
    SETTLED,
    SHARE,
    STEPS,
    Chain,
    bursts,
    squared,
)
from sim.randomness import stream
from tracking.intervals import Interval, gain
from tracking.operations import Number, Operations, Tally
from tracking.trackers.elevation import PERIOD, Model, gain_schedule, increments
from tracking.trackers.switching_noise import stationary

Q = (INCREMENT * PERIOD) ** 2 / VARIANCE  # of the rate, in a step
SCALE = np.array([1.0, PERIOD]) / SIGMA
GATE, HUBER, FREEDOM, TURNS = 3.0, 1.345, 4.0, 3  # deviations, deviations, of Student's t, of its scale in a step
ODDS = SHARE / (1.0 - SHARE)
INDEPENDENT, BURSTS = "independent anomalies", "bursts of 40 scans"


class Step(NamedTuple):
    """Angle and rate, variance of the angle, covariance, variance of the rate, and weights of the accuracies."""

    x: Any
    rate: Any
    p: Any
    c: Any
    q: Any
    weights: tuple[Any, ...] = ()


def chosen(condition: Any, one: Any, other: Any) -> Any:
    """One or the other, of arrays entry by entry; a number that counts stays one."""
    if isinstance(condition, np.ndarray):
        return np.where(condition, one, other)
    value = one if condition else other
    return Number(value, other.tally) if isinstance(other, Number) and not isinstance(value, Number) else value


def predicted(s: Step) -> Step:
    """One period later."""
    c = s.c + s.q
    return s._replace(x=s.x + s.rate, p=s.p + s.c + c, c=c, q=s.q + Q)


def corrected(s: Step, pull: Any, n: Any) -> Step:
    """Moved by (p, c) times ``pull``, the covariance less (p, c) (p, c)' times ``n``."""
    low, side = s.p * n, s.c * n
    return s._replace(
        x=s.x + s.p * pull, rate=s.rate + s.c * pull, p=s.p - s.p * low, c=s.c - s.c * low, q=s.q - s.c * side
    )


def kalman(s: Step, z: Any) -> Step:
    """The Kalman filter."""
    s = predicted(s)
    k = 1.0 / (s.p + 1.0)
    return corrected(s, k * (z - s.x), k)


@lru_cache(maxsize=1)
def settled() -> tuple[float, float, float]:
    """Gains of angle and rate that the Kalman filter comes to, and the square of the gate about its innovation."""
    A, noise = increments(2, 1.0, 1.0, math.sqrt(Q))
    gains, covariances = gain_schedule(
        np.diag(SCALE**2 * np.diag(PRIOR.cov)), Model(A, noise, np.eye(1, 2), np.eye(1)), 1000
    )
    p, c, q = covariances[-1, 0, 0], covariances[-1, 0, 1], covariances[-1, 1, 1]
    return float(gains[-1, 0, 0]), float(gains[-1, 1, 0]), float(GATE**2 * (p + 2.0 * c + q + 1.0))


def stored_and_gated(s: Step, z: Any) -> Step:
    """A stored constant gain, and nothing of what lies beyond a constant gate."""
    angle_gain, rate_gain, limit = settled()
    x = s.x + s.rate
    v = z - x
    v = chosen(v * v > limit, 0.0, v)
    return s._replace(x=x + angle_gain * v, rate=s.rate + rate_gain * v)


def gated(s: Step, z: Any) -> Step:
    """The Kalman filter without what lies beyond the gate about its innovation."""
    s = predicted(s)
    v, k = z - s.x, 1.0 / (s.p + 1.0)
    far = v * v * k > GATE**2
    k = chosen(far, 0.0, k)
    return corrected(s, k * v, k)


def huber(s: Step, z: Any) -> Step:
    """Huber's loss: what is far pulls with a constant force and says nothing of the covariance."""
    s = predicted(s)
    k = 1.0 / (s.p + 1.0)
    pull = k * (z - s.x)  # also what an update leaves of the innovation, in deviations
    far = pull * pull > HUBER**2
    force = chosen(pull > 0.0, HUBER, -HUBER)
    return corrected(s, chosen(far, force, pull), chosen(far, 0.0, k))


def student(s: Step, z: Any) -> Step:
    """Student's t by variational Bayes: the scale of the noise is estimated in a few turns."""
    s = predicted(s)
    v, k = z - s.x, 1.0 / (s.p + 1.0)
    square = v * v
    for _ in range(TURNS - 1):
        left = 1.0 - s.p * k
        weight = (FREEDOM + 1.0) / (FREEDOM + left * (square * left + s.p))
        k = weight / (s.p * weight + 1.0)
    return corrected(s, k * v, k)


def missed(s: Step, z: Any) -> Step:
    """Two hypotheses, an anomaly taken as a missed measurement: its factor is so large that it says nothing."""
    s = predicted(s)
    v, S = z - s.x, s.p + 1.0
    k = 1.0 / S
    square = v * v
    with np.errstate(over="ignore"):
        w = 1.0 / (1.0 + ODDS / FACTOR * np.sqrt(S) * np.exp(0.5 * k * square))
    m = w * k
    return corrected(s, m * v, m - square * (m * (k - m)))


def two(s: Step, z: Any) -> Step:
    """Two hypotheses in closed form: the moments of (13), (14) without the two channels."""
    s = predicted(s)
    v, k, other = z - s.x, 1.0 / (s.p + 1.0), 1.0 / (s.p + FACTOR**2)
    square, apart = v * v, k - other
    with np.errstate(over="ignore"):
        w = 1.0 / (1.0 + ODDS * np.sqrt(other / k) * np.exp(0.5 * square * apart))
    share = w * apart
    m = other + share
    return corrected(s, m * v, m - square * (share * (apart - share)))


def as_printed(s: Step, z: Any) -> Step:
    """Two hypotheses as printed: two channels of the Kalman filter, their weights (12), the merger (13), (14)."""
    s = predicted(s)
    v = z - s.x
    channels, likelihoods = [], []
    for share, variance in ((1.0 - SHARE, 1.0), (SHARE, FACTOR**2)):
        k = 1.0 / (s.p + variance)
        channels.append(corrected(s, k * v, k))
        likelihoods.append(share * np.sqrt(k) * np.exp(-0.5 * k * v * v))
    total = 1.0 / (likelihoods[0] + likelihoods[1])
    weights = [likelihood * total for likelihood in likelihoods]
    one, other = channels
    x, rate = (weights[0] * a + weights[1] * b for a, b in ((one.x, other.x), (one.rate, other.rate)))
    spread = []
    for weight, channel in zip(weights, channels, strict=True):
        dx, dr = channel.x - x, channel.rate - rate
        spread.append([weight * part for part in (channel.p + dx * dx, channel.c + dx * dr, channel.q + dr * dr)])
    p, c, q = (a + b for a, b in zip(*spread, strict=True))
    return Step(x, rate, p, c, q)


def hypotheses(s: Step, z: Any, factors: tuple[float, ...], chain: tuple[tuple[float, ...], ...]) -> Step:
    """Any number of accuracies that follow a Markov chain (10), (11), in closed form."""
    s = predicted(s)
    v, number = z - s.x, range(len(factors))
    gains = [1.0 / (s.p + factor**2) for factor in factors]
    square = v * v
    weights = [sum((s.weights[i] * chain[i][j] for i in number[1:]), s.weights[0] * chain[0][j]) for j in number]
    found = [w * np.sqrt(k) * np.exp(-0.5 * square * k) for w, k in zip(weights, gains, strict=True)]
    total = 1.0 / sum(found[1:], found[0])
    weights = [one * total for one in found]
    shares = [w * k for w, k in zip(weights, gains, strict=True)]
    m = sum(shares[1:], shares[0])
    squares = [share * k for share, k in zip(shares, gains, strict=True)]
    n = m - square * (sum(squares[1:], squares[0]) - m * m)
    return corrected(s, m * v, n)._replace(weights=tuple(weights))


TWO, THREE = (1.0, FACTOR), (1.0, 5.0, FACTOR)


def three_levels(chain: Chain) -> tuple[tuple[float, ...], ...]:
    """The chain of two accuracies with its anomalies on two levels, each as frequent, that do not change in a burst."""
    (stay, enter), (leave, last) = chain
    if chain[0] == chain[1]:
        return ((stay, 0.5 * enter, 0.5 * enter),) * 3
    return (stay, 0.5 * enter, 0.5 * enter), (leave, last, 0.0), (leave, 0.0, last)


class Cheap(NamedTuple):
    """A filter of the study, with the chain that it is told."""

    step: Callable[[Step, Any], Step]
    weights: tuple[float, ...] = ()


def told(factors: tuple[float, ...], chain: Any) -> Cheap:
    """Hypotheses on accuracies that follow a chain."""
    return Cheap(partial(hypotheses, factors=factors, chain=chain), tuple(stationary(np.array(chain))))


FILTERS: dict[str, Cheap] = {
    "stored gain with a gate": Cheap(stored_and_gated),
    "Kalman filter": Cheap(kalman),
    "gate at 3 deviations": Cheap(gated),
    "Huber at 1.345 deviations": Cheap(huber),
    "two hypotheses, an anomaly as a missed measurement": Cheap(missed),
    "Student's t, 4 degrees of freedom": Cheap(student),
    "two hypotheses, closed form": Cheap(two),
    "two hypotheses, as printed": Cheap(as_printed),
    "two hypotheses with the chain of the bursts": told(TWO, bursts(LONG)),
    "three hypotheses": told(THREE, three_levels(PRINTED_CHAIN)),
    "three hypotheses with the chain of the bursts": told(THREE, three_levels(bursts(LONG))),
}
CHAINS = {INDEPENDENT: PRINTED_CHAIN, BURSTS: bursts(LONG)}


@cache
def operations(name: str) -> Operations:
    """Of one step, counted while it runs; that they do not depend on the values is tested."""
    tally = Tally()
    filter_ = FILTERS[name]
    x, rate, p, c, q, z, *weights = (
        Number(value, tally) for value in (1.0, 0.1, 0.2, 0.05, 0.1, 1.5, *filter_.weights)
    )
    filter_.step(Step(x, rate, p, c, q, tuple(weights)), z)
    return tally.total()


def all_operations(name: str) -> int:
    """Multiplications and additions of one step together."""
    return sum(operations(name))


@lru_cache(maxsize=32)
def squares(seed: int, runs: int, anomalies: str, name: str) -> Any:
    """Mean squared errors (runs,) of the angle in the steady state, in variances of the measurement."""
    generator = stream(seed, 0, 0, f"kychak2011.cheaper.{anomalies}")
    truth, seen = drawn(generator, runs, STEPS, PRIOR, CHAINS[anomalies], (1.0, FACTOR))
    ones = np.ones(runs)
    mean, spread = SCALE * PRIOR.mean, SCALE**2 * np.diag(PRIOR.cov)
    filter_ = FILTERS[name]
    s = Step(
        mean[0] * ones, mean[1] * ones, spread[0] * ones, 0.0 * ones, spread[1] * ones,
        tuple(weight * ones for weight in filter_.weights),
    )  # fmt: skip
    total = np.zeros(runs)
    for k, z in enumerate(seen.z[:, 0] / SIGMA):
        s = filter_.step(s, z)
        if k >= SETTLED:
            total += (s.x - truth[k] / SIGMA) ** 2
    return total / (STEPS - SETTLED)


def gained(name: str, anomalies: str) -> Any:
    """Measure of the variance of the Kalman filter over that of a filter, in the steady state."""

    def measured(seed: int, runs: int) -> Interval:
        return squared(gain(*(squares(seed, runs, anomalies, one) for one in ("Kalman filter", name))))

    return measured
