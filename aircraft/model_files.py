"""Safe copies of JSBSim models: a private root that holds one model and nothing that writes, listens or sends.

A JSBSim model may open sockets and overwrite any file as soon as it is initialised. What is copied here is parsed,
stripped of every input and output, confined to its own folder, bounded in size, and written out again.
"""

from __future__ import annotations

import difflib
import hashlib
import io
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath, PureWindowsPath
from tempfile import TemporaryDirectory
from typing import NamedTuple

from aircraft.errors import ModelError
from aircraft.safe_xml import parse

OWN_MODELS = Path(__file__).parent / "models"
SECTIONS = ("metrics", "mass_balance", "ground_reactions", "propulsion", "flight_control", "aerodynamics")
MOST_FILES = 100
LARGEST_MODEL = 8_000_000  # bytes of all files that a model refers to; the largest stock model has 0.3 MB
LONGEST_REFERENCE = 200  # characters
MOST_CANDIDATES = 5  # that are named
HEAD = 65536  # bytes of a file, in which its first element stands
ENGINES, SYSTEMS = ("engine", "engines", "Engine", "Engines"), ("systems", "Systems")  # folders inside a model's own
ROOT_OF_AIRCRAFT = "aircraft"  # ROOT/aircraft/NAME has its engines in ROOT/engine or ROOT/engines
ENGINE = PurePosixPath("engine")  # of the private root
BESIDE = {ENGINES: ("engine", "engines"), SYSTEMS: ("systems",)}  # folders of a root, beside its aircraft


class Model(NamedTuple):
    """A model's XML, stripped, with every file that it refers to."""

    name: str
    root: ElementTree.Element
    files: dict[PurePosixPath, ElementTree.Element]  # by path below the private root, without suffix


def stock_root() -> Path:
    """Folder of the models that come with JSBSim."""
    import jsbsim

    return Path(jsbsim.get_default_root_dir())


def available() -> dict[str, str]:
    """Names that ``read`` understands, own models first, and where each is from."""
    own = sorted(path.parent.name for path in OWN_MODELS.glob("*/*.xml") if path.stem == path.parent.name)
    stock = sorted(path.name for path in (stock_root() / "aircraft").iterdir() if (path / f"{path.name}.xml").is_file())
    return dict.fromkeys(own, "own model") | {name: "stock aircraft of JSBSim" for name in stock if name not in own}


def main_file(model: str | Path) -> Path:
    """The main file of a model by name, or by the path of the user's own folder or of the file itself.

    A path is one that has a slash. Raises ``ModelError`` with the nearest names, or with the aircraft that a folder
    holds, when there is none.
    """
    text = str(model)
    if isinstance(model, Path) or "/" in text or "\\" in text:
        try:
            return _users_file(Path(model))
        except ModelError:
            raise
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise ModelError(f"'{text[:LONGEST_REFERENCE]}' can be no folder: {reason}") from None
    for place in (OWN_MODELS / text, stock_root() / "aircraft" / text):
        if text and is_file(place / f"{place.name}.xml"):
            return place / f"{place.name}.xml"
    names = tuple(available())
    near = difflib.get_close_matches(text, names, n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(repr(name) for name in near)}?" if near else f"known are {', '.join(names)}"
    raise ModelError(f"there is no aircraft '{text}': {hint}")


def folder(model: str | Path) -> Path:
    """The folder of a model; raises ``ModelError`` when there is none."""
    return main_file(model).parent


def candidates(home: Path) -> list[Path]:
    """Files of a folder that are aircraft by their first element, in the order of their names."""
    return [path for path in sorted(home.glob("*.xml")) if not path.is_symlink() and _is_aircraft(path)]


