"""Ranges in the unit that the user wrote: a fault of a value shows it as the file has it."""

from __future__ import annotations

import re
from typing import Any

from sim.scenario.parameters import parameters, spellings_in

RANGE = re.compile(r"(-?\d[\d.e+]*)( and (?:at most )?)?(-?\d[\d.e+]*)? (m/s2|m/s|m|kg|s)(?=$|[;:, ])")


def in_words_of(cls: type, table: dict[str, Any], fault: str) -> str:
    """A fault of a value of a table with that value, and its range, in the unit of the key that the file has.

    A class speaks of its fields; anything else that it says is left as it is.
    """
    spelt = spellings_in(cls, table)
    word = fault.partition(" ")[0].strip("'")
    key = next((spelt[one.attribute] for one in parameters(cls) if one.name == word and one.attribute in spelt), None)
    if key is None or not isinstance(table[key], int | float) or isinstance(table[key], bool):
        return fault
    one = next(one for one in parameters(cls) if key in one.keys)
    factor, suffix = one.keys[key], key.removeprefix("indicated_").removeprefix(f"{one.name}_")

    def converted(found: re.Match[str]) -> str:
        low, between, high, unit = found.groups()
        if unit != one.unit or factor == 1.0:
            return found[0]
        ends = [f"{float(f'{float(end) / factor:.4g}'):g}" for end in (low, high) if end is not None]
        return f"{(between or '').join(ends)} {suffix}"

    return f"{RANGE.sub(converted, fault)} (got {key} = {table[key]!r})"
