"""How flights could lie on the two sides as well, where nothing has changed: what a test of that counts over.

Of pairs, the two flights of a pair change sides; of independent flights, any of them lie on either side. Under "nothing
has changed" all arrangements are equally likely, whatever the metrics are distributed like and however they hang
together, so that the share of arrangements that look as different as the one at hand is an exact probability
[Pesarin and Salmaso, Permutation Tests for Complex Data, 2010].
"""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np

from sim.randomness import stream

MOST = 9999  # arrangements that are looked at; of more as many are drawn, always the same


@functools.lru_cache(maxsize=4)
def of_pairs(pairs: int) -> np.ndarray:
    """Sides (-1 = A, 1 = B), shape (arrangements, 2 pairs), of the flights of A and then of those of B.

    The first is the one at hand. Since a change to either side counts alike, each stands for itself and its mirror
    image: the first pair stays.
    """
    if 2 ** (pairs - 1) <= MOST:
        swaps = np.array([*itertools.product((1, -1), repeat=pairs - 1)], np.int8)
    else:
        swaps = 1 - 2 * stream(0, 0, 0, "arrangements of pairs").integers(0, 2, (MOST, pairs - 1), np.int8)
        swaps[0] = 1
    signs = np.hstack((np.ones((len(swaps), 1), np.int8), swaps))
    return np.hstack((-signs, signs))


@functools.lru_cache(maxsize=4)
def of_sides(a: int, b: int) -> np.ndarray:
    """Sides, shape (arrangements, a + b), of independent flights, a of A and then b of B; the first is that at hand."""
    at_hand = np.repeat(np.array((-1, 1), np.int8), (a, b))
    if _divisions(a, b) > MOST:
        shuffled = stream(0, 0, 0, "arrangements of sides").permuted(np.tile(at_hand, (MOST, 1)), axis=1)
        shuffled[0] = at_hand
        return shuffled
    mirrored = a == b  # then the first flight stays where it is
    chosen = itertools.combinations(range(a + b), a)
    rows = np.ones((_divisions(a, b), a + b), np.int8)
    for row, of_a in zip(rows, itertools.takewhile(lambda one: not mirrored or one[0] == 0, chosen), strict=True):
        row[list(of_a)] = -1
    return rows


def least_of_pairs(pairs: int) -> float:
    """The least probability that so many pairs can give."""
    return 0.5 ** max(pairs - 1, 0)


def least_of_sides(a: int, b: int) -> float:
    """The least probability that so many independent flights can give."""
    return 1.0 / _divisions(a, b)


def _divisions(a: int, b: int) -> int:
    return math.comb(a + b, a) // (2 if a == b and a else 1)
