"""Time stamps of recordings: ISO 8601, and seconds, milli-, micro- or nanoseconds since 1970."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

FIRST, LAST = 0.0, 4102444800.0  # s: 1970 to 2100
SCALES = (1.0, 1e-3, 1e-6, 1e-9)  # of what counts since 1970
YEAR = 3e7  # s: a count of less since 1970 is a time of day, or of the recording


def numbers(cells: Sequence[Any] | np.ndarray) -> np.ndarray:
    """(k,) numbers of cells as they stand in a file; NaN for an empty cell, and for what is no number."""
    if isinstance(cells, np.ndarray):
        return cells
    try:
        return np.array([float(text) if text else math.nan for text in cells])
    except ValueError:
        return np.array([_number(text) for text in cells])


def _number(text: str | None) -> float:
    try:
        return float(text or "nan")
    except ValueError:
        return math.nan


def stamps(cells: Sequence[Any] | np.ndarray) -> np.ndarray:
    """(k,) of time stamps: s since 1970 of a date, numbers as they stand. A date without a zone is in UTC."""
    if isinstance(cells, np.ndarray):
        return cells
    return np.array([_instant(text) for text in cells])


def _instant(text: str | None) -> float:
    try:
        found = datetime.fromisoformat((text or "").strip())
    except ValueError:
        return _number(text)
    return (found if found.tzinfo is not None else found.replace(tzinfo=UTC)).timestamp()


def since_1970(count: np.ndarray) -> np.ndarray:
    """(k,) s of numbers that are seconds or finer since 1970: the unit with which they lie between 1970 and 2100.

    Raises ``ValueError`` for times of day, which have no date, and for what is no time.
    """
    finite = count[np.isfinite(count)]
    if not finite.size:
        raise ValueError("no row has a time: stamps are ISO 8601, or seconds or milliseconds since 1970")
    middle = float(np.median(finite))
    if 0.0 <= middle < YEAR:
        raise ValueError(
            f"its times are near {middle:.0f}, a time of day or of the recording and no date: stamps are ISO 8601, or "
            "seconds or milliseconds since 1970"
        )
    scale = next((scale for scale in SCALES if FIRST <= middle * scale < LAST), None)
    if scale is None:
        raise ValueError(f"its times are near {middle:g}, which is no number of seconds or less since 1970")
    found = count * scale
    return np.where((found >= FIRST) & (found < LAST), found, np.nan)
