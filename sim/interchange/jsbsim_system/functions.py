"""Functions of Python that JSBSim has too, or that need nothing but what it has."""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from sim.interchange.jsbsim_system.operators import arithmetic, compared, kind_of, truth
from sim.interchange.jsbsim_system.terms import LARGEST, Refused, Term, Terms
from sim.interchange.jsbsim_system.values import Guarded, merge

BLIND = (zip, enumerate, reversed, itertools.pairwise, tuple, list, len, itertools.chain)  # look at no element
SAME = {  # name in JSBSim of a function of one or two numbers
    math.sin: "sin",
    math.cos: "cos",
    math.tan: "tan",
    math.asin: "asin",
    math.acos: "acos",
    math.atan: "atan",
    math.atan2: "atan2",
    math.sqrt: "sqrt",
    math.exp: "exp",
    math.fabs: "abs",
    math.pow: "pow",
}


def _hypot(terms: Terms, *parts: Any) -> Any:
    squares = [arithmetic(terms, ast.Mult, one, one) for one in parts]
    return terms.apply("sqrt", _sum(terms, squares))


def _sum(terms: Terms, values: Any, start: Any = 0) -> Any:
    total = start
    for value in values:
        total = value if total == 0 and not isinstance(total, Term) else arithmetic(terms, ast.Add, total, value)
    return total


def _extreme(name: str, ordinary: Callable[..., Any]) -> Callable[..., Any]:
    def extreme(terms: Terms, *values: Any) -> Any:
        if len(values) == 1:
            values = tuple(values[0])
        kinds = {kind_of(value) for value in values}
        return terms.apply(name, *values, kind=int if kinds <= {int, bool} else float, now=ordinary)

    return extreme


def _remainder(terms: Terms, value: Any, divisor: Any) -> Any:
    """IEEE remainder; JSBSim rounds halves away from zero, so exactly half a turn may have the other sign."""
    if isinstance(divisor, Term):
        raise Refused("a remainder needs a divisor that is known before the flight")
    return terms.apply("difference", value, terms.apply("roundmultiple", value, divisor))


def _absolute(terms: Terms, value: Any) -> Any:
    return terms.apply("abs", value, kind=int if kind_of(value) in (int, bool) else float, now=abs)


def _copysign(terms: Terms, size: Any, sign: Any) -> Any:
    size = _absolute(terms, size)
    return merge(terms, compared(terms, ast.Lt, sign, 0.0), arithmetic(terms, ast.Mult, -1.0, size), size)


def _float(terms: Terms, value: Any) -> Any:
    if not isinstance(value, Term) or value.kind is str:
        raise Refused("float() of what is no number")
    return value if value.kind is float else terms.apply("sum", value, 0.0)


def _isinstance(terms: Terms, value: Any, kinds: Any) -> bool:
    return issubclass(kind_of(value), kinds)


def _next(terms: Terms, values: Any, *default: Any) -> Any:
    """The first that is given; the default where none is."""
    if not isinstance(values, Guarded):
        return next(iter(values), *default)
    if not default and values.values[-1][0] is not True:
        default = (values.values[-1][1],)  # Python would raise, and the flight not be one
    found = default[0] if default else values.values[-1][1]
    for given, value in reversed(values.values):
        found = merge(terms, given, value, found)
    return found


def _clip(terms: Terms, value: Any, low: Any, high: Any) -> Any:
    return terms.apply("min", terms.apply("max", value, low, now=max), high, now=min)


KNOWN: dict[Any, Callable[..., Any]] = {
    math.hypot: _hypot,
    math.remainder: _remainder,
    math.copysign: _copysign,
    math.log: lambda terms, value: terms.apply("ln", value),
    math.isinf: lambda terms, value: terms.apply("ge", _absolute(terms, value), LARGEST, kind=bool),
    math.radians: lambda terms, value: terms.apply("product", value, math.pi / 180.0),
    math.degrees: lambda terms, value: terms.apply("product", value, 180.0 / math.pi),
    abs: _absolute,
    min: _extreme("min", min),
    max: _extreme("max", max),
    np.minimum: _extreme("min", min),
    np.maximum: _extreme("max", max),
    np.negative: lambda terms, value: terms.apply("product", -1.0, value),
    np.clip: _clip,
    sum: _sum,
    bool: truth,
    float: _float,
    isinstance: _isinstance,
    next: _next,
    any: lambda terms, values: terms.any([truth(terms, value) for value in values]),
    all: lambda terms, values: terms.all([truth(terms, value) for value in values]),
}
