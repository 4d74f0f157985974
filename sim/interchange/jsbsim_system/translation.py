"""Python's syntax tree, walked with numbers that are known in flight only: what it would do becomes terms.

A function is read as it stands, branch by branch. Where a number of the flight decides, both ways are walked and each
variable is one or the other; where everything is known, Python itself does it. Loops are over what is known. What is
not known here is refused with its line, so that nothing is translated by halves. Functions must be pure: what they give
for known arguments is taken once.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable
from types import CodeType, FunctionType, MethodType
from typing import Any, NamedTuple

import numpy as np

from sim.interchange.jsbsim_system import operators
from sim.interchange.jsbsim_system.expressions import evaluate, truth
from sim.interchange.jsbsim_system.functions import BLIND, KNOWN, SAME
from sim.interchange.jsbsim_system.scope import Scope, sequence
from sim.interchange.jsbsim_system.terms import Refused, Term, Terms
from sim.interchange.jsbsim_system.values import UNSET, Alternative, each, is_open, merge

DEEPEST = 40  # calls within calls


class Returned(NamedTuple):
    """What a function gives back."""

    value: Any


def translated(terms: Terms, function: Callable[..., Any], *arguments: Any) -> Any:
    """What ``function`` gives for arguments that hold terms; raises ``Refused`` with the line that is not known."""
    return _Translation(terms).call(function, arguments, {}, 0)


class _Translation:
    def __init__(self, terms: Terms) -> None:
        self.terms = terms
        self._trees: dict[CodeType, ast.FunctionDef] = {}

    def call(self, function: Any, arguments: tuple[Any, ...], named: dict[str, Any], depth: int) -> Any:
        """Python's own answer where all is known or nothing is looked at, else a term, else a walk."""
        if isinstance(function, Alternative):
            return each(self.terms, function, lambda one: self.call(one, arguments, named, depth))
        owner = getattr(function, "__self__", None)
        if function is next:  # of a comprehension, which is no iterator here
            return KNOWN[next](self.terms, *arguments)
        if function in BLIND or not any(map(is_open, (*arguments, *named.values(), owner))):
            found = function(*arguments, **named)
            return found.item() if isinstance(found, np.generic) else found
        if function in SAME:
            return self.terms.apply(SAME[function], *arguments, **named)
        if function in KNOWN:
            return KNOWN[function](self.terms, *arguments, **named)
        if function == tuple.__new__ or _is_tuple(function) or (_is_tuple(type(owner)) and _is_replace(function)):
            return function(*arguments, **named)
        if isinstance(function, MethodType):
            return self._walked(function.__func__, (owner, *arguments), named, depth)
        if isinstance(function, FunctionType):
            return self._walked(function, arguments, named, depth)
        method = inspect.getattr_static(type(function), "__call__", None)
        if isinstance(method, FunctionType):
            return self._walked(method, (function, *arguments), named, depth)
        raise Refused(f"'{getattr(function, '__name__', function)}' is not known here")

    def _walked(self, function: Any, arguments: tuple[Any, ...], named: dict[str, Any], depth: int) -> Any:
        if depth > DEEPEST:
            raise Refused(f"'{function.__qualname__}' calls itself")
        bound = inspect.signature(function).bind(*arguments, **named)
        bound.apply_defaults()
        scope = Scope(function, dict(bound.arguments), self.terms, self.call, depth + 1)
        outcome = self._run(self._tree(function).body, scope)
        return None if outcome is None else outcome.value

    def _tree(self, function: FunctionType) -> ast.FunctionDef:
        code = function.__code__
        if code not in self._trees:
            try:
                tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
            except (OSError, TypeError, SyntaxError):
                raise Refused(f"the source of '{function.__qualname__}' cannot be read") from None
            if not isinstance(tree, ast.FunctionDef):
                raise Refused(f"'{function.__qualname__}' is not an ordinary function")
            self._trees[code] = tree
        return self._trees[code]

    def _run(self, statements: list[ast.stmt], scope: Scope) -> Returned | None:
        """Walk statements until one returns."""
        for place, statement in enumerate(statements):
            try:
                outcome = self._walk(statement, statements[place + 1 :], scope)
            except Refused as error:
                raise scope.placed(error, statement) from None
            if outcome is not None:
                return outcome
        return None

    def _walk(self, statement: ast.stmt, rest: list[ast.stmt], scope: Scope) -> Returned | None:
        match statement:
            case ast.Return(value):
                return Returned(None if value is None else evaluate(value, scope))
            case ast.If():
                return self._branch(statement, rest, scope)
            case ast.For():
                self._loop(statement, scope)
            case ast.Assign(targets, value):
                found = evaluate(value, scope)
                for target in targets:
                    scope.bind(target, found)
            case ast.AnnAssign(target, _, value) if value is not None:
                scope.bind(target, evaluate(value, scope))
            case ast.AugAssign(ast.Name(name) as target, operation, value):
                before, by = scope[name], evaluate(value, scope)
                scope.bind(target, operators.arithmetic(self.terms, type(operation), before, by))
            case ast.Expr(ast.Constant()) | ast.Pass() | ast.Assert() | ast.AnnAssign():
                pass
            case _:
                raise Refused(f"'{ast.unparse(statement).splitlines()[0]}' is not known here")
        return None

    def _branch(self, statement: ast.If, rest: list[ast.stmt], scope: Scope) -> Returned | None:
        """One way where the condition is known, else both; with all that follows where one of them returns."""
        condition = truth(statement.test, scope)
        ends = any(isinstance(node, ast.Return) for node in ast.walk(statement))
        before, sides, outcomes = scope.names, [], []
        for taken, body in ((True, statement.body), (False, statement.orelse)):
            if not isinstance(condition, Term) and condition is not taken:
                continue
            scope.names = dict(before)
            outcomes.append(self._run([*body, *rest] if ends else body, scope))
            sides.append(scope.names)
        if ends:
            found = [None if one is None else one.value for one in outcomes]
            return Returned(found[0] if len(found) == 1 else merge(self.terms, condition, *found))
        scope.names = before if len(sides) == 2 else sides[0]
        for name in dict.fromkeys(name for side in sides[1:] for name in (*sides[0], *side)):
            then, otherwise = (side.get(name, UNSET) for side in sides)
            if then is not otherwise:
                before[name] = scope.labelled(merge(self.terms, condition, then, otherwise), name)
        return None

    def _loop(self, statement: ast.For, scope: Scope) -> None:
        """A loop over what is known, once for each."""
        inside = list(ast.walk(statement))
        if statement.orelse or any(isinstance(node, ast.Return | ast.Break | ast.Continue) for node in inside):
            raise Refused("a loop that is left early is not known here")
        for value in sequence(evaluate(statement.iter, scope)):
            scope.bind(statement.target, value)
            self._run(statement.body, scope)


def _is_tuple(one: Any) -> bool:
    """Whether something is a class of named tuples, which looks at no element."""
    return isinstance(one, type) and issubclass(one, tuple)


def _is_replace(function: Any) -> bool:
    return getattr(function, "__name__", "") == "_replace"
