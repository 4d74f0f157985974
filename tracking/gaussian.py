"""All Kalman algebra, once: matrix axes first, batch axes last.

A mean has shape (n, *B), a covariance (n, n, *C); B and C broadcast. ``()`` is one run, ``(N,)`` an ensemble,
``(M, N)`` hypotheses by runs. A covariance gets a run axis only once something run-dependent entered it, so a linear
filter computes one gain for all runs. Where there is a hypothesis axis, C has as many axes as B (of size one where
shared): `lift` inserts them.

Covariances are symmetric to the last bit because one triangle of each is computed and written twice. What mixtures of
many runs share is shorter in `tracking.packed`, which is made of the same parts.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

Array = Any

FEW = 16  # matrices along the last axis: below, one BLAS call each costs less than setting up einsum
LEAST = 1e-200  # weight of a hypothesis that still has digits when its moments are multiplied by it
LOG_TWO_PI = math.log(2.0 * math.pi)


class Gaussian(NamedTuple):
    """A state estimate."""

    mean: Array  # (n, *B)
    cov: Array  # (n, n, *C)


class Mixture(NamedTuple):
    """Gaussians along the axis after the matrix axes, with their weights."""

    weights: Array  # (M, *B), sum to one over M
    mean: Array  # (n, M, *B)
    cov: Array  # (n, n, M, *C)


class Innovation(NamedTuple):
    """What one measurement said, whitened by the innovation covariance.

    An absent channel is NaN in ``white`` and adds nothing to ``nis`` and ``log_likelihood``.
    """

    white: Array  # (m, *B)
    nis: Array  # (*B), sum of squares of white
    log_likelihood: Array  # (*B)


def lift(array: Array, matrix_axes: int, batch_axes: int) -> Array:
    """View with axes of size one inserted after the matrix axes until there are ``batch_axes`` batch axes."""
    array = np.asarray(array, dtype=float)
    missing = matrix_axes + batch_axes - array.ndim
    if missing <= 0:
        return array
    shape = array.shape
    return array.reshape(shape[:matrix_axes] + (1,) * missing + shape[matrix_axes:])


def predict(gaussian: Gaussian, F: Array, Q: Array, u: Array | None = None) -> Gaussian:
    """Propagate through ``x+ = F x + u`` with process noise Q [Volovyk 2022, eq. (16)].

    Parameters
    ----------
    gaussian : state (n, *B) and covariance (n, n, *C).
    F, Q : (n, n, *C), broadcasting.
    u : (n, *B), the known input, already multiplied by its input matrix.
    """
    mean = _apply(F, gaussian.mean)
    if u is not None:
        mean = mean + u
    P, F, Q = _aligned(gaussian.cov, F, Q)
    half = _product(F, P)  # F P
    return Gaussian(mean, _plus(_mirror(_product(F, half.swapaxes(0, 1))), Q))  # F (F P)' + Q


def update(gaussian: Gaussian, z: Array, H: Array, R: Array) -> tuple[Gaussian, Innovation]:
    """Condition on ``z = H x + v``, v ~ N(0, R), through the whitened innovation [Volovyk 2022, eqs. (15), (17)-(19)].

    With ``L L' = H P H' + R`` and ``W = P H' L^-T`` the posterior is ``x + W white``, ``P - W W'``: symmetric by
    construction, and ``white = L^-1 (z - H x)`` gives the log-likelihood without another factorisation.

    Parameters
    ----------
    z : (m, *B); NaN marks an absent channel of that run.
    H : (m, n, *C); R : (m, m, *C).
    """
    absent = _absent(z)
    heard = None if absent is None else _heard(absent)
    if heard is not None:
        if not heard.size:
            return gaussian, _nothing_heard(z, gaussian.mean)
        posterior, innovation = update(gaussian, z[heard], H[heard], _entries(R, heard))
        return posterior, _scattered(innovation, heard, len(z))
    residual = z - _apply(H, gaussian.mean)
    if absent is not None:
        H, R, residual = _without(absent, H, R, residual)
    P, H, R = _aligned(gaussian.cov, H, R)
    rows, other = _rows(P, H, R, residual)
    posterior, innovation = _condition(Gaussian(gaussian.mean, P), rows, other)
    if absent is None:
        return posterior, innovation
    return posterior, _present(innovation, absent)


def merge(mixture: Mixture) -> Gaussian:
    """Moment-match a mixture by one Gaussian [Volovyk 2022, eqs. (20)-(21)].

    Erratum: printed the "extrapolated" covariance, used the filtered one, because the weights are those after the
    measurement.
    """
    weights, means, covs = mixture
    mean = np.einsum("m...,im...->i...", weights, means)
    return Gaussian(mean, np.einsum("m...,ijm...->ij...", weights, _second_moments(means - mean[:, None], covs)))


def interact(mixture: Mixture, switching: Array) -> Mixture:
    """Mix hypotheses by their switching probabilities before a prediction [Volovyk 2022, eqs. (6), (22)-(23)].

    Rows of ``switching`` (M, M), or (M, M, *B) where runs differ, are "from", columns "to". The returned
    weights are the predicted ones. A hypothesis whose predicted weight is zero, or so small that moments times it have
    no digits, keeps its own estimate.

    Erratum: printed the spread about the filtered mean of the target model, used the spread about its mixed mean,
    because a covariance is taken about the mean that goes with it.
    Erratum: printed mixing weights normalised over the target (and without theta in table 1, step 2), used
    ``theta_ij mu_i`` normalised over the source i, because the weights of one mixed estimate sum to one.
    """
    weights, means, covs = mixture
    n, (upper, _, _, whole) = len(means), triangle_of(len(means))
    moments = mixed_moments(weights, means, covs.reshape(n * n, *covs.shape[2:]).take(upper, 0), switching)
    return Mixture(moments[0], moments[1 : n + 1], moments[n + 1 :].take(whole, 0))


def mixed_moments(weights: Array, means: Array, triangles: Array, switching: Array) -> Array:
    """What `interact` gives: weight, mean and covariance of each hypothesis, (1 + n + n (n + 1) / 2, M, *B).

    From weights (M, *B), means (n, M, *B) and covariances (n (n + 1) / 2, M, *B), each as its `triangle_of`.
    """
    n, (_, row, column, _) = len(means), triangle_of(len(means))
    # About any point c among the means: sum_i w_ij (P_i + d_i d_i') - e_j e_j' with d_i = x_i - c, e_j = mixed x_j - c
    # and w_ij = theta_ij mu_i / predicted_j. Moments about the origin would lose |x|^2 eps. Theta serves all moments,
    # so that these sums are one product; of symmetric matrices one triangle is mixed.
    centre = means[:, :1]
    moments = np.empty((1 + n + len(row), *_common(weights.shape, means.shape[1:], triangles.shape[1:])))
    moments[0], deviation, second = 1.0, moments[1 : n + 1], moments[n + 1 :]
    np.subtract(means, centre, out=deviation)
    np.multiply(deviation.take(row, 0), deviation.take(column, 0), out=second)
    second += triangles
    moments *= weights
    mixed = _switched(switching, moments)
    predicted, mean, second = mixed[0], mixed[1 : n + 1], mixed[n + 1 :]
    certain = None if np.minimum.reduce(predicted, axis=None) > LEAST else ~(predicted <= LEAST)
    mixed[1:] *= 1.0 / (predicted if certain is None else np.where(certain, predicted, 1.0))
    second -= mean.take(row, 0) * mean.take(column, 0)
    mean += centre
    if certain is not None:
        mixed[1:] = np.where(certain, mixed[1:], stacked(means, triangles))
    return mixed


def stacked(above: Array, below: Array) -> Array:
    """Arrays (p, *B) and (q, *C) one over the other, (p + q, *D)."""
    stack = np.empty((len(above) + len(below), *_common(above.shape[1:], below.shape[1:])))
    stack[: len(above)], stack[len(above) :] = above, below
    return stack


def _switched(switching: Array, values: Array) -> Array:
    """Sum over the hypotheses i before of ``theta_ij`` times their values (r, M, *B), for each j after."""
    if switching.ndim > 2:
        return np.einsum("ij...,ri...->rj...", switching, values)
    if values.ndim == 2:  # a single run
        return values @ switching
    r, M = values.shape[:2]
    return (switching.T @ values.reshape(r, M, -1)).reshape(values.shape)


def _common(*shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The shape to which all of these broadcast."""
    first, *others = shapes
    return first if others.count(first) == len(others) else np.broadcast_shapes(*shapes)


