"""What faults leave of a scenario: the keys that they name go, so that the next layer can tell what else is wrong."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from sim.cli.validation.lines import TOLD, WORD, Place, is_named, is_quoted, parts

MEMBERS = (("sensors",), ("trackers",), ("wind", "events"))  # tables whose members the user names
FIRST = re.compile(r"'?([\w.-]+)'?: ")  # a fault of one key, and of no other that it names
ENTRY = re.compile(r"(\[\[([\w.]+)\]\] entry )(\d+)")
UNKNOWN = re.compile(r"no (?:other )?(sensor|tracker) '([^']*)'")
LACKS = ("is missing", "must not be empty", "needs at least one")


class Rest:
    """The tables of a file without what is at fault; entries of arrays keep the numbers that they have in the file."""

    def __init__(self, tables: dict[str, Any]) -> None:
        self.tables = tables
        self.gone: set[Place] = set()
        self._numbers = {key: [*range(len(own))] for key, own in tables.items() if isinstance(own, list)}

    def without(self, faults: Iterable[str]) -> None:
        """Take out what faults are about: keys, or where they name none an entry, a member or the table."""
        places = {place for fault in faults for place in places_of(fault, self.tables)}
        for place in sorted(places, key=_by_number, reverse=True):  # of an array the last first
            self.tables = _taken_out(self.tables, place)
            self.gone.add(self._in_file(place))
            if len(place) == 2 and isinstance(place[1], int):
                del self._numbers[str(place[0])][place[1]]

    def _in_file(self, place: Place) -> Place:
        """A place by the numbers that entries have in the file."""
        if len(place) > 1 and isinstance(place[1], int):
            return (place[0], self._numbers[str(place[0])][place[1]], *place[2:])
        return place

    def numbered(self, fault: str) -> str:
        """A fault with the number that its entry has in the file."""

        def renumbered(found: re.Match[str]) -> str:
            numbers = self._numbers.get(found[2])
            return found[1] + (found[3] if numbers is None else str(numbers[int(found[3])]))

        return ENTRY.sub(renumbered, fault)

    def is_echo(self, fault: str) -> bool:
        """Whether a fault only follows from what was taken out."""
        table, rest = _table(fault)
        first = FIRST.match(rest)
        if first is not None and (*table, first[1]) in self.gone:
            return True
        keys = [str(gone[len(table)]) for gone in self.gone if gone[:-1] == table] if table and first is None else []
        if keys and (
            isinstance(table[-1], int) or any(is_named(key, word) for key in keys for word in WORD.findall(rest))
        ):
            return True
        if any(lacks in fault for lacks in LACKS):
            return any(gone[: len(table)] == table or gone[0] in ("sensors", "trackers") for gone in self.gone)
        unknown = UNKNOWN.search(fault)
        if unknown is not None:
            family = f"{unknown[1]}s"
            return (family,) in self.gone or (family, unknown[2]) in self.gone
        return (
            fault.startswith("[study]")
            and 'axes "' not in fault
            and any(gone[:2] == ("study", "axes") for gone in self.gone)
        )

    def lacks(self, *tables: Place) -> bool:
        """Whether a whole table was taken out, or a member of it."""
        return any(gone == table or (gone[:-1] == table and table in MEMBERS) for gone in self.gone for table in tables)


def places_of(fault: str, tables: dict[str, Any]) -> set[Place]:
    """Addresses in the tables of what a fault is about."""
    table, rest = _table(fault)
    while table and _at(tables, table) is None:
        table = table[:-1]
    own = _at(tables, table)
    first = FIRST.match(rest)
    words = [first[1]] if first is not None else [word.strip(".") for word in WORD.findall(rest)]
    if words[:1] == ["kind"]:  # without it a table has other keys
        words, own = [], None
    found = (
        {(*table, key) for word in words for key in own if is_named(str(key), word)} if isinstance(own, dict) else ()
    )
    if found:
        return {(*place, *_quoted(_at(tables, place), rest)) for place in found}
    inner = {(*table, key, *_quoted(node, rest)) for key, node in own.items()} if isinstance(own, dict) else set()
    if deeper := {place for place in inner if len(place) > len(table) + 1}:
        return deeper
    for end in (2, 3):
        if table[: end - 1] in MEMBERS and len(table) >= end:
            return {table[:end]}
    is_entry = len(table) == 2 and isinstance(table[1], int)
    return {table if is_entry else table[:1]} if table else set()


def _quoted(node: Any, rest: str) -> Place:
    """The key of a table within a table that a fault names in quotes, as that of an axis or of a factor."""
    keys = [key for key in node if is_quoted(str(key), rest)] if isinstance(node, dict) else []
    return (keys[0],) if keys else ()


def _table(fault: str) -> tuple[Place, str]:
    """The place with which a fault begins, and what it says of it."""
    told = TOLD.match(fault)
    if told is None:
        return (), fault
    table = parts(told[1])
    return ((*table, int(told[2])) if told[2] is not None else table), told[3]


def _at(tables: Any, place: Sequence[str | int]) -> Any:
    for part in place:
        in_list = isinstance(tables, list) and isinstance(part, int) and part < len(tables)
        if not in_list and not (isinstance(tables, dict) and part in tables):
            return None
        tables = tables[part]
    return tables


def _taken_out(node: Any, place: Place) -> Any:
    """A copy of nested tables without what stands at a place."""
    head, *rest = place
    if _at(node, (head,)) is None:
        return node  # went with another
    if isinstance(node, list):
        kept: Iterator[tuple[int, Any]] = enumerate(node)
        return [_taken_out(item, tuple(rest)) if i == head else item for i, item in kept if rest or i != head]
    return {
        key: _taken_out(item, tuple(rest)) if key == head else item for key, item in node.items() if rest or key != head
    }


def _by_number(place: Place) -> tuple[tuple[str, int], ...]:
    return tuple((part, 0) if isinstance(part, str) else ("", part) for part in place)
