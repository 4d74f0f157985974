"""Ranges of parameters as notes on their fields: stated once, for what refuses a number and for what documents it."""

from __future__ import annotations

import dataclasses
import functools
import math
import typing
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

ROUNDING = 1e-9  # of a limit; a number that was converted from another unit may lie so far beyond it
HOLDS: dict[str, tuple[str, Callable[[Any, float], Any]]] = {  # limit -> how it is told, and whether a number keeps it
    "above": ("above", lambda number, limit: number > limit),
    "least": ("at least", lambda number, limit: number >= limit - ROUNDING * abs(limit)),
    "below": ("below", lambda number, limit: number < limit),
    "most": ("at most", lambda number, limit: number <= limit + ROUNDING * abs(limit)),
}


@dataclass(frozen=True)
class Range:
    """The numbers that a parameter may be, in the unit of its field; a limit that is None is none.

    ``why`` is the reason of a limit, as the end of the sentence that refuses a number beyond it.
    """

    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None
    why: str = ""

    @property
    def low(self) -> float | None:
        """The lower limit, whether or not the parameter may be it."""
        return self.above if self.least is None else self.least

    @property
    def high(self) -> float | None:
        """The upper limit, whether or not the parameter may be it."""
        return self.below if self.most is None else self.most

    @functools.lru_cache(maxsize=1024)  # noqa: B019 (ranges are few, and stay)
    def limits(self, factor: float = 1.0) -> tuple[tuple[str, str, float], ...]:
        """(field, how it is told, limit) of each limit, in the unit of which ``factor`` makes the field's."""
        given = ((name, told, getattr(self, name)) for name, (told, _) in HOLDS.items())
        return tuple((name, told, float(f"{one / factor:.12g}")) for name, told, one in given if one is not None)

    def keeper(self, factor: float = 1.0) -> Callable[[float], bool]:
        """What says quickly of a number in the unit of ``factor`` whether it is within the range."""
        limits = {name: limit for name, _, limit in self.limits(factor)}
        above, below = limits.get("above", -math.inf), limits.get("below", math.inf)
        least, most = limits.get("least", -math.inf), limits.get("most", math.inf)
        least, most = least - ROUNDING * abs(least), most + ROUNDING * abs(most)
        return lambda number: above < number < below and least <= number <= most

    def words(self, factor: float = 1.0) -> str:
        """``above 0, at most 60``."""
        return ", ".join(f"{told} {shown(limit)}" for _, told, limit in self.limits(factor))

    def fault(self, value: Any, factor: float = 1.0) -> str | None:
        """What is wrong with a number, or with an array of which one is beyond; None = nothing. ``must be above 0``."""
        for name, told, limit in self.limits(factor):
            holds = HOLDS[name][1](value, limit)
            if not (holds if isinstance(holds, bool) else np.all(holds)):
                return f"must be {told} {shown(limit)}{f': {self.why}' if self.why else ''}"
        return None


def shown(number: float) -> str:
    """A number as people write it: 1000000, 0.0872665."""
    return f"{float(f'{number:.6g}'):.15g}"


ABOVE_ZERO = Range(above=0.0)
NOT_NEGATIVE = Range(least=0.0)
SHARE = Range(least=0.0, most=1.0)
SINCE_BEGIN = Range(least=0.0, why="a flight begins at 0 s")


def within(size: float, why: str = "") -> Range:
    """So much to either side of zero."""
    return Range(least=-size, most=size, why=why)


def range_of(hint: Any) -> Range | None:
    """The range among the notes of an annotated type; None where there is none."""
    notes = typing.get_args(hint)[1:] if typing.get_origin(hint) is Annotated else ()
    return next((note for note in notes if isinstance(note, Range)), None)


@functools.cache
def _ranges(cls: Any) -> tuple[tuple[str, Range, Callable[[float], bool]], ...]:
    """Fields of a dataclass that have a range, with what says quickly whether a number is within it."""
    hints = typing.get_type_hints(cls, include_extras=True)
    found = ((field.name, range_of(hints[field.name])) for field in dataclasses.fields(cls))
    return tuple((name, one, one.keeper()) for name, one in found if one is not None)


def check_ranges(instance: Any) -> None:
    """Refuse a parameter that is not within the range of its field; None is not used.

    Raises ``ValueError`` in words.
    """
    for name, one, keeps in _ranges(instance.__class__):
        value = getattr(instance, name)
        quickly = QUICKLY.get(type(value))
        if value is None or (quickly is not None and quickly(keeps, value)):
            continue
        if (fault := one.fault(_numbers(value))) is not None:
            raise ValueError(f"{name.rstrip('_')} {fault}")


QUICKLY: dict[type, Callable[[Callable[[float], bool], Any], bool]] = {
    float: lambda keeps, value: keeps(value),
    int: lambda keeps, value: keeps(value),
    tuple: lambda keeps, value: all(map(keeps, value)),
    dict: lambda keeps, value: all(map(keeps, value.values())),
}
"""Whether what a parameter of a type holds is within its range."""


def _numbers(value: Any) -> Any:
    """The numbers of a parameter, which may be one, several, or some by name."""
    return value if isinstance(value, float) else np.array([*value.values()] if isinstance(value, dict) else value)