@lru_cache
def triangle_of(n: int) -> tuple[Array, Array, Array, Array]:
    """A symmetric matrix (n, n) as the n (n + 1) / 2 entries of one triangle, the diagonal first.

    Their places in the matrix, row by row; their rows; their columns; and (n, n) which of them each entry is.
    """
    row, column = np.triu_indices(n)
    order = np.argsort(row != column, kind="stable")
    row, column = row[order], column[order]
    whole = np.zeros((n, n), dtype=int)
    whole[row, column] = whole[column, row] = np.arange(len(row))
    return row * n + column, row, column, whole


@lru_cache
def _bordered(n: int) -> tuple[Array, Array]:
    """Entries of a vector (n + 1) to be multiplied: each with the last, the `triangle_of` n, the last with itself."""
    _, row, column, _ = triangle_of(n)
    return np.concatenate([range(n), row, [n]]), np.concatenate([[n] * n, column, [n]])


def reweigh(weights: Array, log_likelihood: Array) -> tuple[Array, Array]:
    """Posterior weights (M, *B) and log-likelihood (*B) of a mixture by Bayes' rule in the log domain.

    A weight of zero stays zero; far outliers, where every likelihood underflows, still rank the hypotheses.

    Erratum: [Volovyk 2022, table 1, step 13] printed the weights before the switching in the numerator, used the
    predicted ones, because only those make the posterior sum to one.
    """
    best = np.maximum.reduce(log_likelihood)
    posterior = np.exp(log_likelihood - best)
    posterior *= weights
    total = np.add.reduce(posterior)
    if not (total > 1e-200).all():  # the best hypothesis has no weight, or a lost run is NaN
        supported = np.where(weights > 0.0, log_likelihood, -np.inf)
        best = supported.max(axis=0)
        posterior = np.exp(supported - best) * weights
        total = posterior.sum(axis=0)
    posterior /= total
    return posterior, best + np.log(total)