def _users_file(path: Path) -> Path:
    file = path if path.suffix == ".xml" and not path.is_dir() else path / f"{path.resolve().name}.xml"
    home = file.parent
    if home.is_symlink():
        raise ModelError(f"'{home}' is a link: name the folder itself, '{home.resolve()}'")
    if is_file(file):
        return file
    found = [f"'{_as_path(one)}'" for one in candidates(home)]
    if not found:
        raise ModelError(f"no aircraft at '{path}': the folder must hold '{file.name}'")
    more = f" and {len(found) - MOST_CANDIDATES} more" if len(found) > MOST_CANDIDATES else ""
    raise ModelError(
        f"no aircraft at '{path}': there is no '{file.name}', but {', '.join(found[:MOST_CANDIDATES])}{more}: name one"
    )


def _as_path(path: Path) -> str:
    """As a scenario names it: with a slash."""
    return str(path) if len(path.parts) > 1 else f"./{path}"


def _is_aircraft(path: Path) -> bool:
    if not is_file(path):
        return False
    try:
        with path.open("rb") as file:
            head = io.BytesIO(file.read(HEAD))
        return bool(next(ElementTree.iterparse(head, ("start",)))[1].tag == "fdm_config")
    except (OSError, ElementTree.ParseError, LookupError, ValueError, StopIteration):
        return False


def read(model: str | Path) -> Model:
    """Read and strip a model with everything that it refers to; raises ``ModelError``."""
    file = main_file(model)
    home, name = file.parent, file.stem
    root = parse(file, home)
    if root.tag != "fdm_config":
        raise ModelError(f"'{name}.xml' is not an aircraft for JSBSim: its root is <{root.tag}>, not <fdm_config>")
    _inline_sections(root, home)
    files: dict[PurePosixPath, ElementTree.Element] = {}
    missing: dict[str, tuple[str, ...]] = {}
    pending = list(_references(root, name))
    size = 0
    while pending:
        place, reference = pending.pop()
        if place / reference in files:
            continue
        if len(files) == MOST_FILES:
            raise ModelError(f"'{name}' refers to more than {MOST_FILES} files")
        kind = ENGINES if place == ENGINE else SYSTEMS
        found = _find(reference, home, kind)
        if found is None:
            missing[reference] = kind
            continue
        path, confines = found
        size += path.stat().st_size
        if size > LARGEST_MODEL:
            raise ModelError(f"the files of '{name}' are larger than {LARGEST_MODEL / 1e6:g} MB together")
        # two stock files define constants in a DOCTYPE
        files[place / reference] = parse(path, confines, doctype_allowed=confines == stock_root())
        pending += _references(files[place / reference], name)
    if missing:
        raise ModelError(_missing(name, missing, home))
    return Model(name, root, files)


def digest(model: Model) -> str:
    """Of all that is written for JSBSim: the model's own XML and every file that it refers to."""
    found = hashlib.sha256()
    for path, tree in [(PurePosixPath(), model.root), *sorted(model.files.items(), key=lambda item: str(item[0]))]:
        found.update(str(path).encode() + ElementTree.tostring(tree))
    return found.hexdigest()


@contextmanager
def private_root(model: Model) -> Iterator[Path]:
    """Write the model into a temporary JSBSim root that is gone afterwards."""
    try:
        place = TemporaryDirectory(prefix="shortfinal-")
    except OSError as error:
        raise ModelError(f"there is no place for a copy of '{model.name}': {error.strerror}") from None
    with place as root:
        try:
            write_root(model, Path(root))
        except OSError as error:
            raise ModelError(f"the copy of '{model.name}' cannot be written: {error.strerror}") from None
        yield Path(root)


def write_root(model: Model, root: Path) -> None:
    """Write the model as a JSBSim root; raises ``OSError``."""
    home = root / "aircraft" / model.name
    for directory in (home, root / "engine", root / "systems"):
        directory.mkdir(parents=True)
    for reference, tree in {PurePosixPath("aircraft", model.name, model.name): model.root, **model.files}.items():
        path = root / f"{reference}.xml"
        path.parent.mkdir(parents=True, exist_ok=True)
        ElementTree.ElementTree(tree).write(path, encoding="utf-8", xml_declaration=True)


