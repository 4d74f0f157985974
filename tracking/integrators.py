"""A chain of integrators whose last state is correlated in time: an angle, its rate, and what changes the rate."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

Array = Any

# Nodes and weights of Gauss and Legendre on 0..1. A sum of outer products is a covariance whatever the interval, and
# six points hold ten digits up to an interval of one correlation time.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


def response(order: int, memory: float, time: Array) -> list[Array]:
    """Every state's response to a unit last state that decays with ``memory``."""
    x = time / memory
    first = -memory * np.expm1(-x)
    return [memory * (time - first), first, np.exp(-x)][3 - order :]


def integrators(order: int, memory: float, density: float, dt: Array) -> tuple[Array, Array]:
    """(F, Q), both (n, n, *B), of a chain whose last state decays and is driven by noise [Glistin, two-state block].

    Erratum: printed (1 - alpha tau), used exp(-alpha tau), because the first-order form grows without bound when a
    block has waited longer than 2 / alpha.

    Parameters
    ----------
    order : 2 or 3 states        memory : s, correlation time of the last one, 1 / alpha
    density : its white noise, per second        dt : s, () or (*B)
    """
    if np.ndim(dt) == np.ndim(density) == 0:
        return _integrators_of_one(order, memory, density, float(dt))
    return _integrators_of(order, memory, density, np.asarray(dt, dtype=float))


@lru_cache(maxsize=4096)
def _integrators_of_one(order: int, memory: float, density: float, dt: float) -> tuple[Array, Array]:
    F, Q = _integrators_of(order, memory, density, np.asarray(dt))
    F.flags.writeable = Q.flags.writeable = False
    return F, Q


def _integrators_of(order: int, memory: float, density: float, dt: Array) -> tuple[Array, Array]:
    F = np.zeros((order, order, *dt.shape))
    for i in range(order - 1):
        F[i, i] = 1.0
    if order == 3:
        F[0, 1] = dt
    F[:, -1] = response(order, memory, dt)
    g = np.stack(response(order, memory, dt[..., None] * _NODES))
    return F, density * dt * np.einsum("i...q,j...q,q->ij...", g, g, _WEIGHTS)


def ahead(mean: Array, order: int, memory: float, dt: Array) -> tuple[Array, ...]:
    """The mean of the chain dt later."""
    decay = response(order, memory, dt)
    last = mean[-1]
    moved = [mean[i] + decay[i] * last for i in range(order - 1)]
    if order == 3:
        moved[0] = moved[0] + dt * mean[1]
    return (*moved, decay[-1] * last)