def update_mixture(mixture: Mixture, z: Array, H: Array, R: Array) -> tuple[Mixture, Innovation]:
    """Condition every hypothesis and its weight on one measurement (m, *B) [Volovyk 2022, eqs. (15)-(19)].

    H and R as in `update`, or with the hypothesis axis after the matrix axes where they differ between hypotheses.
    The innovation is that of the moment-matched prediction, its log-likelihood that of the mixture itself.
    """
    absent = _absent(z)
    heard = None if absent is None else _heard(absent)
    if heard is not None:
        if not heard.size:
            return mixture, _nothing_heard(z, mixture.mean[:, 0])
        updated, innovation = update_mixture(mixture, z[heard], H[heard], _entries(R, heard))
        return updated, _scattered(innovation, heard, len(z))
    batch = mixture.mean.ndim - 2
    z, absent = z[:, None], None if absent is None else absent[:, None]
    H, R = _with_hypotheses(H, batch), _with_hypotheses(R, batch)
    residual = z - _apply(H, mixture.mean)
    if absent is not None:
        H, R, residual = _without(absent, H, R, residual)
    rows, other = _rows(mixture.cov, H, lift(R, 2, batch + 1), residual)
    white = matched(mixture.weights, residual, rows)
    conditioned, each = _condition(Gaussian(mixture.mean, mixture.cov), rows, other)
    weights, log_likelihood = reweigh(mixture.weights, each.log_likelihood)
    innovation = Innovation(white, np.add.reduce(white * white), log_likelihood)
    posterior = Mixture(weights, conditioned.mean, conditioned.cov)
    if absent is None:
        return posterior, innovation
    return posterior, _present(innovation, absent[:, 0])


