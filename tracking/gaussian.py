"""All Kalman algebra, once: matrix axes first, batch axes last.

A mean has shape (n, *B), a covariance (n, n, *C); B and C broadcast. ``()`` is one run, ``(N,)`` an ensemble,
``(M, N)`` hypotheses by runs. A covariance gets a run axis only once something run-dependent entered it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np


class Gaussian(NamedTuple):
    """A state estimate."""

    mean: Any  # (n, *B)
    cov: Any  # (n, n, *C)


class Mixture(NamedTuple):
    """Gaussians along the axis after the matrix axes, with their weights."""

    weights: Any  # (M, *B)
    mean: Any  # (n, M, *B)
    cov: Any  # (n, n, M, *C)


class Innovation(NamedTuple):
    """What one measurement said, whitened by the innovation covariance."""

    white: Any  # (m, *B)
    nis: Any  # (*B), sum of squares of white
    log_likelihood: Any  # (*B)


def predict(gaussian: Gaussian, F: Any, Q: Any, u: Any = None) -> Gaussian:
    """Propagate through ``x+ = F x + u`` with process noise Q. Shapes (n, n, *C), (n, n, *C), (n, *B)."""
    mean = np.einsum("ij...,j...->i...", F, gaussian.mean)
    if u is not None:
        mean = mean + u
    cov = np.einsum("ij...,jk...,lk...->il...", F, gaussian.cov, F) + Q
    return Gaussian(mean, cov)


def update(gaussian: Gaussian, z: Any, H: Any, R: Any) -> tuple[Gaussian, Innovation]:
    """Condition on ``z = H x + v``, v ~ N(0, R). Shapes (m, *B), (m, n, *C), (m, m, *C)."""
    raise NotImplementedError
