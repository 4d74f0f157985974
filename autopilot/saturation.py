"""Limiting functions c, c1, c2, c3 of the papers' laws."""

from __future__ import annotations

from typing import Any

import numpy as np


def saturate(value: Any, limit: Any) -> Any:
    """Limit a value to ``-limit .. limit`` [Vasylyev 2003, eq. (4)].

    Plain comparisons for floats (0.3 us; ``np.clip`` takes 14 us on a float), broadcasting for arrays.
    """
    if value.__class__ is limit.__class__ is float:
        return limit if value > limit else -limit if value < -limit else value
    return np.minimum(np.maximum(value, np.negative(limit)), limit)


def rate_limit(previous: Any, wanted: Any, rate: Any, dt: float) -> Any:
    """Move from ``previous`` towards ``wanted`` by at most ``rate * dt``."""
    return previous + saturate(wanted - previous, rate * dt)
