"""The part of a file that its broken tables leave: one fault must not hide those of other tables."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any

PLACE = re.compile(r"\[{1,2}([^\]]+)\]{1,2}(?: entry (\d+))?|([^\s:]+):")
MEMBERS = ("sensors", "trackers")  # tables whose members stand by themselves
Entries = Callable[[str], list[tuple[int, Any]]]


def sound_part(tables: dict[str, Any], faults: Iterable[str]) -> tuple[dict[str, Any], Entries]:
    """The tables without those that faults name, and the entries of an array of tables with their numbers in the file.

    A sensor, a tracker or an entry of an array goes by itself, anything else with the whole table.
    """
    left = dict(tables)
    gone: dict[str, set[int]] = {}
    for fault in faults:
        place = PLACE.match(fault)
        if place is None:
            continue
        top, _, below = (place[1] or place[3]).partition(".")
        own = left.get(top)
        if top in MEMBERS and isinstance(own, dict):
            member = next((name for name in (below, below.partition(".")[0], _key(fault, place)) if name in own), None)
            left[top] = {name: table for name, table in own.items() if name != member} if member is not None else {}
        elif isinstance(own, list) and place[2] is not None:
            gone.setdefault(top, set()).add(int(place[2]))
        else:
            left.pop(top, None)
    numbered = {
        several: [(i, entry) for i, entry in enumerate(own) if i not in gone.get(several, ())]
        for several, own in left.items()
        if isinstance(own, list)
    }
    left |= {several: [entry for _, entry in entries] for several, entries in numbered.items()}
    if "name" not in left:
        left["name"] = "scenario"  # whose absence is a fault that has been told
    return left, lambda several: numbered.get(several, [])


def _key(fault: str, place: re.Match[str]) -> str:
    """The key that follows the place of a fault."""
    return fault[place.end() :].strip().partition(":")[0]
