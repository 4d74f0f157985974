"""Parts from outside: sensors, trackers, modes and wind events of installed packages and of a user's own files.

A file of Python says what it brings in one table, ``SHORTFINAL = {"sensors": {"beacon": Beacon}}``, and stands alone:
it imports what is installed, and nothing that lies beside it. An installed package says it in its entry points, in the
groups ``shortfinal.sensors``, ``.trackers``, ``.modes`` and ``.wind_events``. A scenario only names kinds, it cannot
name code; a package is imported when a scenario names a kind of it, and never because it is there.

Whatever a part is, it travels as a `Part`: plain text that any process turns into the same class.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import hashlib
import importlib
import importlib.metadata
import pickle
import re
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from sim.errors import OutputError, ScenarioError, did_you_mean, printable
from sim.scenario import catalogue
from sim.scenario.parameters import cached, model_of, parameters
from tracking.track import is_recorded

OURS = ("aircraft", "autopilot", "tracking", "sim")
FAMILIES = ("sensors", "trackers", "modes", "wind_events")
TABLE = "SHORTFINAL"
FORM = f'{TABLE} = {{"sensors": {{"kind": Class}}}}'
KIND = re.compile(r"[a-z][a-z0-9_]{0,63}")  # as the name of a file of the catalogue
LARGEST_FILE = 1 << 20  # bytes of a file of parts
LONGEST_TEXT = 300  # characters of a foreign error that are repeated
TAKEN = {"trackers": ("kind", "sensors", "handover", "association", "law")}  # keys of every table of a family


class Part(NamedTuple):
    """A kind from outside as it travels: what it is, where its class is found, and the digest of its code."""

    family: str
    kind: str
    origin: str  # where it is from, in words
    module: str
    attribute: str  # the name of the class in the module; "" = the module's table says
    digest: str  # SHA-256 of the file, or of the whole package
    text: str | None  # the file; None = of a package, which must be installed wherever the part is used

    @property
    def address(self) -> str:
        """``sensors.beacon``."""
        return f"{self.family}.{self.kind}"


@dataclass(frozen=True)
class Catalogue:
    """All kinds that a scenario can name: the bundled ones, those that were brought, and those that are installed."""

    parts: tuple[Part, ...] = ()
    settled: frozenset[Part] = frozenset()  # those of them that were chosen before, whatever is installed here

    def kinds(self, family: str) -> list[str]:
        """Names of all kinds of a family; nothing is imported for it."""
        installed = (entry.name for entry in _entries(family))
        return sorted({*catalogue.kinds(family), *(part.kind for part in self._brought(family)), *installed})

    def named(self, family: str, kind: str) -> Part | None:
        """The part from outside that has this name, None where it is bundled.

        Raises ``KeyError`` where nobody has it, ``ScenarioError`` where two have it or its package cannot be imported.
        """
        if catalogue.has(family, kind):
            return None
        brought = [part for part in self._brought(family) if part.kind == kind]
        if len(brought) == 1 and brought[0] in self.settled:
            return brought[0]
        installed = [entry for entry in _entries(family) if entry.name == kind]
        origins = [*(part.origin for part in brought), *map(_origin, installed)]
        if not origins:
            raise KeyError(kind)
        if len(origins) > 1:
            raise ScenarioError(f"kind '{kind}' comes from {' and from '.join(origins)}; leave one of them out")
        return brought[0] if brought else _installed(family, installed[0])

    def load(self, family: str, kind: str) -> type[Any]:
        """The class of a kind.

        Raises ``KeyError`` where nobody has it, ``ScenarioError`` in one sentence for a part that cannot be used.
        """
        part = self.named(family, kind)
        cls = catalogue.load(family, kind) if part is None else class_of(part)
        origin = "" if part is None else f" of {part.origin}"
        if broken := fault(cls, family) or lack(cls, family):
            raise ScenarioError(f"kind '{kind}'{origin} {broken}")
        return catalogue.completed(family, cls)

    def also(self, parts: Iterable[Part]) -> Catalogue:
        """The catalogue with parts that were found before."""
        parts = tuple(parts)
        return Catalogue(_distinct((*self.parts, *parts)), self.settled.union(parts))

    def _brought(self, family: str) -> Iterator[Part]:
        return (part for part in self.parts if part.family == family)


BUNDLED = Catalogue()


Plugins = str | Path | ModuleType | Catalogue | Iterable[str | Path | ModuleType | Part]
"""What brings kinds that are not bundled: files by their path, imported modules, or what was found before."""


def catalogue_with(plugins: Plugins = ()) -> Catalogue:
    """The catalogue with what is brought: files by their path, imported modules, or parts that were found before.

    Raises ``ScenarioError`` in one sentence for a file or a module that brings nothing usable.
    """
    if isinstance(plugins, Catalogue):
        return plugins
    given: Any = (plugins,) if isinstance(plugins, str | Path | ModuleType) else plugins
    brought: list[Part] = []
    settled: list[Part] = []
    if not isinstance(given, Iterable):
        raise ScenarioError(f"plugins: must be modules or paths of files, not {given!r}")
    for one in given:
        if isinstance(one, Part):
            settled.append(one)
        elif not isinstance(one, ModuleType | str | Path):
            raise ScenarioError(f"plugins: must be modules or paths of files, not {one!r}")
        else:
            brought += _of_module(one) if isinstance(one, ModuleType) else _of_file(Path(one))
    return Catalogue(_distinct(brought)).also(settled)


def _distinct(parts: Iterable[Part]) -> tuple[Part, ...]:
    """Each part once, whatever path it came by."""
    return tuple({(part.address, part.module, part.digest): part for part in parts}.values())


def digests(parts: Iterable[Part]) -> dict[str, str]:
    """Digest of each part by its address, as files of results hold it."""
    return {part.address: part.digest[:16] for part in sorted(parts)}


def is_outside(cls: type) -> bool:
    """Whether a class is not one of ours."""
    return cls.__module__.partition(".")[0] not in OURS


def load_parts(parts: Iterable[Part]) -> None:
    """Make the classes of parts known to this process, before values of theirs arrive in it."""
    for part in parts:
        class_of(part)


def carried(
    parts: tuple[Part, ...], function: Callable[..., Any], *arguments: Any
) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """(function, arguments) of the same call, in which another process meets the parts before values of theirs."""
    return (_called, (parts, pickle.dumps((function, arguments)))) if parts else (function, arguments)


def _called(parts: tuple[Part, ...], call: bytes) -> Any:
    load_parts(parts)
    function, arguments = pickle.loads(call)
    return function(*arguments)


# ---- from a part to its class


def class_of(part: Part) -> type[Any]:
    """The class of a part, in whatever process.

    Raises ``OutputError`` where its package is not installed here, or is another one.
    """
    module = sys.modules.get(part.module)
    if module is None and part.text is not None:
        module = _executed(part.module, part.text, part.origin, part.digest)
    elif module is None:
        try:
            module = importlib.import_module(part.module)
        except ImportError:
            raise OutputError(f"{part.address} of {part.origin} is not installed here") from None
    if _digest(module, part.origin) != part.digest:
        raise OutputError(f"{part.address} of {part.origin} is another one here")
    if not part.attribute:
        found: Any = getattr(module, TABLE)[part.family][part.kind]
    else:
        found = functools.reduce(getattr, part.attribute.split("."), module)
    if not isinstance(found, type):
        raise ScenarioError(f"kind '{part.kind}' of {part.origin} is no class")
    return found


@cached
def lack(cls: type[Any], family: str) -> str | None:
    """What a class has not that every class of its family has."""
    own = {field.name for field in dataclasses.fields(cls)} | catalogue.own_members(cls)
    missing = [] if is_recorded(cls) else [name for name in members(family) if name not in own]
    if not missing:
        return None
    return f"has no {' and no '.join(repr(name) for name in missing)}; 'shortfinal contract' says what it needs"


@cached
def fault(cls: type[Any], family: str) -> str | None:
    """What keeps a class from being read from tables and from travelling, whatever it does; None = nothing."""
    if not dataclasses.is_dataclass(cls) or not cls.__dataclass_params__.frozen:  # type: ignore[attr-defined]
        return "is no frozen dataclass; write @dataclass(frozen=True) above its class"
    try:
        named = [one.name for one in parameters(cls) if one.name in TAKEN.get(family, ("kind",))]
        model_of(cls)
    except ValueError as error:  # a unit that is none
        return f"has parameters that cannot be read: {printable(str(error))}"
    except Exception as error:  # whatever a foreign annotation does
        return f"has parameters that cannot be read: {said(error)}"
    if named:
        return f"has a parameter '{named[0]}', and its table has that key already"
    try:
        pickle.dumps(cls)
    except Exception:
        return f"cannot be found again as {cls.__module__}.{cls.__qualname__}; define it at the top of its file"
    return None


def members(family: str) -> tuple[str, ...]:
    """Names that every class of a family has."""
    found: tuple[str, ...] = importlib.import_module(catalogue.CONTRACTS[family]).MEMBERS
    return found


# ---- files and modules that bring parts


def _of_file(path: Path) -> list[Part]:
    text = _text(path)
    digest = hashlib.sha256(text.encode()).hexdigest()
    name = f"shortfinal_plugin_{digest[:32]}"
    origin = printable(str(path))
    module = sys.modules.get(name) or _executed(name, text, origin, digest)
    return _table(module, origin, digest, text)


def _of_module(module: ModuleType) -> list[Part]:
    if module.__name__ == "__main__":
        raise ScenarioError("plugins: a script cannot be its own plug-in; write the parts in a file of their own")
    origin = f"module {module.__name__}"
    digest = _digest(module, origin)
    alone = "." not in module.__name__ and not hasattr(module, "__path__")
    return _table(module, origin, digest, _text(Path(str(module.__file__))) if alone else None)


def _text(path: Path) -> str:
    """The source in a file."""
    name = printable(str(path))
    try:
        if not path.is_file():
            absent = "is a folder; name a file in it" if path.is_dir() else "no such file"
            raise ScenarioError(f"{name}: {'no regular file' if path.exists() and not path.is_dir() else absent}")
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise ScenarioError(f"{name}: cannot be read: {error.strerror}") from None
    if len(content) > LARGEST_FILE:
        raise ScenarioError(f"{name}: larger than {LARGEST_FILE} bytes, which no file of parts is")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ScenarioError(f"{name}: not UTF-8 text; save the file as UTF-8") from None


def _executed(name: str, text: str, origin: str, digest: str) -> ModuleType:
    """A module of this source, known by its name from now on."""
    module = ModuleType(name)
    module.__file__ = origin
    sys.modules[name] = module  # while it runs, too: a dataclass looks its annotations up there
    try:
        with contextlib.redirect_stdout(sys.stderr):  # what it prints is no output of the command
            exec(compile(text, origin, "exec", dont_inherit=True), module.__dict__)
    except BaseException as error:
        del sys.modules[name]
        if isinstance(error, KeyboardInterrupt):
            raise
        raise ScenarioError(f"{origin}: cannot be imported: {said(error)}{_line(error, origin)}") from None
    _digests[name] = digest
    return module


def _table(module: ModuleType, origin: str, digest: str, text: str | None) -> list[Part]:
    """What the table of a module brings."""
    table = getattr(module, TABLE, None)
    if table is None:
        raise ScenarioError(f"{origin}: does not say what it brings; write {FORM}")
    if not isinstance(table, dict) or not table or not all(isinstance(kinds, dict) for kinds in table.values()):
        raise ScenarioError(f"{origin}: {TABLE} must be a table of tables; write {FORM}")
    found = []
    for family, kinds in table.items():
        if family not in FAMILIES:
            raise ScenarioError(f"{origin}: {TABLE}: no family {family!r}; {did_you_mean(str(family), FAMILIES)}")
        for kind, cls in kinds.items():
            place = f"{origin}: {TABLE} {family}: {kind!r}"
            if not isinstance(kind, str) or not KIND.fullmatch(kind):
                raise ScenarioError(f"{place} is no name of a kind: lower-case letters, digits and _, a letter first")
            if kind in catalogue.kinds(family):
                raise ScenarioError(f"{place} is a bundled kind; give yours another name")
            if not isinstance(cls, type):
                raise ScenarioError(f"{place} is no class")
            found.append(Part(family, kind, origin, module.__name__, "", digest, text))
    return found


# ---- installed packages


def _entries(family: str) -> list[importlib.metadata.EntryPoint]:
    """What installed packages bring; a kind that bears a bundled kind's name is none."""
    bundled, group = catalogue.kinds(family), f"shortfinal.{family}"
    found: list[importlib.metadata.EntryPoint] = []
    try:
        found += importlib.metadata.entry_points(group=group)
    except Exception:  # the metadata of some package cannot be read: all others still count
        for distribution in importlib.metadata.distributions():
            with contextlib.suppress(Exception):
                found += distribution.entry_points.select(group=group)
    return [entry for entry in found if entry.name not in bundled and KIND.fullmatch(entry.name)]


