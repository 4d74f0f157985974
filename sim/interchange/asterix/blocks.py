"""Data blocks of ASTERIX: a category, a length, and records; one after another they are a file or a datagram."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

HEAD = 3  # octets: the category, and the length of the block with its head
LONGEST = 0xFFFF


class AsterixError(ValueError):
    """What cannot be read as ASTERIX, in one sentence."""


class Block(NamedTuple):
    """Where the records of a block lie."""

    category: int
    begin: int  # octet of the content that they begin at
    end: int  # octet after them


def blocks_of(content: bytes, begin: int = 0, end: int | None = None) -> list[Block]:
    """The blocks that fill ``content`` from ``begin`` to ``end``.

    Raises ``AsterixError`` for a block that is cut off, or too short to be one.
    """
    found, at = [], begin
    end = len(content) if end is None else end
    while at < end:
        if end - at < HEAD:
            raise AsterixError(f"at octet {at}: {end - at} octets are left, and a block begins with {HEAD}")
        length = content[at + 1] << 8 | content[at + 2]
        if length < HEAD:
            raise AsterixError(f"at octet {at}: a block says that it is {length} octets long, and its head is {HEAD}")
        if at + length > end:
            raise AsterixError(f"at octet {at}: a block of {length} octets is cut off after {end - at}")
        found.append(Block(content[at], at + HEAD, at + length))
        at += length
    return found


class Blocks(NamedTuple):
    """b blocks of one or several categories, in the order of their stamps."""

    stamps: np.ndarray  # (b,) s since 1970, when they are sent
    lengths: np.ndarray  # (b,) octets of each, with its head
    octets: np.ndarray  # all of them, uint8


def packed(category: int, lengths: np.ndarray, octets: np.ndarray, stamps: np.ndarray, most: int = 1400) -> Blocks:
    """Records as blocks: those of one stamp together, as far as ``most`` octets reach.

    Parameters
    ----------
    lengths : (n,) of the records, whose octets are ``octets``
    stamps : (n,) when each record is sent; a change begins a new block
    most : octets of a block, so that a datagram of it passes where packets have 1500; a record alone may be longer
    """
    if not len(lengths):
        return Blocks(np.zeros(0), np.zeros(0, np.int64), np.zeros(0, np.uint8))
    new = np.concatenate(([True], np.diff(stamps) != 0.0))
    ends = np.cumsum(lengths)
    begins = ends - lengths
    since = begins - begins[new][np.cumsum(new) - 1]  # octets of this stamp before the record
    share = since // max(most - HEAD - int(lengths.max()), 1)  # so many of each block are full at most
    new[1:] |= np.diff(share) > 0
    block = np.cumsum(new) - 1
    sizes = np.bincount(block, lengths).astype(np.int64) + HEAD
    found = np.empty(int(sizes.sum()), np.uint8)
    found[np.arange(len(octets)) + np.repeat(HEAD * (block + 1), lengths)] = octets
    heads = np.cumsum(sizes) - sizes
    found[heads], found[heads + 1], found[heads + 2] = category, sizes >> 8, sizes & 0xFF
    return Blocks(stamps[new], sizes, found)


def merged(parts: list[Blocks]) -> Blocks:
    """The blocks of several, by their stamps; of one stamp those of the first come first."""
    stamps, lengths, octets = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    order = np.argsort(stamps, kind="stable")
    begins = (np.cumsum(lengths) - lengths)[order]
    sizes = lengths[order]
    before = np.cumsum(sizes) - sizes
    return Blocks(stamps[order], sizes, octets[np.repeat(begins - before, sizes) + np.arange(len(octets))])
