"""Terms: arithmetic that is still to be done, as a graph in which equal terms are one.

A term has the operations of JSBSim's functions and the kind of number that Python would have there. What can be worked
out now is worked out now, by Python; nothing else is rearranged, so that a rounding stays where the source has it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NoReturn

VALUE, PROPERTY = "value", "property"
LARGEST = 1.7976931348623157e308  # stands for infinity, which JSBSim does not read
KINDS = (float, int, bool, str)


class Refused(Exception):
    """Something that cannot be said in JSBSim; ``is_placed`` once the sentence has its line."""

    def __init__(self, said: str, is_placed: bool = False) -> None:
        super().__init__(said)
        self.is_placed = is_placed


class Term:
    """One operation on terms, a number, or a property; made by the functions below only."""

    __slots__ = ("arguments", "data", "kind", "label", "number", "operation", "place")

    def __init__(self, operation: str, arguments: tuple[Term, ...], data: Any, kind: type, number: int) -> None:
        self.operation, self.arguments, self.data, self.kind = operation, arguments, data, kind
        self.number = number  # terms rise in the order in which they are made
        self.label: str | None = None  # the name that the source gives it
        self.place = ""  # where the source has it

    def __bool__(self) -> NoReturn:
        """Nobody may take a branch on what is not known yet."""
        raise Refused("a number that is known in flight only decides here")

    @property
    def is_leaf(self) -> bool:
        """Whether there is nothing to do."""
        return self.operation in (VALUE, PROPERTY)


class Terms:
    """Makes terms, each one once."""

    def __init__(self) -> None:
        self._known: dict[Any, Term] = {}
        self.here = "system"  # where in the source one is
        self.texts: list[str] = [""]  # a text that a flight remembers is a number there: its place in this list

    def __len__(self) -> int:
        """How many there are."""
        return len(self._known)

    def _made(self, operation: str, arguments: tuple[Term, ...], data: Any, kind: type) -> Term:
        key = operation, tuple(id(one) for one in arguments), repr(data), kind
        if key not in self._known:
            self._known[key] = Term(operation, arguments, data, kind, len(self._known))
            self._known[key].place = self.here
        return self._known[key]

    def property(self, name: str, kind: type = float) -> Term:
        """What a property of JSBSim will hold."""
        return self._made(PROPERTY, (), name, kind)

    def of(self, value: Any) -> Term:
        """A number, a truth or a text as a term."""
        if isinstance(value, Term):
            return value
        if isinstance(value, str):
            if value not in self.texts:
                self.texts.append(value)
            return self._made(VALUE, (), float(self.texts.index(value)), str)
        if not isinstance(value, int | float):
            raise Refused(f"a {type(value).__name__} is no number")
        if math.isnan(value):
            raise Refused("a value that is no number (NaN) cannot be written")
        return self._made(VALUE, (), value, type(value) if type(value) in KINDS else float)

    def apply(self, operation: str, *values: Any, kind: type = float, now: Callable[..., Any] | None = None) -> Any:
        """An operation of JSBSim on numbers; done by ``now`` where all of them are known."""
        if now is not None and not any(isinstance(value, Term) for value in values):
            return now(*values)
        return self._made(operation, tuple(map(self.of, values)), None, kind)

    def negation(self, value: Any) -> Any:
        """``not``."""
        if not isinstance(value, Term):
            return not value
        return value.arguments[0] if value.operation == "not" else self._made("not", (value,), None, bool)

    def all(self, values: list[Any]) -> Any:
        """``and`` of truths."""
        open_ = [value for value in values if isinstance(value, Term)]
        if not all(value for value in values if not isinstance(value, Term)):
            return False
        return True if not open_ else open_[0] if len(open_) == 1 else self._made("and", tuple(open_), None, bool)

    def any(self, values: list[Any]) -> Any:
        """``or`` of truths."""
        open_ = [value for value in values if isinstance(value, Term)]
        if any(value for value in values if not isinstance(value, Term)):
            return True
        return False if not open_ else open_[0] if len(open_) == 1 else self._made("or", tuple(open_), None, bool)

    def choice(self, condition: Term, then: Any, otherwise: Any) -> Any:
        """One of two numbers, truths or texts, by a truth."""
        if then is otherwise or (type(then) is type(otherwise) and not isinstance(then, Term) and then == otherwise):
            return then
        if then is True and otherwise is False:
            return condition
        if then is False and otherwise is True:
            return self.negation(condition)
        a, b = self.of(then), self.of(otherwise)
        if (a.kind is str) is not (b.kind is str):
            raise Refused("one branch gives a text, the other a number")
        kind = a.kind if a.kind is b.kind else int if {a.kind, b.kind} == {int, bool} else float
        return self._made("ifthen", (condition, a, b), None, kind)
