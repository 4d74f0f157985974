"""Reading XML that somebody else wrote: bounded in size and depth, confined to its folder, without devices.

What may open files or sockets is dropped; what would steer the simulator itself is refused.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

from aircraft.errors import ModelError

LARGEST_FILE = 4_000_000  # bytes; the largest stock file has 0.3 MB
DEEPEST = 64  # elements inside one another; the deepest stock file has 13
MOST_ELEMENTS = 100_000  # of one file; the largest stock file has 1300
OF_THE_SIMULATOR = "simulation"  # properties below it write files, stop time or reset the aircraft
HARMLESS = ("sim-time-sec", "dt", "frame", "trim-completed", "integrator")  # they tell, or stop this aircraft's motion
REFUSED_ELEMENTS = {
    "child": "another aircraft inside it",
    "planet": "a planet of its own",
}


def confined(path: Path, home: Path, largest: int = LARGEST_FILE) -> bytes:
    """The content of a regular file of bounded size inside ``home``; raises ``ModelError``."""
    try:
        if path.is_symlink() or not path.resolve().is_relative_to(home.resolve()):
            raise ModelError(f"'{path.name}' is a link out of its folder, which a model may not hold")
        if not path.is_file():
            raise ModelError(f"'{path.name}' is no regular file")
        with path.open("rb") as file:
            content = file.read(largest + 1)
    except OSError as error:
        raise ModelError(f"'{path.name}' cannot be read: {error.strerror}") from None
    if len(content) > largest:
        raise ModelError(f"'{path.name}' is larger than {largest / 1e6:g} MB")
    return content


def parse(path: Path, home: Path, doctype_allowed: bool = False) -> ElementTree.Element:
    """The root of an XML file inside ``home``, without devices; raises ``ModelError``."""
    parser = ElementTree.XMLParser(target=_Builder(path.name, doctype_allowed))
    try:
        root: ElementTree.Element = ElementTree.fromstring(confined(path, home), parser)
    except ModelError:
        raise
    except ElementTree.ParseError as error:
        raise ModelError(f"'{path.name}' is not well-formed XML: {error}") from None
    except (LookupError, ValueError) as error:
        raise ModelError(f"'{path.name}' cannot be read: {error}") from None
    _drop_devices(root)
    _refuse_what_steers(root, path.name)
    return root


class _Builder:
    """Builds the tree while the file is read, and stops at the first thing that no model needs."""

    def __init__(self, name: str, doctype_allowed: bool) -> None:
        self._name = name
        self._doctype_allowed = doctype_allowed
        self._tree = ElementTree.TreeBuilder()
        self._depth = self._count = 0
        self.data = self._tree.data
        self.close = self._tree.close

    def start(self, tag: str, attributes: dict[str, str]) -> ElementTree.Element:
        self._depth += 1
        self._count += 1
        if self._depth > DEEPEST:
            raise ModelError(f"'{self._name}' nests more than {DEEPEST} elements in one another")
        if self._count > MOST_ELEMENTS:
            raise ModelError(f"'{self._name}' has more than {MOST_ELEMENTS} elements")
        return self._tree.start(tag, attributes)

    def end(self, tag: str) -> ElementTree.Element:
        self._depth -= 1
        return self._tree.end(tag)

    def doctype(self, *_: object) -> None:
        """Entities of the stock files are internal; external ones stay unresolved in any case."""
        if not self._doctype_allowed:
            raise ModelError("a model may not have a DOCTYPE, which can name other files")


def _drop_devices(root: ElementTree.Element) -> None:
    """Drop what opens files or sockets. Inside control systems <input> and <output> name a property, nothing more."""
    for parent in list(root.iter()):
        for child in list(parent):
            is_device = parent is root or len(child) > 0 or bool(child.attrib)
            if child.tag in ("input", "output") and is_device:
                parent.remove(child)


def _refuse_what_steers(root: ElementTree.Element, name: str) -> None:
    for element in root.iter():
        if element.tag in REFUSED_ELEMENTS:
            raise ModelError(f"'{name}' has a <{element.tag}>: a model may not bring {REFUSED_ELEMENTS[element.tag]}")
        for text in (element.text, element.tail, *element.attrib.values()):
            if text and OF_THE_SIMULATOR in text:
                for steering in _steering(text):
                    raise ModelError(f"'{name}' uses a property that steers the simulator: '{steering}'")


def _steering(text: str) -> Iterator[str]:
    """Properties in a text that are of the simulator and may do harm, however they are written."""
    for word in text.split():
        parts = [part.partition("[")[0] for part in word.split("/") if part not in ("", ".")]
        for number, part in enumerate(parts[:-1]):
            if part.lstrip("-+!") == OF_THE_SIMULATOR and parts[number + 1] not in HARMLESS:
                yield word
