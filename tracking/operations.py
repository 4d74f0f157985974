"""What a filter costs: operations counted by numbers that count, and words of memory.

The realisations of `tracking.trackers.elevation` run unchanged on `Number`s; nothing is assumed about how they
multiply. The print charges the inversion of an m x m matrix with m^3 multiplications and as many additions; the
operations really counted stand beside it. Counting is dense, as in the print: multiplications by the zeros and ones
of A and C count too, which flatters the stored gain. A root or an exponential counts as a polynomial.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tracking.trackers.elevation import Model, arbitrary_gain, full, information, stored_gain

Array = Any

REALISATIONS = (1, 2, 3, 4)
FUNCTION = 10  # of either operation for a root or an exponential: a polynomial of degree ten by Horner's rule


class Operations(NamedTuple):
    """Arithmetic of one step; divisions count as multiplications, subtractions as additions, as in the print."""

    multiplications: int
    additions: int


class Words(NamedTuple):
    """Memory in words of one number each."""

    rom: int  # constants, written once
    ram: int  # what one step hands to the next


@dataclass
class Tally:
    """The running count that the `Number`s of one calculation share."""

    multiplications: int = 0
    additions: int = 0

    def total(self) -> Operations:
        return Operations(self.multiplications, self.additions)


class Number:
    """A float that writes every operation on it into its tally."""

    __slots__ = ("tally", "value")

    def __init__(self, value: float, tally: Tally) -> None:
        self.value = value
        self.tally = tally

    def _product(self, value: float) -> Number:
        self.tally.multiplications += 1
        return Number(value, self.tally)

    def _sum(self, value: float) -> Number:
        self.tally.additions += 1
        return Number(value, self.tally)

    def __mul__(self, other: Any) -> Number:
        return self._product(self.value * _value(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Number:
        return self._product(self.value / _value(other))

    def __rtruediv__(self, other: Any) -> Number:
        return self._product(_value(other) / self.value)

    def __add__(self, other: Any) -> Number:
        return self._sum(self.value + _value(other))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Number:
        return self._sum(self.value - _value(other))

    def __rsub__(self, other: Any) -> Number:
        return self._sum(_value(other) - self.value)

    def __gt__(self, other: Any) -> bool:
        """A comparison is a subtraction."""
        self.tally.additions += 1
        return self.value > _value(other)

    def exp(self) -> Number:
        """As `numpy.exp` calls it."""
        return self._function(math.exp(self.value))

    def sqrt(self) -> Number:
        """As `numpy.sqrt` calls it."""
        return self._function(math.sqrt(self.value))

    def _function(self, value: float) -> Number:
        self.tally.multiplications += FUNCTION
        self.tally.additions += FUNCTION
        return Number(value, self.tally)


def _value(number: Any) -> float:
    return float(number.value) if isinstance(number, Number) else float(number)


def numbers(array: Array, tally: Tally) -> Array:
    """The array with every entry a `Number` of this tally."""
    array = np.asarray(array, dtype=float)
    counting = np.empty(array.shape, dtype=object)
    for index, value in np.ndenumerate(array):
        counting[index] = Number(float(value), tally)
    return counting


def values(array: Array) -> Array:
    """The floats of an array of `Number`s."""
    return np.vectorize(_value, otypes=[float])(array)


def charged_inverse(S: Array) -> Array:
    """Inverse of a matrix of `Number`s, charged with n^3 of either operation [Volovyk 2018, eqs. (24)-(25)]."""
    tally, n = S[0, 0].tally, len(S)
    tally.multiplications += n**3
    tally.additions += n**3
    return numbers(np.linalg.inv(values(S)), tally)


def counted_inverse(S: Array) -> Array:
    """Inverse by Gauss-Jordan elimination without pivoting, enough for a covariance; every operation counts."""
    n = len(S)
    S = S.copy()
    inverse = np.empty_like(S)
    inverse[:] = 0.0
    for k in range(n):
        inverse[k, k] = 1.0
    for k in range(n):
        pivot = 1.0 / S[k, k]
        S[k, k + 1 :] = S[k, k + 1 :] * pivot
        inverse[k, :k] = inverse[k, :k] * pivot
        inverse[k, k] = pivot
        for i in range(n):
            if i == k:
                continue
            factor = S[i, k]
            S[i, k + 1 :] = S[i, k + 1 :] - S[k, k + 1 :] * factor
            inverse[i, :k] = inverse[i, :k] - inverse[k, :k] * factor
            inverse[i, k] = 0.0 - factor * pivot
    return inverse


def counted(
    realisation: int, states: int, channels: int, inverse: Callable[[Array], Array] = charged_inverse
) -> Operations:
    """Operations of one step of a realisation, counted while it runs on dense random matrices.

    Parameters
    ----------
    inverse : `charged_inverse`, the print's convention, or `counted_inverse`, what an elimination really takes.
    """
    random = np.random.default_rng(0)  # the count does not depend on the values; zeros must not occur
    tally = Tally()

    def dense(rows: int, columns: int) -> Array:
        return numbers(random.uniform(0.5, 1.5, (rows, columns)), tally)

    def covariance(n: int) -> Array:
        return numbers(np.eye(n) + 0.1, tally)

    model = Model(dense(states, states), covariance(states), dense(channels, states), covariance(channels))
    x, P, z = dense(states, 1)[:, 0], covariance(states), dense(channels, 1)[:, 0]
    K = dense(states, channels)
    if realisation == 1:
        full(x, P, z, model, inverse)
    elif realisation == 2:
        arbitrary_gain(x, P, z, K, model)
    elif realisation == 3:
        information(x, P, z, model, inverse)
    elif realisation == 4:
        stored_gain(x, z, K, model.A, model.C)
    else:
        raise ValueError("realisation must be 1, 2, 3 or 4")
    return tally.total()


class Bank(NamedTuple):
    """M models side by side with their weights, as `interacting` takes and gives it."""

    weights: Array  # (M,)
    means: Array  # (M, n)
    covs: Array  # (M, n, n)


def interacting(
    bank: Bank, switching: Array, models: list[Model], z: Array, inverse: Callable[[Array], Array] = charged_inverse
) -> tuple[Bank, Array, Array]:
    """One cycle of interacting multiple models in plain matrices, with the merged mean and covariance.

    The 15 steps of the print [Volovyk 2022, table 1] with the errata of `tracking.gaussian`; here to be counted. Rows
    of ``switching`` are "from".
    """
    joint = switching * bank.weights[:, None]
    predicted = joint.sum(axis=0)
    shares = joint / predicted
    means, covs, likelihoods = [], [], []
    for model, share in zip(models, shares.T, strict=True):
        x, P = _moments(bank._replace(weights=share))
        x, P = model.A @ x, model.A @ P @ model.A.T + model.Q
        PC = P @ model.C.T
        S = model.C @ PC + model.R
        information = inverse(S)
        K, residual = PC @ information, z - model.C @ x
        means.append(x + K @ residual)
        covs.append((np.eye(len(x)) - K @ model.C) @ P)
        density = np.exp(-0.5 * (residual @ information @ residual))
        likelihoods.append(density / np.sqrt((2.0 * math.pi) ** len(z) * _determinant(S)))
    posterior = predicted * np.array(likelihoods)
    updated = Bank(posterior / posterior.sum(), np.array(means), np.array(covs))
    return updated, *_moments(updated)


def _moments(bank: Bank) -> tuple[Array, Array]:
    """Mean and covariance of a mixture."""
    mean = bank.weights @ bank.means
    off = bank.means - mean
    spread = bank.covs + off[:, :, None] * off[:, None]
    return mean, (bank.weights[:, None, None] * spread).sum(axis=0)


def _determinant(S: Array) -> Array:
    """By elimination without pivoting, enough for a covariance."""
    S, product = S.copy(), S[0, 0]
    for k in range(1, len(S)):
        for i in range(k, len(S)):
            S[i, k:] = S[i, k:] - S[k - 1, k:] * (S[i, k - 1] / S[k - 1, k - 1])
        product = product * S[k, k]
    return product


def counted_interacting(count: int, states: int, channels: int) -> Operations:
    """Operations of one cycle of ``count`` interacting models, counted while it runs on dense matrices."""
    tally = Tally()
    plain = np.eye(states) + 0.1
    model = Model(plain, plain, np.full((channels, states), 0.7) + np.eye(channels, states), np.eye(channels) + 0.1)
    means = np.arange(float(count))[:, None] + np.ones(states)
    bank = Bank(*(numbers(part, tally) for part in (np.full(count, 1.0 / count), means, np.stack([plain] * count))))
    counting = Model(*(numbers(matrix, tally) for matrix in model))
    switching = numbers(np.full((count, count), 1.0 / count), tally)
    interacting(bank, switching, [counting] * count, numbers(np.ones(channels), tally))
    return tally.total()


def full_filter_operations(n: int, m: int) -> Operations:
    """Operations M1, S1 of realisation 1 with n states and m channels [Volovyk 2018, eqs. (24)-(25)]."""
    common = 3 * n**3 + 2 * n**2 * m + 2 * n * m**2 + m**3
    return Operations(common + n**2 + 2 * n * m, common - n**2 - n)


def stored_gain_operations(n: int, m: int) -> Operations:
    """Operations M4, S4 of realisation 4 with n states and m channels [Volovyk 2018, eqs. (24)-(25)]."""
    return Operations(n**2 + 2 * n * m, n**2 - n + 2 * n * m)


def saving(n: int, m: int) -> tuple[float, float]:
    """Shares K_M, K_S of multiplications and additions that a stored gain saves [Volovyk 2018, eqs. (24), (25)]."""
    all_of_it, rest = full_filter_operations(n, m), stored_gain_operations(n, m)
    return 1.0 - rest.multiplications / all_of_it.multiplications, 1.0 - rest.additions / all_of_it.additions


def memory(realisation: int, states: int, channels: int, gains: int = 0) -> Words:
    """Words of memory of a realisation [Volovyk 2018, resources of the variants].

    Constants are A, B Q B', C and R (B Q B' is stored, as the counts assume); the state is x, and P where it is
    needed.

    Parameters
    ----------
    gains : number of stored gains (variants 2 and 4): the steps of the leg, or those until the gain has settled.
    """
    n, m = states, channels
    schedule = gains * n * m
    if realisation == 1 or realisation == 3:
        return Words(2 * n**2 + n * m + m**2, n + n**2)
    if realisation == 2:
        return Words(2 * n**2 + n * m + m**2 + schedule, n + n**2)
    if realisation == 4:
        return Words(n**2 + n * m + schedule, n)
    raise ValueError("realisation must be 1, 2, 3 or 4")
