"""A category of ASTERIX: its edition, and the items of its records in the order of the field specification."""

from __future__ import annotations

from typing import Any, NamedTuple

from sim.interchange.asterix.items import Form, Leaf

Marks = tuple[tuple[int, Any], ...]  # of the items of a record: how long each is, and what else tells its layout


class Item(NamedTuple):
    """A data item: its number in the category, and how it lies in a record."""

    number: str
    form: Form


class Category(NamedTuple):
    """A category in one edition."""

    number: int
    edition: str
    profile: tuple[Item | None, ...]  # by the bits of a field specification; None = left open by the edition

    def present(self, specification: bytes) -> list[Item]:
        """The items that a field specification names, in their order.

        Raises ``ValueError`` where it names one that the edition leaves open, or has more octets than the edition.
        """
        found = []
        for octet, bits in enumerate(specification):
            for place in (7 * octet + bit for bit in range(7) if bits & 0x80 >> bit):
                item = self.profile[place] if place < len(self.profile) else None
                if item is None:
                    raise ValueError(f"has the field {place + 1}, which edition {self.edition} leaves open")
                found.append(item)
        return found

    def layout(self, specification: bytes, marks: Marks) -> list[Leaf]:
        """Where the parts of a record lie, counted from its begin: named by item and subfield, ``500.apc``."""
        at, found = len(specification), []
        for item, (length, own) in zip(self.present(specification), marks, strict=True):
            found += [
                leaf._replace(name=item.number + leaf.name, offset=at + leaf.offset) for leaf in item.form.leaves(own)
            ]
            at += length
        return found

    def called(self, number: str) -> str:
        """An item by its name in the specification, such as I048/040."""
        return f"I{self.number:03d}/{number}"
