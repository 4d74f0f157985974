"""decode(): the records of one category in data blocks as columns, those of equal layout together."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from sim.interchange.asterix.blocks import AsterixError, Block
from sim.interchange.asterix.category import Category, Marks
from sim.interchange.asterix.items import Field, Leaf

WIDEST = 8  # octets of a part whose fields are read


class Records(NamedTuple):
    """n records of a category, in the order of their blocks."""

    total: int  # n
    columns: dict[str, np.ndarray]  # (n,) SI by item and field, "040.rho"; NaN = not in that record, absent = in none


def decode(category: Category, content: bytes, blocks: Iterable[Block]) -> Records:
    """The records of the blocks of one category in ``content``; blocks of others are left out.

    Items whose fields nobody here knows are skipped by the length that their form gives.

    Raises ``AsterixError`` in one sentence, with the octet of the file, for a record that does not fit into its block
    and for one with an item of unknown length.
    """
    groups: dict[tuple[bytes, Marks], tuple[list[int], list[int]]] = {}
    count = 0
    walk = _walker(category)
    for begin, end in ((block.begin, block.end) for block in blocks if block.category == category.number):
        block, at = content[begin:end], 0  # a copy, so that nothing beyond the block can be read
        while at < len(block):
            try:
                following, layout = walk(block, at)
            except IndexError:
                raise AsterixError(f"{_where(category, begin + at)} goes on beyond the end of its block") from None
            except ValueError as error:
                raise AsterixError(f"{_where(category, begin + at)} {error}") from None
            if following > len(block):
                raise AsterixError(f"{_where(category, begin + at)} goes on beyond the end of its block")
            numbers, starts = groups.setdefault(layout, ([], []))
            numbers.append(count)
            starts.append(begin + at)
            count, at = count + 1, following
    octets = np.frombuffer(content, np.uint8)
    columns: dict[str, np.ndarray] = {}
    for (specification, marks), (numbers, starts) in groups.items():
        for leaf in category.layout(specification, marks):
            if leaf.octets <= WIDEST:
                for name, values in _fields(octets, np.array(starts), leaf):
                    columns.setdefault(name, np.full(count, np.nan))[numbers] = values
    return Records(count, columns)


def _where(category: Category, at: int) -> str:
    return f"at octet {at}: a record of category {category.number:03d}"


def _walker(category: Category) -> Callable[[bytes, int], tuple[int, tuple[bytes, Marks]]]:
    """What gives the end and the layout of the record at a place; it remembers the field specifications it has met."""
    met: dict[bytes, list[tuple[str, Callable[[bytes, int], tuple[int, Any]]]]] = {}

    def walk(block: bytes, at: int) -> tuple[int, tuple[bytes, Marks]]:
        begin = at
        while block[at] & 1:
            at += 1
        at += 1
        specification = block[begin:at]
        items = met.get(specification)
        if items is None:
            items = [(one.number, one.form.measure) for one in category.present(specification)]
            met[specification] = items
        marks = []
        for number, measure in items:
            try:
                end, mark = measure(block, at)
            except ValueError as error:
                raise ValueError(f"{error}: {category.called(number)}") from None
            marks.append((end - at, mark))
            at = end
        return at, (specification, tuple(marks))

    return walk


def _fields(octets: np.ndarray, starts: np.ndarray, leaf: Leaf) -> Iterable[tuple[str, np.ndarray]]:
    """The names and values of the fields of a part, of records that begin at ``starts``."""
    word = np.zeros(len(starts), np.uint64)
    for number in range(leaf.octets):
        word = word << np.uint64(8) | octets[starts + (leaf.offset + number)]
    left = 8 * leaf.octets
    for field in leaf.fields:
        left -= field.bits
        if field.name:
            yield f"{leaf.name}.{field.name}", _value(word >> np.uint64(left), field)


def _value(word: np.ndarray, field: Field) -> np.ndarray:
    """The values of a field in the lowest bits of words."""
    bits = (word & np.uint64((1 << field.bits) - 1)).astype(np.int64)
    if field.signed:
        bits = bits - ((bits >> (field.bits - 1)) << field.bits)
    return bits * field.step