def installed_kinds(family: str) -> list[tuple[str, str]]:
    """(kind, where it is from) of all that installed packages bring, without importing any of it."""
    return [(entry.name, _origin(entry)) for entry in _entries(family)]


def _origin(entry: importlib.metadata.EntryPoint) -> str:
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist is not None else f"module {entry.module}"


def _installed(family: str, entry: importlib.metadata.EntryPoint) -> Part:
    origin = _origin(entry)
    if not KIND.fullmatch(entry.name):
        raise ScenarioError(f"kind '{entry.name}' of {origin} must have lower-case letters, digits and _")
    try:
        entry.load()
        if not entry.attr:
            raise ValueError("write its entry point as module:Class")
    except Exception as error:  # whatever a foreign package does when it is imported
        raise ScenarioError(f"kind '{entry.name}' of {origin} cannot be imported: {said(error)}") from None
    except SystemExit:
        raise ScenarioError(f"kind '{entry.name}' of {origin} cannot be imported: it ends the process") from None
    digest = _digest(sys.modules[entry.module], origin)
    return Part(family, entry.name, origin, entry.module, entry.attr, digest, None)


_digests: dict[str, str] = {}  # of modules by name, as they were when they were first used: a file may change later


def _digest(module: ModuleType, origin: str) -> str:
    """Of the code of a module."""
    name = module.__name__
    if name not in _digests:
        _digests[name] = _digest_of_code(name, origin)
    return _digests[name]


def _digest_of_code(name: str, origin: str) -> str:
    """Of a module that stands alone the digest of its file, else that of all files of its package."""
    for depth in range(1, name.count(".") + 2):
        module = sys.modules[".".join(name.split(".")[:depth])]
        file = Path(getattr(module, "__file__", None) or "")
        if file.is_file():
            break  # what is above it is a namespace, which others share
    else:
        raise ScenarioError(f"{origin}: has no source file; its digest cannot be taken")
    if not hasattr(module, "__path__"):
        return hashlib.sha256(_text(file).encode()).hexdigest()
    home, found = file.parent, hashlib.sha256()
    for path in sorted(home.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            content = path.read_bytes()
            found.update(f"{path.relative_to(home).as_posix()}\0{len(content)}\0".encode() + content)
    return found.hexdigest()


def said(error: BaseException) -> str:
    """A foreign error on one line."""
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    return printable(f"{type(error).__name__}: {' '.join(text.split())[:LONGEST_TEXT]}".rstrip(": "))


def _line(error: BaseException, file: str) -> str:
    """Where in a file an error arose."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == file]
    if isinstance(error, SyntaxError) and error.filename == file:
        lines.append(error.lineno)
    return f" (line {lines[-1]})" if lines else ""
