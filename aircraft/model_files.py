"""Safe copies of JSBSim models: a private root that holds one model and nothing that writes, listens or sends.

A JSBSim model may open sockets and overwrite any file as soon as it is initialised. What is copied here is parsed,
stripped of every input and output, confined to its own folder, bounded in size, and written out again.
"""

from __future__ import annotations

import difflib
import hashlib
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


def folder(model: str | Path) -> Path:
    """Folder of a model by name, or the user's own folder when ``model`` is a path.

    Raises ``ModelError`` with the nearest names when there is none.
    """
    text = str(model)
    if isinstance(model, Path) or "/" in text or "\\" in text:
        try:
            return _users_folder(Path(model))
        except ModelError:
            raise
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise ModelError(f"'{text[:LONGEST_REFERENCE]}' can be no folder: {reason}") from None
    for place in (OWN_MODELS / text, stock_root() / "aircraft" / text):
        if text and is_file(place / f"{place.name}.xml"):
            return place
    names = tuple(available())
    near = difflib.get_close_matches(text, names, n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(repr(name) for name in near)}?" if near else f"known are {', '.join(names)}"
    raise ModelError(f"there is no aircraft '{text}': {hint}")


def _users_folder(path: Path) -> Path:
    name = path.resolve().name
    if path.is_symlink():
        raise ModelError(f"'{path}' is a link: name the folder itself, '{path.resolve()}'")
    if not is_file(path / f"{name}.xml"):
        raise ModelError(f"no aircraft at '{path}': the folder must hold '{name}.xml'")
    for place in (OWN_MODELS / name, stock_root() / "aircraft" / name):
        if place.is_dir() and not path.samefile(place):
            raise ModelError(f"the aircraft at '{path}' hides the one that is called '{name}': give it another name")
    return path


def read(model: str | Path) -> Model:
    """Read and strip a model with everything that it refers to; raises ``ModelError``."""
    home = folder(model)
    name = home.resolve().name
    root = parse(home / f"{name}.xml", home)
    if root.tag != "fdm_config":
        raise ModelError(f"'{name}.xml' is not an aircraft for JSBSim: its root is <{root.tag}>, not <fdm_config>")
    _inline_sections(root, home)
    files: dict[PurePosixPath, ElementTree.Element] = {}
    pending = list(_references(root, name))
    size = 0
    while pending:
        place, reference = pending.pop()
        if place / reference in files:
            continue
        if len(files) == MOST_FILES:
            raise ModelError(f"'{name}' refers to more than {MOST_FILES} files")
        found = _find(reference, home)
        if found is None:
            raise ModelError(f"'{name}' refers to the file '{reference}', which does not exist")
        path, confines = found
        size += path.stat().st_size
        if size > LARGEST_MODEL:
            raise ModelError(f"the files of '{name}' are larger than {LARGEST_MODEL / 1e6:g} MB together")
        # two stock files define constants in a DOCTYPE
        files[place / reference] = parse(path, confines, doctype_allowed=confines == stock_root())
        pending += _references(files[place / reference], name)
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
            _write(model, Path(root))
        except OSError as error:
            raise ModelError(f"the copy of '{model.name}' cannot be written: {error.strerror}") from None
        yield Path(root)


def _write(model: Model, root: Path) -> None:
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
        yield PurePosixPath("engine" if element.tag in ("engine", "thruster") else f"aircraft/{name}"), plain


def _find(reference: str, home: Path) -> tuple[Path, Path] | None:
    """The file and the folder that confines it: the model's own before the stock ones."""
    stock = stock_root()
    for place, confines in (
        (home, home),
        (home / "Systems", home),
        (home / "Engines", home),
        (stock / "systems", stock),
        (stock / "engine", stock),
    ):
        path = place / f"{reference}.xml"
        if is_file(path):
            return path, confines
    return None
