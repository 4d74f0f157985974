"""A mixture as one array, for the interacting models of many runs: means, and one triangle of each covariance.

Half the numbers and half the calls of the general algebra of `tracking.gaussian`, where the motion and the measurement
are matrices that all runs share: these then act on mean and covariance as one matrix each, which is made once.
Everything else takes the general way.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from tracking import gaussian
from tracking.gaussian import (
    Gaussian,
    Innovation,
    Mixture,
    corrections,
    lift,
    matched,
    mixed_moments,
    reweigh,
    stacked,
    triangle_of,
    update_mixture,
)

Array = Any


class Packed(NamedTuple):
    """Hypotheses with their weights and moments."""

    weights: Array  # (M, *B), sum to one over M
    moments: Array  # (n + n (n + 1) / 2, M, *B): means, and the `triangle_of` each covariance

    @property
    def mean(self) -> Array:
        """(n, M, *B), a view."""
        return self.moments[: _states(len(self.moments))]

    @property
    def cov(self) -> Array:
        """(n, n, M, *B), a copy."""
        return unpack(self).cov


def pack(mixture: Mixture) -> Packed:
    """Of a mixture."""
    weights, mean, cov = mixture
    n = len(mean)
    return Packed(weights, stacked(mean, cov.reshape(n * n, *cov.shape[2:]).take(triangle_of(n)[0], 0)))


def unpack(packed: Packed) -> Mixture:
    """The mixture; its means are a view."""
    weights, moments = packed
    n = _states(len(moments))
    return Mixture(weights, moments[:n], moments[n:].take(triangle_of(n)[3], 0))


def interact(packed: Packed, switching: Array) -> Packed:
    """As `tracking.gaussian.interact`."""
    weights, moments = packed
    n = _states(len(moments))
    mixed = mixed_moments(weights, moments[:n], moments[n:], switching)
    return Packed(mixed[0], mixed[1:])


class SharedMotion(NamedTuple):
    """A motion that is the same for all runs and at every step of one length: ``A moments + q`` of each hypothesis."""

    A: Array  # (M, n + n (n + 1) / 2, n + n (n + 1) / 2)
    q: Array  # (n + n (n + 1) / 2, M, 1)


def shared_motion(F: Array, Q: Array) -> SharedMotion:
    """``x+ = F x``, ``P+ = F P F' + Q`` of every hypothesis; F, Q (n, n, M)."""
    n, count = len(F), F.shape[2]
    upper, row, column, whole = triangle_of(n)
    A = np.zeros((count, n + len(upper), n + len(upper)))
    A[:, :n, :n] = np.moveaxis(F, 2, 0)
    for (k, l), entry in np.ndenumerate(whole):  # (i, j) of F P F' is the sum of F_ik P_kl F_jl
        A[:, n:, n + entry] += (F[row, k] * F[column, l]).T
    q = np.zeros((n + len(upper), count, 1))
    q[n:, :, 0] = Q.reshape(n * n, count)[upper]
    return SharedMotion(A, q)


def predict_shared(packed: Packed, motion: SharedMotion) -> Packed:
    """`predict` by a motion that all runs share."""
    weights, moments = packed
    flat = moments.reshape(*moments.shape[:2], -1)
    after = np.empty(flat.shape)
    np.matmul(motion.A, flat.swapaxes(0, 1), out=after.swapaxes(0, 1))
    after += motion.q
    return Packed(weights, after.reshape(moments.shape))


def predict(packed: Packed, F: Array, Q: Array, u: Array | None = None) -> Packed:
    """As `tracking.gaussian.predict`, for all hypotheses; F, Q (n, n, M, *C), u (n, M, *B)."""
    weights, mean, cov = unpack(packed)
    return pack(Mixture(weights, *gaussian.predict(Gaussian(mean, cov), F, Q, u)))


def update(packed: Packed, z: Array, H: Array, R: Array) -> tuple[Packed, Innovation]:
    """As `tracking.gaussian.update_mixture`, with the same z, H and R."""
    weights, moments = packed
    n, m, batch = _states(len(moments)), len(z), moments.ndim - 2
    whole = math.isfinite(np.add.reduce(z, axis=None)) and z.shape[1:] == moments.shape[2:]
    if not whole or not _comes_again(H) or R.ndim > batch + 2:
        updated, innovation = update_mixture(unpack(packed), z, H, R)
        return pack(updated), innovation
    rows = (_rows_of(H.tobytes(), H.shape) @ moments.reshape(len(moments), -1)).reshape(m, -1, *moments.shape[1:])
    residual = rows[:, -1]
    np.subtract(z[:, None], residual, out=residual)
    S = rows[:, :m]
    S += lift(R, 2, batch)[:, :, None]
    white = matched(weights, residual, rows)
    correction, each = corrections(rows)
    step, triangle = correction[:n], correction[n:]
    step += moments[:n]
    np.subtract(moments[n:], triangle, out=triangle)
    variances = triangle[:n]
    np.maximum(variances, 0.0, out=variances)  # after an exact measurement they are zero up to rounding
    weights, log_likelihood = reweigh(weights, each.log_likelihood)
    return Packed(weights, correction), Innovation(white, np.add.reduce(white * white), log_likelihood)


def _comes_again(H: Array) -> bool:
    """Whether H is a constant, which is what nobody may write to, and the same for all runs and hypotheses."""
    return H.ndim == 2 and not H.flags.writeable and H.dtype == float


@lru_cache
def _states(numbers: int) -> int:
    """n of n + n (n + 1) / 2 numbers."""
    return (math.isqrt(9 + 8 * numbers) - 3) // 2


@lru_cache(maxsize=256)
def _rows_of(H: bytes, shape: tuple[int, ...]) -> Array:
    """``(H P H', H P, H x)`` row by row as a matrix times the moments, (m (m + n + 1), K)."""
    m, n = shape
    look, (upper, _, _, whole) = np.frombuffer(H).reshape(shape), triangle_of(n)
    made = np.zeros((m, m + n + 1, n + len(upper)))
    made[:, -1, :n] = look
    for (k, l), entry in np.ndenumerate(whole):
        made[:, :m, n + entry] += look[:, None, k] * look[None, :, l]
        made[:, m + l, n + entry] += look[:, k]
    return made.reshape(-1, made.shape[2])
