"""What a variable may hold while a function is translated: Python's own values, terms, tuples of them, alternatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from sim.interchange.jsbsim_system.terms import Refused, Term, Terms

SCALARS = (bool, int, float, str, Term)
UNSET = object()  # a variable that one of two branches has not set


class Alternative(NamedTuple):
    """One of two things that are no numbers, such as two legs of a route; a truth in flight decides."""

    condition: Term
    then: Any
    otherwise: Any


class Guarded(NamedTuple):
    """What a comprehension would give: each value with the truth by which it is given."""

    values: tuple[tuple[Any, Any], ...]


def is_open(value: Any) -> bool:
    """Whether something in it is known in flight only."""
    if isinstance(value, Term | Alternative | Guarded):
        return True
    return isinstance(value, tuple | list) and any(map(is_open, value))


def like(example: tuple[Any, ...], values: list[Any]) -> Any:
    """A tuple of the same type with other values; of a named tuple too."""
    return tuple.__new__(type(example), values)


def merge(terms: Terms, condition: Any, then: Any, otherwise: Any) -> Any:
    """What is held after a branch: that of the one or the other side."""
    if not isinstance(condition, Term):
        return then if condition else otherwise
    if then is otherwise:
        return then
    if then is UNSET or otherwise is UNSET:
        return UNSET
    if isinstance(then, SCALARS) and isinstance(otherwise, SCALARS):
        return terms.choice(condition, then, otherwise)
    if (
        isinstance(then, tuple | list)
        and not isinstance(then, Alternative)
        and type(then) is type(otherwise)
        and len(then) == len(otherwise)
    ):
        merged = [merge(terms, condition, a, b) for a, b in zip(then, otherwise, strict=True)]
        return merged if isinstance(then, list) else like(then, merged)
    return Alternative(condition, then, otherwise)


def each(terms: Terms, value: Any, do: Callable[[Any], Any]) -> Any:
    """What ``do`` gives for a value, or for each alternative of it."""
    if isinstance(value, Alternative):
        return merge(terms, value.condition, each(terms, value.then, do), each(terms, value.otherwise, do))
    return do(value)


def parts(value: tuple[Any, ...], path: str) -> list[tuple[str, Any]]:
    """Each part of a tuple with its place: fields behind a slash, others by number."""
    fields = getattr(type(value), "_fields", None)
    places = [f"-{place}" for place in range(len(value))] if fields is None else [f"/{field}" for field in fields]
    return [(f"{path}{place}".lstrip("/"), one) for place, one in zip(places, value, strict=True)]


def leaves(value: Any, path: str = "") -> list[tuple[str, Any]]:
    """The numbers of a state, each with its place."""
    if isinstance(value, tuple) and not isinstance(value, Alternative):
        return [leaf for place, one in parts(value, path) for leaf in leaves(one, place)]
    if not isinstance(value, SCALARS):
        raise Refused(f"the state '{path}' is a {type(value).__name__}, not a number")
    return [(path, value)]


def rebuilt(value: Any, new: Callable[[str, Any], Any], path: str = "") -> Any:
    """The same state with ``new(place, number)`` for each number."""
    if isinstance(value, tuple):
        return like(value, [rebuilt(one, new, place) for place, one in parts(value, path)])
    return new(path, value)
