"""Safe copies of JSBSim models: a private root that holds one model and nothing that writes, listens or sends.

A JSBSim model may open sockets and overwrite any file as soon as it is initialised. What is copied here is parsed,
stripped of every input and output, confined to its own folder, bounded in size, and written out again.
"""

from __future__ import annotations

import difflib
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath, PureWindowsPath
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import NamedTuple

from aircraft.errors import ModelError

OWN_MODELS = Path(__file__).parent / "models"
SECTIONS = ("metrics", "mass_balance", "ground_reactions", "propulsion", "flight_control", "aerodynamics")
LARGEST_FILE = 4_000_000  # bytes; the largest stock file has 0.3 MB
MOST_FILES = 100
REFUSED_PROPERTIES = (  # they write files, or stop time
    "simulation/write-state-file",
    "simulation/force-output",
    "simulation/pause",
    "simulation/reset",
    "simulation/do_",
)


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
        path = Path(model)
        if not (path / f"{path.resolve().name}.xml").is_file():
            raise ModelError(f"no aircraft at '{path}': the folder must hold '{path.resolve().name}.xml'")
        return path
    for place in (OWN_MODELS / text, stock_root() / "aircraft" / text):
        if text and (place / f"{place.name}.xml").is_file():
            return place
    names = tuple(available())
    near = difflib.get_close_matches(text, names, n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(repr(name) for name in near)}?" if near else f"known are {', '.join(names)}"
    raise ModelError(f"there is no aircraft '{text}': {hint}")


def read(model: str | Path) -> Model:
    """Read and strip a model with everything that it refers to; raises ``ModelError``."""
    home = folder(model)
    name = home.resolve().name
    root = _parse(home / f"{name}.xml", home)
    if root.tag != "fdm_config":
        raise ModelError(f"'{name}.xml' is not an aircraft for JSBSim: its root is <{root.tag}>, not <fdm_config>")
    _inline_sections(root, home)
    files: dict[PurePosixPath, ElementTree.Element] = {}
    pending = list(_references(root, name))
    while pending:
        place, reference = pending.pop()
        if place / reference in files:
            continue
        if len(files) == MOST_FILES:
            raise ModelError(f"'{name}' refers to more than {MOST_FILES} files")
        found = _find(reference, home)
        if found is None:
            raise ModelError(f"'{name}' refers to the file '{reference}', which does not exist")
        files[place / reference] = _parse(*found)
        pending += _references(files[place / reference], name)
    return Model(name, root, files)


@contextmanager
def private_root(model: Model) -> Iterator[Path]:
    """Write the model into a temporary JSBSim root that is gone afterwards."""
    with TemporaryDirectory(prefix="shortfinal-") as place:
        root = Path(place)
        home = root / "aircraft" / model.name
        for directory in (home, root / "engine", root / "systems"):
            directory.mkdir(parents=True)
        ElementTree.ElementTree(model.root).write(home / f"{model.name}.xml", encoding="utf-8", xml_declaration=True)
        for reference, tree in model.files.items():
            path = root / f"{reference}.xml"
            path.parent.mkdir(parents=True, exist_ok=True)
            ElementTree.ElementTree(tree).write(path, encoding="utf-8", xml_declaration=True)
        yield root


def _parse(path: Path, home: Path) -> ElementTree.Element:
    if path.is_symlink() or not path.resolve().is_relative_to(home.resolve()):
        raise ModelError(f"'{path.name}' is a link out of its folder, which a model may not hold")
    if path.stat().st_size > LARGEST_FILE:
        raise ModelError(f"'{path.name}' is larger than {LARGEST_FILE / 1e6:g} MB")
    tree = ElementTree.TreeBuilder()
    doctype = _ignore_doctype if home == stock_root() else _refuse_doctype  # two stock files define constants in one
    target = SimpleNamespace(start=tree.start, end=tree.end, data=tree.data, close=tree.close, doctype=doctype)
    parser = ElementTree.XMLParser(target=target)
    try:
        root = ElementTree.fromstring(path.read_bytes(), parser)
    except ModelError:
        raise
    except ElementTree.ParseError as error:
        raise ModelError(f"'{path.name}' is not well-formed XML: {error}") from None
    except (LookupError, ValueError) as error:
        raise ModelError(f"'{path.name}' cannot be read: {error}") from None
    _strip(root)
    for element in root.iter():
        for text in (element.text or "", *element.attrib.values()):
            if any(name in text for name in REFUSED_PROPERTIES):
                raise ModelError(f"'{path.name}' uses a property that steers the simulator: '{text.strip()}'")
    return root


def _refuse_doctype(*_: object) -> None:
    raise ModelError("a model may not have a DOCTYPE, which can name other files")


def _ignore_doctype(*_: object) -> None:
    """Entities of the stock files are internal; external ones stay unresolved in any case."""


def _strip(root: ElementTree.Element) -> None:
    """Drop what opens files or sockets. Inside control systems <input> and <output> name a property, nothing more."""
    for parent in list(root.iter()):
        for child in list(parent):
            is_device = parent is root or len(child) > 0 or bool(child.attrib)
            if child.tag in ("input", "output") and is_device:
                parent.remove(child)


def _inline_sections(root: ElementTree.Element, home: Path) -> None:
    """Put sections that stand in files of their own where the model names them."""
    for number, section in enumerate(root):
        if section.tag not in SECTIONS or "file" not in section.attrib:
            continue
        path = home / f"{_confined(section)}.xml"
        if not path.is_file():
            raise ModelError(f"'{home.name}' refers to the file '{path.name}', which does not exist")
        root[number] = _parse(path, home)


def _confined(element: ElementTree.Element) -> str:
    """The file that an element refers to, without suffix; raises ``ModelError`` when it is not below the model."""
    reference = element.get("file", "")
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
        if path.is_file():
            return path, confines
    return None
