"""Lines of one height, and what lies between two heights, over a rectangular grid."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np


def lines(x: np.ndarray, y: np.ndarray, height: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
    """x and y of the lines on which ``height`` (y, x) has a value, with NaN between them."""
    from contourpy import contour_generator

    found = contour_generator(x, y, np.ma.masked_invalid(height)).lines(level)
    gap = np.full((1, 2), np.nan)
    points = np.concatenate([part for line in found for part in (np.asarray(line), gap)]) if found else gap
    return points[:, 0], points[:, 1]


def regions(x: np.ndarray, y: np.ndarray, height: np.ndarray, low: float, high: float) -> list[np.ndarray]:
    """Rings (n, 2) about all that lies between two heights; a ring within another is a hole."""
    from contourpy import FillType, contour_generator

    generator = contour_generator(x, y, np.ma.masked_invalid(height), fill_type=FillType.OuterOffset)
    found: Any = generator.filled(low, high)  # its type hangs on what was asked
    return [outer[begin:end] for outer, offset in zip(*found, strict=True) for begin, end in itertools.pairwise(offset)]
