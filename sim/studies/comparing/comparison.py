"""Two runs or two studies, metric by metric: the means, their difference with its interval, and what that says.

Where both have the same seed, draws and flights, a flight of one has the turbulence and the noise of the same flight of
the other, and the difference is taken flight by flight. Elsewhere the flights are independent. ``judging`` says
whether anything has changed beyond noise, and which metrics have.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from sim.errors import OutputError
from sim.files import plain
from sim.studies.comparing.judging import ERROR, Judgement, judge
from sim.studies.comparing.sides import Place, Side, side_of
from sim.studies.comparing.spans import Span
from sim.studies.comparing.tolerance import tolerances
from sim.versions import rows as version_rows

Column = dict[Place, float]  # a metric by flight


@dataclasses.dataclass(frozen=True)
class Row:
    """One metric, of a study in one of its cells."""

    metric: str
    cell: int  # 0 for a run
    a: float | None  # mean over its flights; None where no flight has it
    b: float | None
    n: tuple[int, int]  # flights that say it
    span: Span | None  # b less a; None where one side is silent
    tolerance: float | None

    @property
    def changed(self) -> bool:
        """Whether it differs beyond noise."""
        return self.span is not None and self.span.changed

    @property
    def beyond(self) -> bool:
        """Whether it differs by more than its tolerance; a metric that one side alone has does."""
        return self.tolerance is not None and (self.span is None or abs(self.span.difference) > self.tolerance)

    def plain(self) -> dict[str, Any]:
        """As JSON has it."""
        span = dict.fromkeys(Span._fields) if self.span is None else self.span._asdict()
        told = {"metric": self.metric, "cell": self.cell, "a": self.a, "b": self.b, "n": list(self.n), **span}
        return told | {"changed": self.changed, "tolerance": self.tolerance, "beyond": self.beyond}


@dataclasses.dataclass(frozen=True)
class Comparison:
    """What two sides differ in: ``rows``, how it was found out, and what else is to be known."""

    names: tuple[str, str]
    is_paired: bool
    rows: tuple[Row, ...]
    remarks: tuple[str, ...]
    probability: float  # of sides that differ so much where nothing has changed
    arrangements: int  # of the flights, that this was counted over; 1 = none

    @property
    def differs(self) -> bool:
        """Whether anything has changed beyond noise, all metrics taken together."""
        return self.probability <= ERROR

    @property
    def changed(self) -> list[Row]:
        """Rows beyond noise by themselves."""
        return [row for row in self.rows if row.changed]

    @property
    def beyond(self) -> list[Row]:
        """Rows beyond their tolerance."""
        return [row for row in self.rows if row.beyond]

    @property
    def method(self) -> str:
        """How it was found out, in a sentence."""
        how = "paired flight by flight (Student)" if self.is_paired else "of independent flights (Welch)"
        judged = sum(row.span is not None and row.span.known for row in self.rows)
        by = f"Bonferroni over {judged} metrics"
        if self.arrangements > 1:
            by = f"{self.arrangements} arrangements of the flights on the two sides"
        return (
            f"differences {how}; where nothing has changed, any of the {judged} metrics is named with at most "
            f"{100 * ERROR:g} %, by {by}"
        )

    def plain(self) -> dict[str, Any]:
        """As JSON has it."""
        told = {"a": self.names[0], "b": self.names[1], "paired": self.is_paired, "method": self.method}
        told |= {"differs": self.differs, "probability": self.probability}
        found: dict[str, Any] = plain(
            {**told, "remarks": list(self.remarks), "rows": [row.plain() for row in self.rows]}
        )
        return found


def compare(a: Any, b: Any, tolerance: Any = None) -> Comparison:
    """What changed between two runs or two studies, beyond noise and beyond a tolerance.

    Parameters
    ----------
    a, b : folders of runs or of studies, or results of ``sim.run``; differences are b less a
    tolerance : a TOML file, or a dict, of the largest difference of each metric's mean, in the metric's unit

    Raises ``OutputError`` in one sentence for what cannot be compared.
    """
    one, other = side_of(a), side_of(b)
    if one.kind != other.kind:
        raise OutputError(f"{one.name} is a {one.kind} and {other.name} is a {other.kind}: compare two of a kind")
    if one.axes != other.axes:
        raise OutputError(f"{one.name} and {other.name} are studies over different axes: their cells do not answer")
    together = one.noise == other.noise and set(one.flights) == set(other.flights)
    columns = {key: (_column(one, *key), _column(other, *key)) for key in _keys(one, other)}
    allowed = {} if tolerance is None else tolerances(tolerance, sorted({metric for _, metric in columns}))
    found = _judged(one, other, columns, together)
    rows = tuple(
        Row(metric, cell, _mean(x), _mean(y), (len(x), len(y)), found.spans.get((cell, metric)), allowed.get(metric))
        for (cell, metric), (x, y) in columns.items()
    )
    names = (one.name, other.name)
    return Comparison(names, together, rows, _remarks(one, other), found.probability, found.arrangements)


def _judged(
    one: Side, other: Side, columns: dict[tuple[int, str], tuple[Column, Column]], together: bool
) -> Judgement[tuple[int, str]]:
    """What arrangements of the flights say; a flight of a study changes sides with all its cells, which share noise."""
    order = [sorted({place[1:] for place in side.flights}) for side in (one, other)]

    def values(column: Column, cell: int, flights: list[tuple[int, int]]) -> np.ndarray:
        return np.array([column.get((cell, *flight), np.nan) for flight in flights])

    told = {
        key: (values(x, key[0], order[0]), values(y, key[0], order[1]))
        for key, (x, y) in columns.items()
        if (x.keys() & y.keys() if together else x and y)
    }
    return judge(told, (len(order[0]), len(order[1])), together)


def _keys(*sides: Side) -> list[tuple[int, str]]:
    """Cell and metric of everything that either side says, in its order."""
    return list(
        dict.fromkeys(
            (place[0], metric) for side in sides for place, flight in side.flights.items() for metric in flight
        )
    )


def _column(side: Side, cell: int, metric: str) -> Column:
    """A metric by flight."""
    return {place: flight[metric] for place, flight in side.flights.items() if place[0] == cell and metric in flight}


def _mean(column: Column) -> float | None:
    return float(np.mean([*column.values()])) if column else None


def _remarks(one: Side, other: Side) -> tuple[str, ...]:
    """What is to be known beside the rows."""
    told = []
    old, new = dict(version_rows(one.versions)), dict(version_rows(other.versions))
    apart = [
        f"{name} {old.get(name)} and {new.get(name)}" for name in sorted({*old, *new}) if old.get(name) != new.get(name)
    ]
    if apart:
        told.append(f"the versions differ: {', '.join(apart)}")
    if max(len(one.flights), len(other.flights)) < 2:
        told.append(
            "of one flight each there is no noise to judge by: differences have no interval; fly more --flights"
        )
    return tuple(told)
