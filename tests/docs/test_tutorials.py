"""The tutorials do what they show: every block runs, prints what stands below it and draws the figures of the page."""

from __future__ import annotations

import importlib.util
import pkgutil
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
RENEW = "run `make tutorials` and look at what changed"
SVG = "{http://www.w3.org/2000/svg}"
SAMPLE = "vasylyev2003"  # is run by every `make test`, the others by `make soak`
HALF_A_POINT = 0.5  # pt: less than the width of a line


def load(path: Path) -> ModuleType:
    """A module beside the tests: they are no package."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


tutorials = load(ROOT / "tests" / "docs" / "tutorials.py")
PAGES = sorted(tutorials.PAGES.glob("*.md"))
USES = sorted((ROOT / "docs" / "uses").glob("*.md"))
PROSE = [*PAGES, *USES, *sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]


def words_of(figure: Path) -> list[str]:
    """Everything that is written in an SVG figure."""
    return ["".join(text.itertext()).strip() for text in ElementTree.parse(figure).iter(f"{SVG}text")]


def maker(figure: Path) -> str:
    """The library that drew an SVG figure, with its version."""
    found = re.search("Matplotlib v[^,<]+", figure.read_text(encoding="utf-8"))
    return found[0] if found else ""


def curves_of(figure: Path) -> list[list[float]]:
    """The numbers of every path of an SVG figure."""
    paths = (path.get("d", "") for path in ElementTree.parse(figure).iter(f"{SVG}path"))
    return [[float(number) for number in re.findall(r"-?\d+(?:\.\d+)?", path)] for path in paths]


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=() if page.stem == SAMPLE else pytest.mark.soak, id=page.stem) for page in PAGES],
)
def test_a_tutorial_does_what_it_shows(page, tmp_path):
    outputs = tutorials.run(page, tmp_path)
    shown = [block.shown for block in tutorials.blocks(page)]
    assert outputs == shown, RENEW
    made = {file.name for file in tmp_path.iterdir()}
    assert made == tutorials.figures(page), "the figures that the page makes are those that it shows"
    for name in made:
        fresh, kept = tmp_path / name, tutorials.FIGURES / name
        assert kept.is_file(), RENEW
        assert words_of(fresh) == words_of(kept), RENEW
        if maker(fresh) == maker(kept):  # another version of the library may place everything elsewhere
            for one, other in zip(curves_of(fresh), curves_of(kept), strict=True):
                assert one == pytest.approx(other, abs=HALF_A_POINT), RENEW


def test_every_paper_has_a_tutorial_that_the_readme_names():
    listed = tomllib.loads((ROOT / "tests" / "papers.toml").read_text(encoding="utf-8"))
    assert {page.stem for page in PAGES} == {paper for paper, entry in listed.items() if entry["equations"]}
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert [page.stem for page in PAGES if f"](docs/tutorials/{page.name})" not in readme] == []


def test_no_figure_is_left_over():
    shown = set().union(*(tutorials.figures(page) for page in PAGES))
    assert {file.name for file in tutorials.FIGURES.iterdir()} == shown


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_axes_say_what_they_show_and_in_which_unit(page):
    for block in tutorials.blocks(page):
        labels = dict(re.findall(r'\b(xlabel|ylabel)="([^"]+)"', block.code))
        if "savefig" in block.code:
            assert set(labels) == {"xlabel", "ylabel"}
        assert [label for label in labels.values() if ", " not in label and "probability" not in label] == []


@pytest.mark.parametrize("page", PROSE, ids=lambda page: page.stem)
def test_links_lead_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8"))
    assert [link for link in links if "://" not in link and not (page.parent / link).exists()] == []


@pytest.mark.parametrize("page", PROSE, ids=lambda page: page.stem)
def test_named_files_and_modules_exist(page):
    """Also functions of a module; a part of a path in capitals stands for a name of the reader's own."""
    text = page.read_text(encoding="utf-8")
    files = re.findall(r"`((?:aircraft|autopilot|tracking|sim|tests)/[\w/.]+)`", text)
    own = {file for file in files if any(part.isupper() for part in file.split("/"))}
    assert [file for file in files if file not in own and not (ROOT / file).exists()] == []
    for name in re.findall(r"`((?:autopilot|tracking|sim)(?:\.[a-z_0-9]+)+)`", text):
        pkgutil.resolve_name(name)  # raises where there is none


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_code_is_in_the_style_of_the_project(page, tmp_path):
    """Blocks are checked as one file; what a page imports further down is no offence."""
    file = tmp_path / f"{page.stem}.py"
    file.write_text("\n\n".join(block.code.strip() for block in tutorials.blocks(page)) + "\n", encoding="utf-8")
    ruff = [sys.executable, "-m", "ruff", "--config", str(ROOT / "pyproject.toml")]
    checked = subprocess.run([*ruff, "check", "--ignore", "E402,I001", str(file)], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout
    place = tmp_path / "blocks"
    place.mkdir()
    for number, block in enumerate(tutorials.blocks(page)):
        (place / f"block_{number}.py").write_text(block.code.lstrip(), encoding="utf-8")
    formatted = subprocess.run([*ruff, "format", "--diff", str(place)], capture_output=True, text=True)
    assert formatted.returncode == 0, formatted.stdout


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("```python\nprint(1 / 0)\n```\n", 'page.md", line 2'),
        ("words\n\n```python\nimport warnings\nwarnings.warn('x')\n```\n", 'page.md", line 5'),
    ],
    ids=["error", "warning"],
)
def test_what_does_not_run_is_told_with_its_line(text, complaint, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(text, encoding="utf-8")
    with pytest.raises(RuntimeError) as told:
        tutorials.run(page, tmp_path)
    assert complaint in str(told.value)


def test_a_page_is_brought_up_to_date(tmp_path):
    page = tmp_path / "page.md"
    text = "a\n\n```python\nprint(2)\n```\n\n```text\n1\n```\n\nb\n\n```python\nx = 1\n```\n"
    page.write_text(text, encoding="utf-8")
    outputs = tutorials.run(page, tmp_path)
    assert outputs == ["2\n", ""]
    assert tutorials.rewritten(page, outputs) == text.replace("\n1\n", "\n2\n")