def is_file(path: Path) -> bool:
    """Whether a path is a regular file that can be looked at; a name that no file can have is none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _inline_sections(root: ElementTree.Element, home: Path) -> None:
    """Put sections that stand in files of their own where the model names them."""
    for number, section in enumerate(root):
        if section.tag not in SECTIONS or "file" not in section.attrib:
            continue
        path = home / f"{_confined(section)}.xml"
        if not is_file(path):
            raise ModelError(f"'{home.name}' refers to the file '{path.name}', which does not exist")
        root[number] = parse(path, home)


def _confined(element: ElementTree.Element) -> str:
    """The file that an element refers to, without suffix; raises ``ModelError`` when it is not below the model."""
    reference = element.get("file", "")
    if not 0 < len(reference) <= LONGEST_REFERENCE:
        raise ModelError(f"the file of a <{element.tag}> must have 1 to {LONGEST_REFERENCE} characters")
    parts = PureWindowsPath(reference)
    if parts.is_absolute() or parts.drive or reference.startswith(("/", "\\", "~")) or ".." in parts.parts:
        raise ModelError(f'file="{reference}" leaves the folder of the model')
    return str(PurePosixPath(reference.replace("\\", "/"))).removesuffix(".xml")


def _references(root: ElementTree.Element, name: str) -> Iterator[tuple[PurePosixPath, str]]:
    """Folder below the private root, and name, of every file that is referred to."""
    for element in root.iter():
        if element.get("file") is None:
            continue
        plain = _confined(element)
        element.set("file", plain)
        if plain == name:
            raise ModelError(f"'{name}.xml' refers to itself")
        yield ENGINE if element.tag in ("engine", "thruster") else PurePosixPath(f"aircraft/{name}"), plain


def _find(reference: str, home: Path, kind: tuple[str, ...]) -> tuple[Path, Path] | None:
    """The file and the folder that confines it: the model's own before those of its root before the stock ones."""
    for place in (home, *(home / name for name in kind)):
        path = place / f"{reference}.xml"
        if is_file(path):
            return path, home
    root = _root(home)
    for place in (root / name for name in BESIDE[kind]) if root is not None else ():
        path = place / f"{reference}.xml"
        if is_file(path):
            if path.resolve() != path:
                raise ModelError(f"'{place.name}/{path.name}' beside the aircraft is a link, which a model may not use")
            return path, root or home
    stock = stock_root()
    for place in (stock / "systems", stock / "engine"):
        path = place / f"{reference}.xml"
        if is_file(path):
            return path, stock
    return None


def _root(home: Path) -> Path | None:
    """The root that a model lies in, where it is ROOT/aircraft/NAME; None elsewhere."""
    parent = home.resolve().parent
    is_one = parent.name == ROOT_OF_AIRCRAFT and parent.parent != stock_root().resolve()
    return parent.parent if is_one else None


def _missing(name: str, missing: dict[str, tuple[str, ...]], home: Path) -> str:
    """What a model refers to that is nowhere, and where was looked."""
    files = ", ".join(f"'{reference}.xml'" for reference in missing)
    kinds = [kind for kind in (ENGINES, SYSTEMS) if kind in missing.values()]
    inside = ", ".join(place for kind in kinds for place in kind)
    beside = " and ".join(f"'{place}'" for kind in kinds for place in BESIDE[kind])
    root = _root(home)
    other = f"not beside it, as '{home.resolve().parent.name}' is not called '{ROOT_OF_AIRCRAFT}'"
    there = f"in {beside} of its root" if root is not None else other
    exist = "the file {}, which does not exist" if len(missing) == 1 else "the files {}, which do not exist"
    looked = f"looked in its folder, there in {inside}, {there}, and among those of JSBSim"
    return f"'{name}' refers to {exist.format(files)}: {looked}"
