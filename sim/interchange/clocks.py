"""Stamps of recordings: dates, seconds since 1970, times of day, seconds of a flight; and the flight they belong to."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import NamedTuple

import numpy as np

DAY = 86400.0  # s
EARLIEST = 1e8  # s since 1970: a stamp of this size is a date (1973), a smaller one counts within a day or a flight
MILLISECONDS = 1e11  # from here on a stamp since 1970 counts milliseconds
CLOCK = re.compile(r"(\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d*)?))?")


class Stamps(NamedTuple):
    """When k things were recorded, each after the one before, unless their file may have them in any order."""

    dated: bool  # whether they count from 1970 (UTC); otherwise within a day (UTC), or within a flight
    time: np.ndarray  # (k,) s; those of a day go on beyond midnight

    def in_flight(self, utc: float | None) -> np.ndarray:
        """(k,) s of a flight whose time 0 is ``utc``, s since 1970; None = it was flown at no date.

        A time of day is that of the day which brings it nearest to the flight. A flight at no date has no clock but its
        own, so all stamps are taken for its seconds.
        """
        if utc is None:
            return self.time
        if self.dated:
            return self.time - utc
        apart = self.time - utc % DAY
        if (np.diff(self.time) < 0.0).any():  # in any order: each on the day that brings it nearest
            return np.asarray(apart - DAY * np.round(apart / DAY))
        return np.asarray(apart - DAY * round(float(apart[0]) / DAY))


def read_stamps(cells: Sequence[str], lines: Sequence[int], name: str, rising: bool = True) -> Stamps:
    """The stamps of a column ``name``; ``lines`` are those of its file that the cells come from.

    The first cell says which form all have. Raises ``ValueError`` in one sentence for what is none, and for stamps
    that do not rise, unless they need not; midnight can then not be told from disorder, and times of day stay within
    one day.
    """
    form, read = _form(cells[0])
    try:
        time = np.array(cells, float) if read is float else np.array([*map(read, cells)])
    except ValueError:
        line, cell = next((line, cell) for line, cell in zip(lines, cells, strict=True) if not _reads(read, cell))
        raise ValueError(f"line {line}: '{cell[:40]}' in column '{name}' is no {form}") from None
    if not np.isfinite(time).all():
        raise ValueError(f"line {lines[int(np.argmax(~np.isfinite(time)))]}: the stamp in '{name}' is not finite")
    if read is float and time.min() >= MILLISECONDS:
        time = 1e-3 * time
    dated = bool(time.min() >= EARLIEST)
    if not rising:
        return Stamps(dated, time)
    if not dated:
        time = time + DAY * np.concatenate(([0.0], np.cumsum(np.diff(time) < -0.5 * DAY)))  # midnight has passed
    falling = np.flatnonzero(np.diff(time) <= 0.0)
    if falling.size:
        row = int(falling[0]) + 1
        raise ValueError(
            f"line {lines[row]}: its stamp {cells[row][:40]} is not after that of the line before; sort them by time"
        )
    return Stamps(dated, time)


def _reads(read: Callable[[str], float], cell: str) -> bool:
    try:
        read(cell)
    except ValueError:
        return False
    return True


def _form(cell: str) -> tuple[str, Callable[[str], float]]:
    """What a stamp is called, and what reads it."""
    if CLOCK.fullmatch(cell):
        return "time of day (HH:MM:SS)", _time_of_day
    try:
        float(cell)
    except ValueError:
        return "date and time (ISO 8601)", _date
    return "number of seconds", float


def _time_of_day(cell: str) -> float:
    """Seconds since midnight of HH:MM:SS."""
    found = CLOCK.fullmatch(cell)
    if found is None:
        raise ValueError(cell)
    hours, minutes, seconds = (float(part or 0.0) for part in found.groups())
    if hours >= 24.0 or minutes >= 60.0 or seconds >= 61.0:  # a leap second is one
        raise ValueError(cell)
    return 3600.0 * hours + 60.0 * minutes + seconds


def _date(cell: str) -> float:
    """Seconds since 1970 of a date and time; without a zone it is UTC."""
    read = datetime.fromisoformat(cell)
    return (read if read.tzinfo is not None else read.replace(tzinfo=UTC)).timestamp()


def in_words(time: float, dated: bool) -> str:
    """A stamp for a reader: a date, or seconds."""
    if not dated:
        return f"{time:.1f} s"
    return datetime.fromtimestamp(time, UTC).strftime("%Y-%m-%d %H:%M:%S") + " UTC"
