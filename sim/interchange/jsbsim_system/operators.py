"""Python's operators, comparisons, attributes and subscripts on what is known in flight only."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable
from typing import Any

from sim.interchange.jsbsim_system.terms import Refused, Term, Terms
from sim.interchange.jsbsim_system.values import Alternative, each, is_open, merge

ARITHMETIC: dict[type, tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Add: ("sum", operator.add),
    ast.Sub: ("difference", operator.sub),
    ast.Mult: ("product", operator.mul),
    ast.Div: ("quotient", operator.truediv),
    ast.Pow: ("pow", operator.pow),
}
ORDER: dict[type, tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Lt: ("lt", operator.lt),
    ast.LtE: ("le", operator.le),
    ast.Gt: ("gt", operator.gt),
    ast.GtE: ("ge", operator.ge),
}


def kind_of(value: Any) -> type:
    """The kind of number that a value is."""
    return value.kind if isinstance(value, Term) else type(value)


def truth(terms: Terms, value: Any) -> Any:
    """Whether Python takes a value for true: a bool, or a term of one."""
    if isinstance(value, Alternative):
        return each(terms, value, lambda one: truth(terms, one))
    if not isinstance(value, Term):
        return bool(value)
    return value if value.kind is bool else terms.apply("nq", value, "" if value.kind is str else 0, kind=bool)


def arithmetic(terms: Terms, kind: type, a: Any, b: Any) -> Any:
    """``a + b`` and its like."""
    if not (isinstance(a, Term) or isinstance(b, Term)):
        if kind in ARITHMETIC:
            return ARITHMETIC[kind][1](a, b)
        other: dict[type, Any] = {ast.Mod: operator.mod, ast.FloorDiv: operator.floordiv}
        if kind not in other:
            raise Refused(f"the operator {kind.__name__} is not known here")
        return other[kind](a, b)
    if str in (kind_of(a), kind_of(b)) or not all(isinstance(one, Term | int | float) for one in (a, b)):
        raise Refused("arithmetic on what is no number")
    if kind is ast.Mod:  # of Python: it has the sign of the divisor
        if isinstance(b, Term) or not b > 0:
            raise Refused("a remainder needs a positive divisor that is known before the flight")
        rest = terms.apply("fmod", a, b)
        return terms.choice(terms.apply("lt", rest, 0.0, kind=bool), terms.apply("sum", rest, b), rest)
    if kind not in ARITHMETIC:
        raise Refused(f"the operator {kind.__name__} is not known here")
    whole = kind in (ast.Add, ast.Sub, ast.Mult) and {kind_of(a), kind_of(b)} <= {int, bool}
    return terms.apply(ARITHMETIC[kind][0], a, b, kind=int if whole else float)


def unary(terms: Terms, kind: type, value: Any) -> Any:
    """``-a``, ``+a``, ``not a``."""
    if kind is ast.Not:
        return terms.negation(truth(terms, value))
    if kind is ast.USub:
        return -value if not isinstance(value, Term) else terms.apply("product", -1.0, value, kind=value.kind)
    if kind is ast.UAdd:
        return value
    raise Refused(f"the operator {kind.__name__} is not known here")


def compared(terms: Terms, kind: type, a: Any, b: Any) -> Any:
    """One comparison: a bool, or a term of one."""
    if isinstance(a, Alternative):
        return each(terms, a, lambda one: compared(terms, kind, one, b))
    if isinstance(b, Alternative):
        return each(terms, b, lambda one: compared(terms, kind, a, one))
    if kind in (ast.IsNot, ast.NotEq, ast.NotIn):
        positive = {ast.IsNot: ast.Is, ast.NotEq: ast.Eq, ast.NotIn: ast.In}[kind]
        return terms.negation(compared(terms, positive, a, b))
    if kind is ast.In:
        return terms.any([compared(terms, ast.Eq, a, one) for one in b])
    if not (is_open(a) or is_open(b)):
        if kind in ORDER:
            return ORDER[kind][1](a, b)
        return a is b if kind is ast.Is else a == b
    if kind is ast.Is and not (kind_of(a) is bool and kind_of(b) is bool):
        if a is None or b is None:
            return False
        raise Refused("'is' between numbers that are known in flight only")
    if kind in (ast.Eq, ast.Is):
        if isinstance(a, tuple) and isinstance(b, tuple):
            if len(a) != len(b):
                return False
            return terms.all([compared(terms, kind, one, other) for one, other in zip(a, b, strict=True)])
        if not all(isinstance(one, Term | int | float | str) for one in (a, b)):
            return False
        if (kind_of(a) is str) is not (kind_of(b) is str):
            return False
        return terms.apply("eq", a, b, kind=bool)
    if kind in ORDER:
        return _ordered(terms, kind, a, b)
    raise Refused(f"the comparison {kind.__name__} is not known here")


def _ordered(terms: Terms, kind: type, a: Any, b: Any) -> Any:
    """``a < b`` and its like; what infinity decides is known now."""
    for one, other, far in ((a, b, 1.0), (b, a, -1.0)):
        if not isinstance(one, Term) and math.isinf(one) and isinstance(other, Term):
            return ORDER[kind][1](far * one, 0.0)
    return terms.apply(ORDER[kind][0], a, b, kind=bool)


def item(terms: Terms, of: Any, index: Any) -> Any:
    """``of[index]``; where the place is known in flight only, each is compared with it, the last is what remains."""
    if isinstance(of, Alternative):
        return each(terms, of, lambda one: item(terms, one, index))
    if not isinstance(index, Term):
        return of[index]
    if not isinstance(of, tuple | list) or not of:
        raise Refused("a place that is known in flight only needs a tuple")
    found = of[-1]
    for place in range(len(of) - 2, -1, -1):
        found = merge(terms, terms.apply("eq", index, place, kind=bool), of[place], found)
    return found
