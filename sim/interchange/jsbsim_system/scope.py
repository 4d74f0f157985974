"""One call of a function that is translated: its variables, its place, and what it needs to go on."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any

from sim.interchange.jsbsim_system.terms import Refused, Term, Terms
from sim.interchange.jsbsim_system.values import UNSET, Alternative, Guarded, parts


class Scope:
    """The variables of one call, by name."""

    def __init__(
        self, function: FunctionType, names: dict[str, Any], terms: Terms, call: Callable[..., Any], depth: int
    ) -> None:
        self.names, self.terms, self.depth = names, terms, depth
        self._call = call
        cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
        around = {name: cell.cell_contents for name, cell in cells}
        self._outside = {**vars(builtins), **function.__globals__, **around}
        self.title = function.__qualname__.replace("<locals>.", "").replace(".", "/")
        self._file, self._first = Path(function.__code__.co_filename).name, function.__code__.co_firstlineno

    def __getitem__(self, name: str) -> Any:
        value = self.names.get(name, self._outside.get(name, UNSET))
        if value is UNSET:
            raise Refused(f"'{name}' is not set on every way to here")
        return value

    def call(self, called: Any, *arguments: Any, **named: Any) -> Any:
        """Call a function from here."""
        return self._call(called, arguments, named, self.depth)

    def line(self, node: ast.AST) -> int:
        """The line of a node in its file."""
        return self._first + getattr(node, "lineno", 1) - 1

    def placed(self, error: Refused, node: ast.AST) -> Refused:
        """The same refusal with its line; the innermost line stays."""
        if error.is_placed:
            return error
        return Refused(f"{self._file}, line {self.line(node)}, in {self.title.replace('/', '.')}: {error}", True)

    def bind(self, target: ast.AST, value: Any) -> None:
        """Give variables their values, and what is worked out for them their names."""
        match target:
            case ast.Name(name):
                self.names[name] = self.labelled(value, name)
            case ast.Tuple(targets) | ast.List(targets):
                values = sequence(value)
                starred = next((place for place, one in enumerate(targets) if isinstance(one, ast.Starred)), None)
                if starred is not None:
                    after = len(values) - (len(targets) - starred - 1)
                    values[starred:after] = [values[starred:after]]
                if len(values) != len(targets):
                    raise Refused(f"{len(values)} values for {len(targets)} names")
                for one, part in zip(targets, values, strict=True):
                    self.bind(one.value if isinstance(one, ast.Starred) else one, part)
            case _:
                raise Refused(f"'{ast.unparse(target)}' cannot be set here")

    def labelled(self, value: Any, name: str) -> Any:
        """The value, its terms named by the variable that first holds them."""
        if isinstance(value, Term):
            if not value.is_leaf and value.label is None:
                value.label = f"{self.title}/{name}"
        elif isinstance(value, tuple) and not isinstance(value, Alternative | Guarded):
            for place, one in parts(value, name):
                self.labelled(one, place)
        return value


def sequence(value: Any) -> list[Any]:
    """The elements of what has a known number of them."""
    if isinstance(value, Term | Alternative | Guarded):
        raise Refused("how many there are is known in flight only")
    return list(value)