def matched(weights: Array, residual: Array, rows: Array) -> Array:
    """The whitened innovation (m, *B) of the moment-matched prediction, from the `_rows` of the hypotheses.

    As of `merge`, with sums in place of its contractions, which for so few numbers cost more.
    """
    m, S = len(rows), rows[:, : len(rows)]
    merged = np.empty((m, m + 1, *_common(weights.shape, residual.shape[1:], S.shape[2:])[1:]))
    mean = np.add.reduce(weights * residual, 1, out=merged[:, m])
    spread = _times(_second_moments(residual - mean[:, None], S), weights)
    np.add.reduce(spread, 2, out=merged[:, :m])
    _eliminate(merged)
    return merged[:, m]


def whitened(cov: Array, error: Array) -> Array:
    """``L^-1 error`` (m, *B) with ``L L' = cov`` (m, m, *C): independent and of unit variance."""
    batch = cov.shape[2:]
    if error.shape[1:] != batch:
        batch = np.broadcast_shapes(batch, error.shape[1:])
    rows = _beside(batch, cov, error[:, None])
    _eliminate(rows)
    return rows[:, -1]


def _rows(P: Array, H: Array, R: Array, residual: Array) -> tuple[Array, Array | None]:
    """The rows (S, H P, z - H x) with S = H P H' + R, (m, m + n + 1, *B).

    Where one covariance serves runs with residuals of their own (m, *B), these stand beside the rows and not in them.
    """
    m, n = H.shape[:2]
    batch = residual.shape[1:]
    if P.shape[2:] != batch or not _covers(residual, R[0]):
        cross = _product(H, P)
        S = _plus(_product(H, cross.swapaxes(0, 1)), R)
        if S.shape[2:] != batch:
            shape = (m, *np.broadcast_shapes(batch, S.shape[2:]))
            return _beside(S.shape[2:], S, cross), np.array(np.broadcast_to(residual, shape))
        return _beside(batch, S, cross, residual[:, None]), None
    rows = np.empty((m, m + n + 1, *batch))
    cross = _product(H, P, out=rows[:, m:-1])
    _product(H, cross.swapaxes(0, 1), out=rows[:, :m])
    rows[:, :m] += R
    rows[:, -1] = residual
    return rows, None


def _condition(prior: Gaussian, rows: Array, other: Array | None) -> tuple[Gaussian, Innovation]:
    """``x + W white``, ``P - W W'`` with ``W' = L^-1 H P``, ``L L' = S``, from the `_rows`, which it changes."""
    mean, cov = prior
    m, n = len(rows), len(mean)
    _, row, column, whole = triangle_of(n)
    if other is None:
        correction, innovation = corrections(rows)
        step, triangle = correction[:n], correction[n:]
    else:
        volume, W = _eliminate(rows, other), rows[:, m:]
        step, triangle, nis = _apply(W.swapaxes(0, 1), other), _gram(W, row, column), np.add.reduce(other * other)
        innovation = Innovation(other, nis, _log_likelihood(nis, volume, m))
    reduced = triangle.take(whole, 0)
    np.subtract(cov, reduced, out=reduced)
    variances = reduced.reshape(n * n, *reduced.shape[2:])[:: n + 1]  # a view of the diagonal
    np.maximum(variances, 0.0, out=variances)  # after an exact measurement they are zero up to rounding
    return Gaussian(mean + step, reduced), innovation


def corrections(rows: Array) -> tuple[Array, Innovation]:
    """``W white`` over the `triangle_of` ``W W'``, (n + n (n + 1) / 2, *B), and the innovation.

    One elimination turns the `_rows` (S, H P, z - H x), which it changes, into (L', W', white).
    """
    m = len(rows)
    volume, told = _eliminate(rows), rows[:, m:]
    products = _gram(told, *_bordered(told.shape[1] - 1))
    return products[:-1], Innovation(told[:, -1], products[-1], _log_likelihood(products[-1], volume, m))


def _log_likelihood(nis: Array, volume: Array, rows: int) -> Array:
    """Of so many numbers at a squared distance of ``nis``, with ``volume`` = det L."""
    log_likelihood = -0.5 * nis - np.log(volume)
    log_likelihood -= 0.5 * rows * LOG_TWO_PI
    return log_likelihood


