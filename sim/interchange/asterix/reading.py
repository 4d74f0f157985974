"""feed_of(): the data blocks of a file, as they stand or in a capture, and what of it is not read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from sim.interchange.asterix.blocks import AsterixError, Block, blocks_of
from sim.interchange.asterix.categories.cat021 import CAT021
from sim.interchange.asterix.categories.cat034 import CAT034
from sim.interchange.asterix.categories.cat048 import CAT048
from sim.interchange.asterix.categories.cat062 import CAT062
from sim.interchange.asterix.decoding import Records, decode
from sim.interchange.asterix.pcap import datagrams, is_capture
from sim.interchange.clocks import DAY

READ = {category.number: category for category in (CAT021, CAT034, CAT048, CAT062)}
TEXT = 9  # the second octet of a text is not below, that of a block is while it has less than 2304 octets
ENDING = ".ast"


class Feed(NamedTuple):
    """The blocks of a file."""

    content: bytes
    blocks: list[Block]
    remarks: tuple[str, ...]  # what was left out

    @property
    def categories(self) -> list[int]:
        """Those that it has, in order."""
        return sorted({block.category for block in self.blocks})

    def records(self, number: int) -> Records:
        """All of a category."""
        return decode(READ[number], self.content, self.blocks)


def is_asterix(content: bytes, name: str = "") -> bool:
    """Whether a file is to be read as ASTERIX: a capture, one of that name, or one that begins with a block."""
    if is_capture(content) or name.lower().endswith(ENDING):
        return True
    return len(content) > 1 and content[0] in READ and content[1] < TEXT


def feed_of(content: bytes, wanted: Iterable[int]) -> Feed:
    """The blocks of a file, of which those of the categories ``wanted`` are to be read.

    Datagrams of a capture that hold something else are left out, and so are blocks of other categories. Raises
    ``AsterixError`` in one sentence where none is wanted, and for what is cut off.
    """
    remarks = []
    if is_capture(content):
        blocks = []
        parts, others = datagrams(content)
        for begin, end in parts:
            try:
                blocks += blocks_of(content, begin, end)
            except AsterixError:
                if begin < end and content[begin] in READ:
                    raise
                others += 1
        if others:
            remarks.append(f"{others} packets of the capture hold no data blocks of ASTERIX and are left out")
    else:
        blocks = blocks_of(content)
    wanted = tuple(wanted)
    named = ", ".join(f"{number:03d}" for number in wanted)
    found = Counter(block.category for block in blocks)
    if not any(number in found for number in wanted):
        have = ", ".join(f"{number:03d}" for number in sorted(found)[:12]) or "none"
        raise AsterixError(f"has no blocks of the categories that are read here, {named}: it has {have}")
    for number in sorted(found.keys() - READ.keys()):
        remarks.append(f"{found[number]} blocks of category {number:03d} are not read")
    return Feed(content, blocks, tuple(remarks))


def first_of(records: Records, names: Iterable[str]) -> np.ndarray:
    """(n,) the first of these fields that a record has, NaN where it has none."""
    found = np.full(records.total, np.nan)
    for name in names:
        if name in records.columns:
            found = np.where(np.isnan(found), records.columns[name], found)
    return found


def without_midnights(time: np.ndarray) -> np.ndarray:
    """(n,) s of times of day in the order in which they were sent: they go on beyond midnight."""
    apart = np.diff(time)
    days = np.cumsum((apart < -0.5 * DAY).astype(int) - (apart > 0.5 * DAY))
    return time + DAY * np.concatenate(([0], days))
