"""Python's syntax tree, walked with numbers that are known in flight only: what it would do becomes terms.

A function is read as it stands, branch by branch. Where a number of the flight decides, both ways are walked and each
variable is one or the other; where everything is known, Python itself does it. Loops are over what is known. What is
not known here is refused with its line, so that nothing is translated by halves.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import textwrap
from collections.abc import Callable
from pathlib import Path
from types import FunctionType, MethodType
from typing import Any, NamedTuple

from sim.interchange.jsbsim_system import operators
from sim.interchange.jsbsim_system.functions import BLIND, KNOWN, SAME
from sim.interchange.jsbsim_system.terms import Refused, Term, Terms
from sim.interchange.jsbsim_system.values import UNSET, Alternative, Guarded, each, is_open, merge, parts

DEEPEST = 40  # calls within calls


class Returned(NamedTuple):
    """What a function gives back."""

    value: Any


class Placed(Refused):
    """A refusal that knows its line."""


class Scope:
    """One call of a function: its variables, and where it stands."""

    def __init__(self, function: FunctionType, names: dict[str, Any], depth: int) -> None:
        self.names, self.depth = names, depth
        self.globals = {**vars(builtins), **function.__globals__}
        cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
        self.globals |= {name: cell.cell_contents for name, cell in cells}
        self.title = function.__qualname__.replace("<locals>.", "").replace(".", "/")
        self.file, self.line = Path(function.__code__.co_filename).name, function.__code__.co_firstlineno

    def __getitem__(self, name: str) -> Any:
        value = self.names.get(name, self.globals.get(name, UNSET))
        if value is UNSET:
            raise Refused(f"'{name}' is not set on every way to here")
        return value


class Translation:
    """Calls Python functions with terms; see the module."""

    def __init__(self, terms: Terms) -> None:
        self.terms = terms
        self._trees: dict[Any, ast.FunctionDef] = {}

    def call(self, function: Any, *arguments: Any, depth: int = 0, **named: Any) -> Any:
        """What a function gives for arguments that may hold terms; raises ``Refused`` with the line in question."""
        if isinstance(function, Alternative):
            return each(self.terms, function, lambda one: self.call(one, *arguments, depth=depth, **named))
        if function is next:  # of a comprehension, which is no iterator here
            return KNOWN[next](self.terms, *arguments)
        owner = getattr(function, "__self__", None)
        if function in BLIND or not any(map(is_open, (*arguments, *named.values(), owner))):
            return function(*arguments, **named)
        if function in SAME:
            return self.terms.apply(SAME[function], *arguments, **named)
        if function in KNOWN:
            return KNOWN[function](self.terms, *arguments, **named)
        if function == tuple.__new__ or function is self._replace_of(function):
            return function(*arguments, **named)
        if isinstance(function, type):
            if not issubclass(function, tuple):
                raise Refused(f"a {function.__name__} cannot be made in flight")
            return function(*arguments, **named)
        if isinstance(function, MethodType):
            return self._walked(function.__func__, (function.__self__, *arguments), named, depth)
        if isinstance(function, FunctionType):
            return self._walked(function, arguments, named, depth)
        method = getattr(type(function), "__call__", None)
        if isinstance(method, FunctionType):
            return self._walked(method, (function, *arguments), named, depth)
        raise Refused(f"the function '{getattr(function, '__name__', function)}' is not known here")

    @staticmethod
    def _replace_of(function: Any) -> Any:
        """The function itself where it is ``_replace`` of a named tuple, which looks at no element."""
        owner = getattr(function, "__self__", None)
        return function if isinstance(owner, tuple) and function.__name__ == "_replace" else None

    def _walked(self, function: Any, arguments: tuple[Any, ...], named: dict[str, Any], depth: int) -> Any:
        """Walk the body of a function."""
        if depth > DEEPEST:
            raise Refused(f"'{function.__qualname__}' calls itself")
        bound = inspect.signature(function).bind(*arguments, **named)
        bound.apply_defaults()
        scope = Scope(function, dict(bound.arguments), depth + 1)
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

    # statements

    def _run(self, statements: list[ast.stmt], scope: Scope) -> Returned | None:
        for place, statement in enumerate(statements):
            try:
                match statement:
                    case ast.Return(value):
                        return Returned(None if value is None else self._evaluate(value, scope))
                    case ast.If():
                        outcome = self._branch(statement, statements[place + 1 :], scope)
                        if outcome is not None:
                            return outcome
                    case ast.For():
                        self._loop(statement, scope)
                    case ast.Assign(targets, value):
                        found = self._evaluate(value, scope)
                        for target in targets:
                            self._bind(target, found, scope)
                    case ast.AnnAssign(target, _, value) if value is not None:
                        self._bind(target, self._evaluate(value, scope), scope)
                    case ast.AugAssign(ast.Name(name), operation, value):
                        changed = self._arithmetic(operation, scope[name], self._evaluate(value, scope))
                        self._bind(statement.target, changed, scope)
                    case ast.Expr(ast.Constant()) | ast.Pass() | ast.Assert() | ast.AnnAssign():
                        pass
                    case _:
                        raise Refused(f"'{ast.unparse(statement).splitlines()[0]}' is not known here")
            except Refused as error:
                raise self._placed(error, statement, scope) from None
        return None

    def _placed(self, error: Refused, node: ast.AST, scope: Scope) -> Placed:
        """The same refusal with the line of the innermost place."""
        if isinstance(error, Placed):
            return error
        line = scope.line + getattr(node, "lineno", 1) - 1
        return Placed(f"{scope.file}, line {line}, in {scope.title.replace('/', '.')}: {error}")

    def _branch(self, statement: ast.If, rest: list[ast.stmt], scope: Scope) -> Returned | None:
        """One way where the condition is known, else both."""
        condition = self._truth(statement.test, scope)
        ends = any(isinstance(node, ast.Return) for node in ast.walk(statement))
        if not isinstance(condition, Term):
            way = statement.body if condition else statement.orelse
            return (self._run([*way, *rest], scope) or Returned(None)) if ends else self._run(way, scope)
        before, ways, outcomes = scope.names, [], []
        for way in (statement.body, statement.orelse):
            scope.names = dict(before)
            outcomes.append(self._run([*way, *rest] if ends else way, scope))
            ways.append(scope.names)
        scope.names = before
        if ends:  # whoever returned early has not walked the rest
            then, otherwise = (None if one is None else one.value for one in outcomes)
            return Returned(merge(self.terms, condition, then, otherwise))
        for name in dict.fromkeys((*ways[0], *ways[1])):
            then, otherwise = (way.get(name, UNSET) for way in ways)
            if then is not otherwise:
                before[name] = self._labelled(merge(self.terms, condition, then, otherwise), name, scope)
        return None

    def _loop(self, statement: ast.For, scope: Scope) -> None:
        """A loop over what is known, once for each."""
        if statement.orelse or any(isinstance(node, ast.Return | ast.Break | ast.Continue) for node in ast.walk(statement)):
            raise Refused("a loop that is left early is not known here")
        for value in self._sequence(self._evaluate(statement.iter, scope)):
            self._bind(statement.target, value, scope)
            self._run(statement.body, scope)

    def _bind(self, target: ast.AST, value: Any, scope: Scope) -> None:
        """Give variables their values and what is worked out their names."""
        match target:
            case ast.Name(name):
                scope.names[name] = self._labelled(value, name, scope)
            case ast.Tuple(targets) | ast.List(targets):
                values = list(self._sequence(value))
                starred = next((place for place, one in enumerate(targets) if isinstance(one, ast.Starred)), None)
                if starred is not None:
                    after = len(values) - (len(targets) - starred - 1)
                    values[starred:after] = [values[starred:after]]
                if len(values) != len(targets):
                    raise Refused(f"{len(values)} values for {len(targets)} names")
                for part, one in zip(targets, values, strict=True):
                    self._bind(part.value if isinstance(part, ast.Starred) else part, one, scope)
            case _:
                raise Refused(f"'{ast.unparse(target)}' cannot be set here")

    def _labelled(self, value: Any, name: str, scope: Scope) -> Any:
        """The value, its terms named by the variable that first holds them."""
        if isinstance(value, Term):
            if not value.is_leaf and value.label is None:
                value.label = f"{scope.title}/{name}"
        elif isinstance(value, tuple) and not isinstance(value, Alternative):
            for place, one in parts(value, name):
                self._labelled(one, place, scope)
        return value

    # expressions

    def _evaluate(self, node: ast.expr, scope: Scope) -> Any:
        try:
            return self._value(node, scope)
        except Refused as error:
            raise self._placed(error, node, scope) from None
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            raise self._placed(Refused(str(error)), node, scope) from None

    def _value(self, node: ast.expr, scope: Scope) -> Any:
        terms, evaluate = self.terms, self._evaluate
        match node:
            case ast.Constant(value):
                return value
            case ast.Name(name):
                return scope[name]
            case ast.Attribute(of, name):
                return each(terms, evaluate(of, scope), lambda one: self._attribute(one, name, scope))
            case ast.Subscript(of, index):
                return operators.item(terms, evaluate(of, scope), evaluate(index, scope))
            case ast.Slice(low, high, step):
                return slice(*(None if part is None else evaluate(part, scope) for part in (low, high, step)))
            case ast.Tuple() | ast.List():
                found = self._elements(node.elts, scope)
                return tuple(found) if isinstance(node, ast.Tuple) else found
            case ast.BinOp(a, operation, b):
                return self._arithmetic(operation, evaluate(a, scope), evaluate(b, scope))
            case ast.UnaryOp(operation, of):
                return operators.unary(terms, type(operation), evaluate(of, scope))
            case ast.BoolOp(operation, parts):
                return self._junction(isinstance(operation, ast.And), parts, scope)
            case ast.Compare(first, operations, others):
                values = [evaluate(one, scope) for one in (first, *others)]
                pairs = zip(operations, values, values[1:], strict=False)
                return terms.all([operators.compared(terms, type(one), a, b) for one, a, b in pairs])
            case ast.IfExp(test, then, otherwise):
                condition = self._truth(test, scope)
                if not isinstance(condition, Term):
                    return evaluate(then if condition else otherwise, scope)
                return merge(terms, condition, evaluate(then, scope), evaluate(otherwise, scope))
            case ast.Call(function, arguments, keywords):
                values = self._elements(arguments, scope)
                named = {key.arg: evaluate(key.value, scope) for key in keywords if key.arg is not None}
                if len(named) != len(keywords):
                    raise Refused("'**' is not known here")
                return self.call(evaluate(function, scope), *values, depth=scope.depth, **named)
            case ast.GeneratorExp(of, generators) | ast.ListComp(of, generators):
                return self._comprehension(of, generators, scope)
        raise Refused(f"'{ast.unparse(node)}' is not known here")

    def _truth(self, node: ast.expr, scope: Scope) -> Any:
        return operators.truth(self.terms, self._evaluate(node, scope))

    def _arithmetic(self, operation: ast.operator, a: Any, b: Any) -> Any:
        return operators.arithmetic(self.terms, type(operation), a, b)

    def _attribute(self, of: Any, name: str, scope: Scope) -> Any:
        if isinstance(of, Term):
            if name == "__class__":
                return of.kind
            raise Refused(f"'{name}' of a number")
        if is_open(of):
            member = inspect.getattr_static(type(of), name, None)
            if isinstance(member, property):
                return self.call(member.fget, of, depth=scope.depth)
        return getattr(of, name)

    def _elements(self, nodes: list[ast.expr], scope: Scope) -> list[Any]:
        found: list[Any] = []
        for node in nodes:
            if isinstance(node, ast.Starred):
                found += self._sequence(self._evaluate(node.value, scope))
            else:
                found.append(self._evaluate(node, scope))
        return found

    @staticmethod
    def _sequence(value: Any) -> list[Any]:
        if isinstance(value, Term | Alternative | Guarded):
            raise Refused("how many there are is known in flight only")
        return list(value)

    def _junction(self, both: bool, parts: list[ast.expr], scope: Scope) -> Any:
        """``and`` and ``or``; what decides already leaves the rest alone."""
        first = self._evaluate(parts[0], scope)
        if len(parts) == 1:
            return first
        decided = operators.truth(self.terms, first)
        if not isinstance(decided, Term):
            return self._junction(both, parts[1:], scope) if decided is both else first
        rest = self._junction(both, parts[1:], scope)
        if operators.kind_of(first) is bool and operators.kind_of(rest) is bool:
            return self.terms.all([decided, rest]) if both else self.terms.any([decided, rest])
        return merge(self.terms, decided, rest, first) if both else merge(self.terms, decided, first, rest)

    def _comprehension(self, of: ast.expr, generators: list[ast.comprehension], scope: Scope) -> Any:
        """All that a comprehension gives at once; with their conditions where these are known in flight only."""
        if len(generators) != 1:
            raise Refused("a comprehension with several loops is not known here")
        (loop,) = generators
        outer, found = scope.names, []
        for value in self._sequence(self._evaluate(loop.iter, scope)):
            scope.names = dict(outer)
            self._bind(loop.target, value, scope)
            given = self.terms.all([self._truth(test, scope) for test in loop.ifs])
            if given is not False:
                found.append((given, self._evaluate(of, scope)))
        scope.names = outer
        return [value for _, value in found] if all(one is True for one, _ in found) else Guarded(tuple(found))


def translated(terms: Terms, function: Callable[..., Any], *arguments: Any) -> Any:
    """What ``function`` gives for arguments that hold terms; raises ``Refused``."""
    return Translation(terms).call(function, *arguments)
