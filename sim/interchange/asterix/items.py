"""Data items of ASTERIX by their forms: which bits are which field, and how long an item is where its length varies.

The forms and their lengths are those of the specification's Part 1: fixed, extended by a last bit of 1 in each octet,
repetitive after a count, compound of subfields named by their own presence bits, explicit with a length of its own.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any, NamedTuple, Protocol


class Field(NamedTuple):
    """Bits of an item, the most significant first."""

    name: str  # "" = spare
    bits: int
    step: float = 1.0  # what its least significant bit is worth, SI
    signed: bool = False  # two's complement
    cyclic: bool = False  # an angle, a whole turn of which is one more than its bits can count
    constant: int = 0  # what is written where no value is given


class Leaf(NamedTuple):
    """A run of octets that hold fields."""

    name: str  # "" = the item itself, else that of its subfield with a point before it
    offset: int  # octets from the begin of the item
    octets: int
    fields: tuple[Field, ...]


class Part(NamedTuple):
    """A run of octets as it is written."""

    place: int  # among the parts of its item
    name: str  # as of a `Leaf`
    fields: tuple[Field, ...]


class Form(Protocol):
    """How an item lies in a record."""

    def measure(self, block: bytes, at: int) -> tuple[int, Any]:
        """Where the item that begins at ``at`` ends, and what tells it from one of another layout.

        Raises ``IndexError`` where it would end beyond the block, and ``ValueError`` for what the specification leaves
        open.
        """
        ...

    def leaves(self, mark: Any) -> list[Leaf]:
        """The parts of an item of this mark that hold fields."""
        ...

    def written(self, fields: Collection[str]) -> list[Part]:
        """The parts that hold these fields when the item is written."""
        ...

    def head(self, places: Sequence[int]) -> bytes:
        """What comes before the parts of these places."""
        ...


class Fixed(NamedTuple):
    """An item of a constant length."""

    octets: int
    fields: tuple[Field, ...] = ()  # () = it is only skipped

    def measure(self, block: bytes, at: int) -> tuple[int, Any]:
        """Its end; the mark is its length."""
        return at + self.octets, self.octets

    def leaves(self, mark: Any) -> list[Leaf]:
        """Itself."""
        return [Leaf("", 0, self.octets, self.fields)]

    def written(self, fields: Collection[str]) -> list[Part]:
        """Itself."""
        return [Part(0, "", self.fields)]

    def head(self, places: Sequence[int]) -> bytes:
        """Nothing."""
        return b""


class Extended(NamedTuple):
    """Octets of seven bits, each of which says with its last bit whether another one follows."""

    parts: tuple[tuple[Field, ...], ...] = ()  # of the first octets; further ones are skipped

    def measure(self, block: bytes, at: int) -> tuple[int, Any]:
        """Its end; the mark is its length."""
        begin = at
        while block[at] & 1:
            at += 1
        return at + 1, at + 1 - begin

    def leaves(self, mark: Any) -> list[Leaf]:
        """The octets that are there and known, the bits between them as spare ones."""
        known = self.parts[:mark]
        return [Leaf("", 0, len(known), tuple(field for part in known for field in (*part, spare(1))))]

    def written(self, fields: Collection[str]) -> list[Part]:
        """The octets up to the last one of which a field is given, with the bits that say so."""
        last = max(number for number, part in enumerate(self.parts) if any(field.name in fields for field in part))
        bits = [
            (*part, Field("", 1, constant=int(number < last))) for number, part in enumerate(self.parts[: last + 1])
        ]
        return [Part(0, "", tuple(field for part in bits for field in part))]

    def head(self, places: Sequence[int]) -> bytes:
        """Nothing."""
        return b""


class Repetitive(NamedTuple):
    """So many parts of one length as its first octet says."""

    octets: int

    def measure(self, block: bytes, at: int) -> tuple[int, Any]:
        """Its end; the mark is its length."""
        length = 1 + self.octets * block[at]
        return at + length, length

    def leaves(self, mark: Any) -> list[Leaf]:
        """None that is read."""
        return []

    def written(self, fields: Collection[str]) -> list[Part]:
        """None."""
        return []

    def head(self, places: Sequence[int]) -> bytes:
        """Nothing."""
        return b""


class Chained(NamedTuple):
    """Parts of one length, each of which says with its last bit whether another one follows."""

    octets: int

    def measure(self, block: bytes, at: int) -> tuple[int, Any]:
        """Its end; the mark is its length."""
        begin = at
        while block[at + self.octets - 1] & 1:
            at += self.octets
        return at + self.octets, at + self.octets - begin

    def leaves(self, mark: Any) -> list[Leaf]:
        """None that is read."""
        return []

    def written(self, fields: Collection[str]) -> list[Part]:
        """None."""
        return []

    def head(self, places: Sequence[int]) -> bytes:
        """Nothing."""
        return b""


class Explicit(NamedTuple):
    """Begins with its own length in octets, that one counted: what a state or an application adds."""

    def measure(self, block: bytes, at: int) -> tuple[int, Any]:
        """Its end; the mark is its length. Raises ``ValueError`` for a length of 0."""
        if not block[at]:
            raise ValueError("says that it is 0 octets long, and its length is one")
        return at + block[at], block[at]

    def leaves(self, mark: Any) -> list[Leaf]:
        """None that is read."""
        return []

    def written(self, fields: Collection[str]) -> list[Part]:
        """None."""
        return []

    def head(self, places: Sequence[int]) -> bytes:
        """Nothing."""
        return b""


class Compound(NamedTuple):
    """Subfields, of which its first octets say which are there; None = left open by the specification."""

    parts: tuple[tuple[str, Form] | None, ...]

    def measure(self, block: bytes, at: int) -> tuple[int, Any]:
        """Its end; the mark holds the octets that name its subfields, and which there are with their marks.

        Raises ``ValueError`` for a subfield that the specification leaves open: nobody knows its length.
        """
        begin, chosen = at, []
        while True:
            octet = block[at]
            chosen += [7 * (at - begin) + bit for bit in range(7) if octet & 0x80 >> bit]
            at += 1
            if not octet & 1:
                break
        named, marks = at - begin, []
        for number in chosen:
            part = self.parts[number] if number < len(self.parts) else None
            if part is None:
                raise ValueError(f"has subfield {number + 1}, which its specification leaves open")
            end, mark = part[1].measure(block, at)
            marks.append((number, end - at, mark))
            at = end
        return at, (named, tuple(marks))

    def leaves(self, mark: Any) -> list[Leaf]:
        """Those of its subfields."""
        at, marks = mark
        found = []
        for number, length, own in marks:
            part = self.parts[number]
            assert part is not None
            name, form = part
            found += [leaf._replace(name=f".{name}{leaf.name}", offset=at + leaf.offset) for leaf in form.leaves(own)]
            at += length
        return found

    def written(self, fields: Collection[str]) -> list[Part]:
        """The subfields of which a field is given."""
        named = {name.partition(".")[0] for name in fields}
        parts = [(place, *part) for place, part in enumerate(self.parts) if part is not None and part[0] in named]
        return [
            Part(
                place,
                f".{name}",
                form.written([one.partition(".")[2] for one in fields if one.startswith(f"{name}.")])[0].fields,
            )
            for place, name, form in parts
        ]

    def head(self, places: Sequence[int]) -> bytes:
        """The octets that name its subfields."""
        return presence(places)


def presence(places: Sequence[int]) -> bytes:
    """Octets that name things by their bits, seven in each, of which all but the last say that another one follows."""
    octets = bytearray(max(places) // 7 + 1)
    for place in places:
        octets[place // 7] |= 0x80 >> place % 7
    for number in range(len(octets) - 1):
        octets[number] |= 1
    return bytes(octets)


def fixed(*fields: Field) -> Fixed:
    """An item of these fields, from its first bit to its last."""
    return Fixed(sum(field.bits for field in fields) // 8, fields)


def spare(bits: int) -> Field:
    """Bits that say nothing, and are written as 0."""
    return Field("", bits)
