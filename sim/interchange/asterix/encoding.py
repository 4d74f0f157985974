"""encode(): columns of values as the records of one category, record by record in their order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from sim.interchange.asterix.category import Category
from sim.interchange.asterix.items import Field, Form, Part, presence


class FieldError(ValueError):
    """A value that no field holds, in one sentence."""


class Encoded(NamedTuple):
    """n records, one after another."""

    lengths: np.ndarray  # (n,) octets of each
    octets: np.ndarray  # all of them, uint8


class Piece(NamedTuple):
    """A part of an item in all records."""

    place: int  # of the item in the profile
    form: Form
    part: int  # its place among those of the item
    there: np.ndarray  # (n,) whether a record has it
    octets: np.ndarray  # (n, its length)


def encode(category: Category, columns: Mapping[str, np.ndarray]) -> Encoded:
    """The records of values in SI, each rounded to the nearest that its field can hold.

    Parameters
    ----------
    columns : (n,) of each field by item and name, ``"040.rho"``; NaN = the item is not in that record. Other fields of
        an item that is there are 0

    Raises ``FieldError`` for a field that the category does not have, for an item of which a record has but a part, and
    for a value beyond what the bits of its field can hold.
    """
    pieces = list(_pieces(category, columns))
    count = len(next(iter(columns.values())))
    pattern = np.zeros(count, np.int64)
    for number, piece in enumerate(pieces):
        pattern |= piece.there.astype(np.int64) << number
    kinds, kind = np.unique(pattern, return_inverse=True)
    rows = [
        (np.flatnonzero(kind == number), _matrix(pieces, int(found), kind == number))
        for number, found in enumerate(kinds)
    ]
    lengths = np.zeros(count, np.int64)
    for chosen, matrix in rows:
        lengths[chosen] = matrix.shape[1]
    starts = np.cumsum(lengths) - lengths
    octets = np.empty(int(lengths.sum()), np.uint8)
    for chosen, matrix in rows:
        octets[starts[chosen, None] + np.arange(matrix.shape[1])] = matrix
    return Encoded(lengths, octets)


def _pieces(category: Category, columns: Mapping[str, np.ndarray]) -> Iterator[Piece]:
    """The parts that hold the given fields, in the order in which a record has them."""
    given: dict[str, list[str]] = {}
    for name in columns:
        number, _, field = name.partition(".")
        given.setdefault(number, []).append(field)
    known = set()
    for place, item in enumerate(category.profile):
        if item is None or item.number not in given:
            continue
        for part in item.form.written(given[item.number]):
            name = item.number + part.name
            own = {
                field.name: columns[f"{name}.{field.name}"]
                for field in part.fields
                if f"{name}.{field.name}" in columns
            }
            known |= {f"{name}.{field}" for field in own}
            if own:
                yield _piece(category.called(name), place, item.form, part, own)
    if unknown := sorted(columns.keys() - known):
        raise FieldError(f"{category.called(unknown[0])} is no field that is written")


def _piece(called: str, place: int, form: Form, part: Part, own: dict[str, np.ndarray]) -> Piece:
    there = np.isfinite(next(iter(own.values())))
    if any((np.isfinite(values) != there).any() for values in own.values()):
        raise FieldError(f"{called} is there without some of its fields")
    word = np.zeros(len(there), np.int64)
    for field in part.fields:
        bits = _bits(f"{called} {field.name}", own[field.name], there, field) if field.name in own else field.constant
        word = word << field.bits | bits
    length = sum(field.bits for field in part.fields) // 8
    octets = word.astype(">u8").view(np.uint8).reshape(-1, 8)[:, 8 - length :]
    return Piece(place, form, part.place, there, octets)


def _bits(called: str, values: np.ndarray, there: np.ndarray, field: Field) -> np.ndarray:
    """(n,) the bits of a field."""
    count = np.rint(np.where(there, values, 0.0) / field.step).astype(np.int64)
    whole = 1 << field.bits
    if not field.cyclic:
        low, high = (-(whole >> 1), (whole >> 1) - 1) if field.signed else (0, whole - 1)
        beyond = (count < low) | (count > high)
        if beyond.any():
            value = values[int(np.argmax(beyond))]
            raise FieldError(f"{called} holds {low * field.step:g} to {high * field.step:g}, and {value:g} is beyond")
    return np.asarray(count & (whole - 1))


def _matrix(pieces: list[Piece], pattern: int, chosen: np.ndarray) -> np.ndarray:
    """(m, length) the records of a pattern of parts."""
    there = [piece for number, piece in enumerate(pieces) if pattern >> number & 1]
    places = list(dict.fromkeys(piece.place for piece in there))
    rows = int(chosen.sum())
    parts = [_same(presence(places), rows)] if places else []
    for place in places:
        own = [piece for piece in there if piece.place == place]
        parts.append(_same(own[0].form.head([piece.part for piece in own]), rows))
        parts += [piece.octets[chosen] for piece in own]
    return np.concatenate(parts, axis=1)


def _same(octets: bytes, rows: int) -> np.ndarray:
    return np.broadcast_to(np.frombuffer(octets, np.uint8), (rows, len(octets)))