def _gram(rows: Array, first: Array, second: Array) -> Array:
    """Products of the entries ``first`` and ``second`` (p,) of each row, summed over the rows (m, n, *B): (p, *B)."""
    row, *others = rows
    total = row.take(first, 0)
    total *= row.take(second, 0)
    for row in others:
        part = row.take(first, 0)
        part *= row.take(second, 0)
        total += part
    return total


def _beside(batch: tuple[int, ...], *blocks: Array) -> Array:
    """Copy of matrices (m, ..., *C) side by side, all with the batch axes ``batch``."""
    rows, first = np.empty((len(blocks[0]), sum(block.shape[1] for block in blocks), *batch)), 0
    for block in blocks:
        rows[:, first : first + block.shape[1]] = block
        first += block.shape[1]
    return rows


def _eliminate(rows: Array, other: Array | None = None) -> Array:
    """Cholesky's factorisation ``S = L L'`` of rows (m, m + ..., *C) that begin with S, in place; det L.

    S becomes L' (what is below its diagonal is not to be read), and what stands beside it, or in ``other`` (m, *B), is
    multiplied by L^-1. Row by row, over all runs at once: m is small and the batch is long.
    """
    volume: Array = 1.0
    for i in range(len(rows)):
        row = rows[i, i:]  # views: to write to rows[i] itself would copy it once more
        pivot = np.sqrt(row[0])
        row /= pivot
        for k in range(i + 1, len(rows)):
            below = rows[k, k:]
            below -= row[k - i] * row[k - i :]
        if other is not None:
            other[i] /= pivot
            for k in range(i + 1, len(rows)):
                other[k] -= row[k - i] * other[i]
        volume = pivot if i == 0 else volume * pivot
    return volume


def _absent(z: Array) -> Array | None:
    """Which channels (m, *B) are absent, or None where all are present (one cheap test in the usual case)."""
    total = np.add.reduce(z, axis=None)
    if total == total:  # only NaN differs from itself
        return None
    absent = np.isnan(z)
    return absent if absent.any() else None


def _heard(absent: Array) -> Array | None:
    """Rows that any run has, or None where no row is absent from all runs: silent sensors cost nothing."""
    silent = absent.reshape(len(absent), -1).all(axis=1)
    return np.flatnonzero(~silent) if silent.any() else None


def _entries(R: Array, heard: Array) -> Array:
    """R of some rows: a view where they follow each other."""
    first, last = heard[0], heard[-1] + 1
    return R[first:last, first:last] if last - first == len(heard) else R[np.ix_(heard, heard)]


def _scattered(innovation: Innovation, heard: Array, rows: int) -> Innovation:
    """An innovation of some rows as one of all rows (m, *B), NaN where nothing was heard."""
    white = np.full((rows, *innovation.white.shape[1:]), np.nan)
    white[heard] = innovation.white
    return Innovation(white, innovation.nis, innovation.log_likelihood)


def _nothing_heard(z: Array, mean: Array) -> Innovation:
    """The innovation of a measurement (m, *B) without any channel; mean (n, *B)."""
    batch = np.broadcast_shapes(z.shape[1:], mean.shape[1:])
    return Innovation(np.full((len(z), *batch), np.nan), np.zeros(batch), np.zeros(batch))


def _without(absent: Array, H: Array, R: Array, residual: Array) -> tuple[Array, Array, Array]:
    """H, R and residual that make the absent channels (m, *B) say nothing: zero row, unit variance, zero residual."""
    batch = absent.ndim - 1
    H = np.where(absent[:, None], 0.0, lift(H, 2, batch))
    identity = lift(np.eye(len(absent)), 2, batch)
    R = np.where(absent[:, None] | absent[None, :], identity, lift(R, 2, batch))
    return H, R, np.where(absent, 0.0, residual)


def _present(innovation: Innovation, absent: Array) -> Innovation:
    """The innovation with absent channels marked and without their constant in the log-likelihood."""
    white = np.where(absent, np.nan, innovation.white)
    missing = np.isnan(white).sum(axis=0)
    return Innovation(white, innovation.nis, innovation.log_likelihood + 0.5 * LOG_TWO_PI * missing)


