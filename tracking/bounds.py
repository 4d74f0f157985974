"""What no tracker, or no tracker told more, can beat: four recursions that look alike and are not the same.

All of them carry a covariance, not its inverse, so that process noise may be singular:
``C+ = [(F C F' + Q)^-1 + J]^-1``, J the information of the measurements. They differ in what is averaged:

=============================  ==================================================  =============================
name                           average                                             what it is
=============================  ==================================================  =============================
`posterior_bound`              J over truths, then one recursion                   bound, on the mean square error
                                                                                   of every tracker over the
                                                                                   truths of the declared model
`trajectory_averaged_riccati`  the recursion of each truth                         no bound; near what is achieved
                                                                                   where the geometry varies
`oracle_riccati`               none: one fixed truth, the tracker knows its turns  reference on a simulated flight
`known_modes_bound`            the recursion of each mode sequence                 bound on jump-Markov systems,
                                                                                   loose: the modes are known
=============================  ==================================================  =============================
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from tracking.gaussian import lift
from tracking.intervals import Interval

Array = Any


def information(H: Array, R: Array, detection_probability: float = 1.0) -> Array:
    """Information ``Pd H' R^-1 H`` (n, n, *B) of one measurement.

    Scaling by Pd keeps it a bound: the covariance is convex in the information, so the mean over which epochs were
    detected is never better than the mean information.

    Parameters
    ----------
    H : (m, n, *B), the Jacobian of the measurement at the truth.
    R : (m, m, *B), or R over the relative Fisher information of non-Gaussian noise (`relative_fisher_information`).
    """
    if not 0.0 <= detection_probability <= 1.0:
        raise ValueError("detection_probability must lie between 0 and 1")
    H, R = np.asarray(H, dtype=float), np.asarray(R, dtype=float)
    weight = np.moveaxis(np.linalg.inv(np.moveaxis(R, (0, 1), (-2, -1))), (-2, -1), (0, 1))
    batch = max(H.ndim, weight.ndim) - 2
    H, weight = lift(H, 2, batch), lift(weight, 2, batch)
    return detection_probability * np.einsum("ai...,ab...,bj...->ij...", H, weight, H)


def polar_jacobian(north: Array, east: Array, channels: tuple[str, ...]) -> Array:
    """Jacobian H (2, n, *B) of (distance, azimuth) at (north, east) (*B) from the sensor.

    Bounds stay in the polar domain, where R is constant: no information then hides in its dependence on the state,
    and converting the measurement cannot change it.
    """
    north, east = np.broadcast_arrays(np.asarray(north, dtype=float), np.asarray(east, dtype=float))
    distance = np.hypot(north, east)
    H = np.zeros((2, len(channels), *distance.shape))
    i, j = channels.index("north"), channels.index("east")
    H[0, i], H[0, j] = north / distance, east / distance
    H[1, i], H[1, j] = -east / distance**2, north / distance**2
    return H


def relative_fisher_information(weights: Sequence[float], sigmas: Sequence[float]) -> float:
    """Fisher information of a mixture of zero-mean Gaussians, times the variance of its narrowest component.

    Information ``integral p'^2 / p``. Dividing the nominal R by the returned number gives the R of a Gaussian that
    says as much: 0.7450 for weights 0.8, 0.2 and sigmas 1, 30.
    """
    weight, sigma = np.asarray(weights, dtype=float), np.asarray(sigmas, dtype=float)
    if (weight < 0.0).any() or abs(weight.sum() - 1.0) > 1e-12:
        raise ValueError("weights must not be negative and must sum to one")
    if not (sigma > 0.0).all():
        raise ValueError("sigmas must be positive")
    sigma = sigma / sigma.min()

    def integrand(v: float) -> float:
        log_density = np.log(weight, where=weight > 0.0, out=np.full_like(weight, -np.inf))
        log_density = log_density - np.log(sigma) - 0.5 * (v / sigma) ** 2 - 0.5 * math.log(2.0 * math.pi)
        best = log_density.max()
        share = np.exp(log_density - best)
        score = v * float((share / sigma**2).sum() / share.sum())
        return float(score**2 * share.sum() * math.exp(best))

    edges = np.unique(np.concatenate([[0.0], *(np.array([1.0, 3.0, 6.0, 12.0]) * s for s in sigma)]))
    from scipy.integrate import quad  # half a second to import, and rarely asked for

    pieces = (quad(integrand, low, high, epsabs=1e-12)[0] for low, high in pairwise(edges))
    return 2.0 * float(sum(pieces))


def riccati(C: Array, F: Array, Q: Array, J: Array) -> Array:
    """One step ``[(F C F' + Q)^-1 + J]^-1`` of the covariance (n, n, *B), without inverting a singular Q or J."""
    C, F, Q, J = (np.asarray(matrix, dtype=float) for matrix in (C, F, Q, J))
    batch = max(matrix.ndim for matrix in (C, F, Q, J)) - 2
    C, F, Q, J = (lift(matrix, 2, batch) for matrix in (C, F, Q, J))
    predicted = np.einsum("ij...,jk...,lk...->il...", F, C, F) + Q
    identity = lift(np.eye(len(C)), 2, batch)
    reduced = identity + np.einsum("ij...,jk...->ik...", predicted, J)
    reduced, predicted = np.broadcast_arrays(reduced, predicted)
    left, right = (np.moveaxis(matrix, (0, 1), (-2, -1)) for matrix in (reduced, predicted))
    updated = np.moveaxis(np.linalg.solve(left, right), (-2, -1), (0, 1))  # (1 + P J)^-1 P
    return 0.5 * (updated + updated.swapaxes(0, 1))


def posterior_bound(prior: Array, F: Array, Q: Array, J: Array) -> Array:
    """Posterior Cramer-Rao bound (k, n, n) of a linear motion, after each of k measurements.

    On the mean square error over truths that are drawn from the declared prior, motion and noise.

    Parameters
    ----------
    prior : (n, n).
    F, Q : (n, n), or (k, n, n).
    J : (k, n, n), or (k, n, n, N) for N truths, over which it is averaged.
    """
    J = np.asarray(J, dtype=float)
    return _recursion(prior, F, Q, J if J.ndim == 3 else J.mean(axis=-1))


def trajectory_averaged_riccati(prior: Array, F: Array, Q: Array, J: Array) -> Array:
    """Mean (k, n, n) over truths of the Riccati covariance along each, J (k, n, n, N): not a bound.

    Where the geometry varies from truth to truth, `posterior_bound` is ruled by the few that pass near the sensor and
    is far below what anything can reach; this is not.
    """
    return _recursion(prior, F, Q, J).mean(axis=-1)


def oracle_riccati(prior: Array, F: Array, Q: Array, J: Array) -> Array:
    """Riccati covariance (k, n, n) along one fixed truth by a tracker that knows its manoeuvres, F (k, n, n).

    A reference line for a simulated flight, no bound: the flight was not drawn from any process noise Q.
    """
    return _recursion(prior, F, Q, J)


def known_modes_bound(
    prior: Array, transition: Callable[[Array], tuple[Array, Array]], modes: Array, J: Array
) -> Array:
    """Cramer-Rao bound (k, n, n) of a jump-Markov system whose modes are known: a bound, and a loose one.

    Parameters
    ----------
    transition : gives F, Q (n, n, N) for modes (N,).
    modes : (k, N), drawn from the Markov chain.
    J : (n, n), or (k, n, n).
    """
    C, bounds = np.asarray(prior, dtype=float), []
    for epoch, mode in enumerate(modes):
        F, Q = transition(mode)
        C = riccati(C, F, Q, J if np.ndim(J) == 2 else J[epoch])
        bounds.append(C.mean(axis=-1))
    return np.stack(bounds)


def efficiency(bound: Array, error: Interval, components: tuple[int, ...]) -> Interval:
    """Root of the trace of a bound (n, n), or (k, n, n) averaged over epochs, over a measured RMSE with its interval.

    1 where the bound is reached.
    """
    trace = np.einsum("...ii->...", np.asarray(bound)[..., components, :][..., components])
    root = math.sqrt(float(np.mean(trace)))
    return Interval(root / error.value, root / error.high, root / error.low, error.runs)


def _recursion(prior: Array, F: Array, Q: Array, J: Array) -> Array:
    """Covariance after each of the k measurements of J (k, n, n, *B)."""
    C = np.asarray(prior, dtype=float)
    J = np.asarray(J, dtype=float)
    return np.stack([C := riccati(C, *matrices) for matrices in _epochs(F, Q, J)])


def _epochs(F: Array, Q: Array, J: Array) -> Iterator[tuple[Array, Array, Array]]:
    F, Q = np.asarray(F, dtype=float), np.asarray(Q, dtype=float)
    for epoch, row in enumerate(J):
        yield F if F.ndim == 2 else F[epoch], Q if Q.ndim == 2 else Q[epoch], row
