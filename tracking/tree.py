"""The state of a tracker as a tree: nested tuples and dicts whose leaves are arrays, numbers and names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np


def walk(leaf: Callable[..., Any], *states: Any, whole: tuple[type, ...] = ()) -> Any:
    """``leaf`` of the corresponding leaves of states of one shape, in a state of that shape.

    Tuples of the types in ``whole`` are leaves themselves.
    """
    first = states[0]
    if isinstance(first, tuple) and not isinstance(first, whole):
        parts = [walk(leaf, *each, whole=whole) for each in zip(*states, strict=True)]
        return type(first)(*parts) if hasattr(first, "_fields") else tuple(parts)
    if isinstance(first, dict):
        return {key: walk(leaf, *(state[key] for state in states), whole=whole) for key in first}
    return leaf(*states)


def narrowed(state: Any, runs: int, rows: np.ndarray) -> Any:
    """A state with some of its runs: of every array whose last axis is the runs, those ``rows``."""

    def some(leaf: Any) -> Any:
        return leaf[..., rows] if isinstance(leaf, np.ndarray) and leaf.ndim and leaf.shape[-1] == runs else leaf

    return state if len(rows) == runs else walk(some, state)


def side_by_side(states: list[Any], draws: int) -> Any:
    """States of one tracker as one state whose last axis holds the draws of the first, then those of the second, ...

    What is alike in all stays shared. Raises ``TypeError`` where something differs that has no axis of draws.
    """

    def joined(first: Any, *others: Any) -> Any:
        leaves = (first, *others)
        if isinstance(first, np.ndarray) and first.ndim:
            if all(leaf.shape == first.shape and np.array_equal(first, leaf) for leaf in others):
                return first if first.shape[-1] != draws or draws == 1 else np.concatenate(leaves, axis=-1)
            if all(leaf.shape[-1] in (1, draws) for leaf in leaves):
                return np.concatenate([np.broadcast_to(leaf, (*leaf.shape[:-1], draws)) for leaf in leaves], axis=-1)
        elif isinstance(first, int | float | np.generic):
            return first if all(leaf == first for leaf in others) else np.repeat(leaves, draws)
        elif all(leaf is first for leaf in others):
            return first
        raise TypeError(f"states of the type {type(first).__name__} cannot stand side by side")

    return walk(joined, *states)


def choose(mask: np.ndarray, one: Any, other: Any) -> Any:
    """``one`` in the runs (*B) of the mask, ``other`` elsewhere.

    What is the same in both, or is not an array (a count of epochs, a name), is taken from ``other``.
    """

    def chosen(leaf: Any, otherwise: Any) -> Any:
        is_array = isinstance(otherwise, np.ndarray | np.generic)
        return np.where(mask, leaf, otherwise) if is_array and leaf is not otherwise else otherwise

    return walk(chosen, one, other)