def _second_moments(deviation: Array, covs: Array) -> Array:
    """``P + d d'`` of every hypothesis."""
    return _plus(deviation[:, None] * deviation, covs)


def _mirror(cov: Array) -> Array:
    """Copy the upper triangle onto the lower one, in place."""
    for i in range(1, len(cov)):
        cov[i, :i] = cov[:i, i]
    return cov


def _covers(large: Array, small: Array) -> bool:
    """Whether ``small`` broadcasts into the shape of ``large``."""
    into, shape = large.shape, small.shape
    if into == shape:
        return True
    tail = into[max(len(into) - len(shape), 0) :]
    return tail == shape or (
        len(shape) <= len(into) and all(size in (1, whole) for size, whole in zip(shape, tail, strict=True))
    )


def _plus(fresh: Array, other: Array) -> Array:
    """Sum, in place where it fits: temporaries beyond 128 KiB are mapped afresh by the C library at every use."""
    if _covers(fresh, other):
        fresh += other
        return fresh
    return fresh + other


def _times(fresh: Array, other: Array) -> Array:
    """Product, in place where it fits."""
    if _covers(fresh, other):
        fresh *= other
        return fresh
    return fresh * other


def _aligned(P: Array, A: Array, R: Array) -> tuple[Array, Array, Array]:
    """Three matrices with the same number of batch axes."""
    if P.ndim == A.ndim == R.ndim:
        return P, A, R
    batch = max(P.ndim, A.ndim, R.ndim) - 2
    return lift(P, 2, batch), lift(A, 2, batch), lift(R, 2, batch)


def _with_hypotheses(matrix: Array, batch: int) -> Array:
    """A matrix per run with a hypothesis axis of size one, if it has none yet."""
    if matrix.ndim == 2 or matrix.ndim == batch + 3:
        return matrix
    return matrix[:, :, None]


def _apply(A: Array, x: Array) -> Array:
    """``A x`` for A (p, n, *C) and x (n, *B)."""
    if A.shape[1] == 1:
        return lift(A[:, 0], 1, x.ndim - 1) * x
    if A.ndim == 2 or (A.shape[-1] == 1 and A.ndim == x.ndim + 1):
        return _blas(A, x)
    if A.ndim == 3 and A.shape[2:] == x.shape[1:] and A.shape[2] < FEW:
        return (A.transpose(2, 0, 1) @ x.T[:, :, None])[:, :, 0].T
    return np.einsum("ij...,j...->i...", A, x)


def _product(A: Array, X: Array, out: Array | None = None) -> Array:
    """``A X`` for A (p, n, *C) and X (n, k, *C)."""
    if A.shape[1] == 1 and A.ndim == X.ndim:
        return np.multiply(A, X, out=out)
    if A.ndim == 2 or (A.shape[-1] == 1 and A.ndim == X.ndim):
        return _blas(A, X, out)
    if A.ndim == 3 and A.shape[2:] == X.shape[2:] and A.shape[2] < FEW:
        into = None if out is None else out.transpose(2, 0, 1)
        return np.matmul(A.transpose(2, 0, 1), X.transpose(2, 0, 1), out=into).transpose(1, 2, 0)
    return np.einsum("ij...,jk...->ik...", A, X, out=out)


_RUNS_LAST = tuple((*range(1, axes - 1), 0, axes - 1) for axes in range(2, 9))


def _blas(A: Array, X: Array, out: Array | None = None) -> Array:
    """The same for a matrix A that all runs (the last axis) share: one BLAS call per column and hypothesis."""
    if A.ndim > 2:
        A = A[..., 0].transpose(*range(2, A.ndim - 1), 0, 1)
    if X.ndim == 1:
        return A @ X
    hypotheses = A.shape[:-2]
    if hypotheses and X.shape[-2] < hypotheses[0]:  # one X for all of them
        X = np.broadcast_to(X, (*X.shape[:-2], *hypotheses, X.shape[-1]))
    order = _RUNS_LAST[X.ndim - 2]
    product = np.empty((A.shape[-2], *X.shape[1:])) if out is None else out
    np.matmul(A, X.transpose(order), out=product.transpose(order))
    return product
