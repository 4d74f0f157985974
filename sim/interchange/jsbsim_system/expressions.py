"""Expressions of Python's syntax tree, worked out with numbers that are known in flight only."""

from __future__ import annotations

import ast
import inspect
from typing import Any

from sim.interchange.jsbsim_system import operators
from sim.interchange.jsbsim_system.scope import Scope, sequence
from sim.interchange.jsbsim_system.terms import Refused, Term
from sim.interchange.jsbsim_system.values import Guarded, each, is_open, merge


def evaluate(node: ast.expr, scope: Scope) -> Any:
    """The value of an expression; raises ``Refused`` with its line."""
    outside, scope.terms.here = scope.terms.here, f"{scope.title}/line-{scope.line(node)}"
    try:
        return _value(node, scope)
    except Refused as error:
        raise scope.placed(error, node) from None
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise scope.placed(Refused(str(error)), node) from None
    finally:
        scope.terms.here = outside


def truth(node: ast.expr, scope: Scope) -> Any:
    """Whether an expression is true: a bool, or a term of one."""
    return operators.truth(scope.terms, evaluate(node, scope))


def _value(node: ast.expr, scope: Scope) -> Any:
    terms = scope.terms
    match node:
        case ast.Constant(value):
            return value
        case ast.Name(name):
            return scope[name]
        case ast.Attribute(of, name):
            return each(terms, evaluate(of, scope), lambda one: _attribute(one, name, scope))
        case ast.Subscript(of, index):
            return operators.item(terms, evaluate(of, scope), evaluate(index, scope))
        case ast.Slice(low, high, step):
            return slice(*(None if part is None else evaluate(part, scope) for part in (low, high, step)))
        case ast.Tuple(parts):
            return tuple(_elements(parts, scope))
        case ast.List(parts):
            return _elements(parts, scope)
        case ast.BinOp(a, operation, b):
            return operators.arithmetic(terms, type(operation), evaluate(a, scope), evaluate(b, scope))
        case ast.UnaryOp(operation, of):
            return operators.unary(terms, type(operation), evaluate(of, scope))
        case ast.BoolOp(operation, parts):
            return _junction(isinstance(operation, ast.And), parts, scope)
        case ast.Compare(first, operations, others):
            values = [evaluate(one, scope) for one in (first, *others)]
            pairs = zip(operations, values, values[1:], strict=False)
            return terms.all([operators.compared(terms, type(one), a, b) for one, a, b in pairs])
        case ast.IfExp(test, then, otherwise):
            condition = truth(test, scope)
            if not isinstance(condition, Term):
                return evaluate(then if condition else otherwise, scope)
            return merge(terms, condition, evaluate(then, scope), evaluate(otherwise, scope))
        case ast.Call(function, arguments, keywords):
            values = _elements(arguments, scope)
            named = {key.arg: evaluate(key.value, scope) for key in keywords if key.arg is not None}
            if len(named) != len(keywords):
                raise Refused("'**' is not known here")
            return scope.call(evaluate(function, scope), *values, **named)
        case ast.GeneratorExp(of, loops) | ast.ListComp(of, loops):
            return _comprehension(of, loops, scope)
    raise Refused(f"'{ast.unparse(node)}' is not known here")


def _attribute(of: Any, name: str, scope: Scope) -> Any:
    if isinstance(of, Term):
        if name == "__class__":
            return of.kind
        raise Refused(f"'{name}' of a number")
    if is_open(of):
        member = inspect.getattr_static(type(of), name, None)
        if isinstance(member, property):
            return scope.call(member.fget, of)
    return getattr(of, name)


def _elements(nodes: list[ast.expr], scope: Scope) -> list[Any]:
    found: list[Any] = []
    for node in nodes:
        if isinstance(node, ast.Starred):
            found += sequence(evaluate(node.value, scope))
        else:
            found.append(evaluate(node, scope))
    return found


def _junction(both: bool, parts: list[ast.expr], scope: Scope) -> Any:
    """``and`` and ``or``; what decides already leaves the rest alone."""
    first = evaluate(parts[0], scope)
    if len(parts) == 1:
        return first
    terms = scope.terms
    decided = operators.truth(terms, first)
    if not isinstance(decided, Term):
        return _junction(both, parts[1:], scope) if decided is both else first
    rest = _junction(both, parts[1:], scope)
    if operators.kind_of(first) is bool and operators.kind_of(rest) is bool:
        return terms.all([decided, rest]) if both else terms.any([decided, rest])
    return merge(terms, decided, rest, first) if both else merge(terms, decided, first, rest)


def _comprehension(of: ast.expr, loops: list[ast.comprehension], scope: Scope) -> Any:
    """All that a comprehension gives, at once; with their conditions where these are known in flight only."""
    if len(loops) != 1:
        raise Refused("a comprehension with several loops is not known here")
    (loop,) = loops
    outside, found = scope.names, []
    for value in sequence(evaluate(loop.iter, scope)):
        scope.names = dict(outside)
        scope.bind(loop.target, value)
        given = scope.terms.all([truth(test, scope) for test in loop.ifs])
        if given is not False:
            found.append((given, evaluate(of, scope)))
    scope.names = outside
    return [value for _, value in found] if all(one is True for one, _ in found) else Guarded(tuple(found))
