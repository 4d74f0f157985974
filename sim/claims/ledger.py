"""A claim with every way to read it, and its row: printed, measured, interval, runs, verdict."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

from sim.claims.verdict import Printed, borderline, verdict
from tracking.intervals import Interval

MOST_RUNS = 4000
FULL = 4  # times the runs of the quick form, to begin with
FLIGHTS, MOST_FLIGHTS, DRAWS = 6, 48, 20  # of a row on JSBSim: flights of the quick form, at most, noise draws of each


class Reading(NamedTuple):
    """One way to understand a sentence or one case that it speaks of."""

    name: str
    measure: Callable[[int, int], Interval]  # of seed and number of runs


@dataclass(frozen=True)
class Claim:
    """What a paper says, in our words, and how it is measured; the first reading is the one that a row quotes."""

    name: str
    words: str
    where: str
    printed: Printed | None
    readings: tuple[Reading, ...]
    unit: str = ""
    truth: Literal["model", "kinematic", "jsbsim"] = "model"
    geometry_by: Literal["paper", "ours", "none"] = "none"  # who chose the path that is flown
    paper_runs: int | None = None
    draws: int = 1  # of noise within each run, which counts once
    first_runs: int = 50  # of the quick form
    most_runs: int = MOST_RUNS  # fewer where a run is long and the verdict is settled by them
    overlooked: bool = False  # the paper does not say it: measured, not judged
    note: str = ""


OVER_FLIGHTS: dict[str, Any] = {"first_runs": FLIGHTS, "most_runs": MOST_FLIGHTS, "draws": DRAWS, "paper_runs": None}


def flown_too(claim: Claim, readings: tuple[Reading, ...], note: str, **changes: Any) -> tuple[Claim, Claim]:
    """A claim, and the same where a six-degree-of-freedom aircraft flies: words, place and print are one.

    Its runs are flights, as `jsbsim_flights.flights` draws them, and its intervals are over flights.
    """
    changes = {**OVER_FLIGHTS, **changes}
    return claim, replace(claim, name=f"{claim.name}_jsbsim", readings=readings, truth="jsbsim", note=note, **changes)


class Measured(NamedTuple):
    """A reading with its value."""

    reading: str
    value: float
    low: float
    high: float
    runs: int


class Row(NamedTuple):
    """One line of the ledger."""

    paper: str
    claim: Claim
    seed: int
    measured: tuple[Measured, ...]

    @property
    def verdict(self) -> str | None:
        """None where the paper says nothing."""
        return None if self.claim.overlooked else verdict([m.value for m in self.measured], self.claim.printed)

    @property
    def borderline(self) -> bool:
        """Whether other draws may judge otherwise."""
        return not self.claim.overlooked and borderline([m[1:4] for m in self.measured], self.claim.printed)

    def plain(self) -> dict[str, Any]:
        """As ``claims --json`` writes it."""
        quoted = self.measured[0] if self.measured else Measured("", math.nan, math.nan, math.nan, 0)
        return {
            "paper": self.paper,
            "claim": self.claim.name,
            "words": self.claim.words,
            "where": self.claim.where,
            "printed": None if self.claim.printed is None else self.claim.printed.text,
            "measured": quoted.value,
            "unit": self.claim.unit,
            "low": quoted.low,
            "high": quoted.high,
            "n": quoted.runs,
            "draws": self.claim.draws,
            "paper_n": self.claim.paper_runs,
            "seed": self.seed,
            "truth": self.claim.truth,
            "readings_tried": [
                {"reading": m.reading, "measured": m.value, "low": m.low, "high": m.high, "n": m.runs}
                for m in self.measured
            ],
            "geometry_by": self.claim.geometry_by,
            "verdict": self.verdict,
            "borderline": self.borderline,
            "note": self.claim.note,
        }


def measure(paper: str, claim: Claim, seed: int, quick: bool = False) -> Row:
    """Measure every reading; unless ``quick``, with more runs until the intervals say enough or runs are many."""
    runs = claim.first_runs if quick else min(FULL * claim.first_runs, claim.most_runs)
    while True:
        found = [reading.measure(seed, runs) for reading in claim.readings]
        names = (reading.name for reading in claim.readings)
        row = Row(paper, claim, seed, tuple(Measured(n, *interval) for n, interval in zip(names, found, strict=True)))
        wanted = runs if quick else min(_wanted(row, found, runs), claim.most_runs)
        if wanted <= runs:
            return row
        runs = wanted


def exactly(value: float) -> Interval:
    """A value that nothing random enters."""
    return Interval(float(value), float(value), float(value), 1)


def counted(function: Callable[[], float]) -> Callable[[int, int], Interval]:
    """Measure of a value that nothing random enters."""
    return lambda seed, runs: exactly(function())


def _wanted(row: Row, found: list[Interval], runs: int) -> int:
    """Runs that should narrow the intervals enough; flights are dear, and a verdict that no longer hangs suffices."""
    if row.claim.draws > 1:
        return 2 * runs if row.borderline else runs
    return max((_narrowing(row.claim.printed, interval, runs) for interval in found), default=0)


def _narrowing(printed: Printed | None, interval: Interval, runs: int) -> int:
    """Runs that should narrow one interval enough."""
    width = interval.high - interval.low
    if interval.runs <= 1 or not math.isfinite(width) or runs >= MOST_RUNS:
        return runs
    if printed is None:
        narrow = 0.1 * abs(interval.value)
        return runs if width <= narrow else min(MOST_RUNS, math.ceil(1.2 * runs * (width / narrow) ** 2))
    if printed.settled(interval.low, interval.high):
        return runs
    range_ = printed.high - printed.low
    if not math.isfinite(range_):
        return min(MOST_RUNS, 4 * runs)
    return min(MOST_RUNS, math.ceil(1.2 * runs * (width / (0.1 * range_)) ** 2))
