"""Fewer points for a figure than a 30 Hz record has, without losing a peak."""

from __future__ import annotations

import numpy as np

from sim.flight.record import runs

MOST = 500  # stretches in one picture


def peaks(values: np.ndarray, bins: int = 500) -> np.ndarray:
    """Indices of the least and the greatest value in each of ``bins`` equal stretches, and of both ends, in order.

    A stretch without a finite value keeps one index, so that gaps stay gaps.
    """
    count = len(values)
    if count <= 2 * bins:
        return np.arange(count)
    width = -(-count // bins)
    rows = -(-count // width)
    padded = np.full(rows * width, np.nan)
    padded[:count] = values
    table, start = padded.reshape(rows, width), np.arange(rows) * width
    hidden = np.isnan(table)
    low = start + np.argmin(np.where(hidden, np.inf, table), axis=1)
    high = start + np.argmax(np.where(hidden, -np.inf, table), axis=1)
    return np.unique(np.concatenate((low, high, [0, count - 1])))


def where(mask: np.ndarray) -> list[tuple[int, int]]:
    """(first, one past last) of every unbroken stretch of True; stretches too many to be seen apart are joined."""
    found = [(first, last) for first, last in runs(mask) if mask[first]]
    if len(found) <= MOST:
        return found
    width = -(-len(mask) // MOST)
    padded = np.zeros(width * MOST, bool)
    padded[: len(mask)] = mask
    coarse = np.asarray(padded.reshape(MOST, width).any(axis=1))
    return [(a * width, min(b * width, len(mask))) for a, b in runs(coarse) if coarse[a]]
