"""Terms as components of a JSBSim system: an ``fcs_function`` for each assignment, in the order of the source."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable

from sim.interchange.jsbsim_system.terms import LARGEST, PROPERTY, VALUE, Term

Element = ElementTree.Element


class Written:
    """Writes terms into channels; what one channel has worked out, another may read."""

    def __init__(self, prefix: str) -> None:
        self.prefix = prefix
        self._property: dict[int, str] = {}  # of terms that are components, by their number
        self._names: dict[str, int] = {}

    def channel(self, name: str, outputs: Iterable[tuple[str, Term]], execute: str | None = None) -> Element:
        """A channel that works the outputs out and then sets them, each the property of a name.

        All are worked out before the first is set: what a flight remembers may be read until the end.
        """
        outputs = list(outputs)
        channel = Element("channel", {"name": name} | ({"execute": execute} if execute else {}))
        for term in self._needed([term for _, term in outputs], {target for target, _ in outputs}):
            label = self._free(term.label or term.place)
            channel.append(_component(label, self._expression(term)))
            self._property[term.number] = label
        for target, term in outputs:
            channel.append(_component(target, self._expression(term)))
        return channel

    def _needed(self, wanted: list[Term], targets: set[str]) -> list[Term]:
        """The terms that become components, in the order in which they were made.

        These are all that have a name, that are used twice, or that would read what is set before them.
        """
        found: dict[int, Term] = {}
        uses: dict[int, int] = {}
        waiting = list(wanted)
        while waiting:
            term = waiting.pop()
            if term.number in self._property:
                continue
            uses[term.number] = uses.get(term.number, 0) + 1
            if term.number not in found:
                found[term.number] = term
                waiting += term.arguments
        reads: set[int] = set()
        for number, term in sorted(found.items()):
            if (term.operation == PROPERTY and term.data in targets) or any(
                one.number in reads for one in term.arguments
            ):
                reads.add(number)
        ends = {term.number for term in wanted} & reads
        return [
            term
            for number, term in sorted(found.items())
            if number in ends or (not term.is_leaf and (term.label or uses[number] > 1))
        ]

    def _free(self, label: str) -> str:
        """A property's name of its own for a label."""
        self._names[label] = count = self._names.get(label, 0) + 1
        return f"{self.prefix}/{label}" + (f"-{count}" if count > 1 else "")

    def _expression(self, term: Term) -> Element:
        """A term as an element: its component, where it is one, or its operation."""
        known = self._property.get(term.number)
        if known is not None or term.operation == PROPERTY:
            return _leaf("property", known or str(term.data))
        if term.operation == VALUE:
            return _leaf("value", written(term.data))
        element = Element(term.operation)
        element.extend(self._expression(one) for one in term.arguments)
        return element


def written(number: float) -> str:
    """A number with all its digits; infinity as the largest number there is."""
    return repr(min(max(float(number), -LARGEST), LARGEST))


def _leaf(tag: str, text: str) -> Element:
    element = Element(tag)
    element.text = text
    return element


def _component(name: str, expression: Element) -> Element:
    component = Element("fcs_function", {"name": name})
    ElementTree.SubElement(component, "function").append(expression)
    return component
