"""The site of the documents: what its pages are made of; built, where its builder is installed."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

import sim
from tests.docs import uses
from tests.docs.site import docstrings_text, gallery, notebooks, scenario_reference, sources

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
EXTRA = re.compile(r"shortfinal\[(\w+)\]")
SCHEMA = {
    "properties": {"radar": {"$ref": "#/$defs/Radar"}, "seed": {"type": "integer", "minimum": 0, "default": 1}},
    "$defs": {
        "Radar": {
            "properties": {
                "height_m": {
                    "type": "number",
                    "minimum": 5,
                    "maximum": 90,
                    "description": "default 7",
                    "x-note": "low",
                },
                "height_ft": {"type": "number"},
            },
            "required": ["height_m"],
        }
    },
}


def test_every_public_name_has_its_place_in_the_reference():
    shown = re.findall(r"^::: sim\.(\w+)$", (DOCS / "python.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(shown) == sorted(sim.__all__)


def test_every_page_is_reached_from_the_navigation():
    named = set(re.findall(r": ([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE))
    there = {file.relative_to(DOCS).as_posix() for file in DOCS.rglob("*.md")}
    assert there - named == set()
    assert named - there == {"index.md", "contributing.md", "changelog.md", "scenario-reference.md"}


def test_the_gallery_shows_every_bundled_scenario_and_study():
    assert gallery.PAGE.read_text(encoding="utf-8") == gallery.page(), "run `make gallery`"
    shown = {name for names in gallery.GROUPS.values() for name in names}
    assert shown == set(gallery.catalogue.scenarios())
    assert {file.stem for file in gallery.PICTURES.iterdir()} == shown


def test_the_scenario_reference_has_spellings_defaults_limits_and_whatever_else_a_schema_says():
    page = scenario_reference.reference(SCHEMA)
    assert (
        "| `height_m`<br><small>`height_ft`</small> | number; required; note: low | `7` | at least 5, at most 90 |"
        in page
    )
    assert "| `seed` | whole number | `1` | at least 0 |" in page


def test_the_scenario_reference_has_every_kind():
    page = scenario_reference.reference()
    for family in ("sensors", "trackers", "modes", "wind_events"):
        assert [kind for kind in gallery.catalogue.kinds(family) if f" `{kind}`\n" not in page] == []


def test_a_link_to_code_leads_to_the_line_of_its_name():
    page = sources.relinked("[`sim/errors.py:ScenarioError`](../../sim/errors.py)", ROOT)
    line = int(re.search(r"\(\.\./source/sim/errors\.md#__codelineno-0-(\d+)\)", page)[1])
    assert (ROOT / "sim" / "errors.py").read_text(encoding="utf-8").splitlines()[line - 1].startswith("class ScenarioE")


def test_words_about_a_parameter_are_no_type():
    text = "Adds.\n\nParameters\n----------\na : the first\n\nRaises ``ValueError``.\n"
    assert docstrings_text.with_words(text) == (
        "Adds.\n\nRaises ``ValueError``.\n\n\nParameters\n----------\na\n    the first\n\n"
    )


def test_a_message_names_an_extra_that_brings_what_is_missing():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    brings = {"pandas": "pandas", "parquet": "pyarrow", "cluster": "distributed"}
    named = [
        (file, extra)
        for file in (ROOT / "sim").rglob("*.py")
        for extra in EXTRA.findall(file.read_text(encoding="utf-8"))
    ]
    assert {extra for _, extra in named} == set(brings)
    for file, extra in named:
        assert any(line.startswith(brings[extra]) for line in extras[extra])
        assert brings[extra] in file.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", sorted(notebooks.every()))
def test_a_notebook_has_the_code_and_the_figures_of_its_page(name):
    page = notebooks.TUTORIALS / name.replace(".ipynb", ".md")
    made, text = notebooks.notebook(page), page.read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    code = ["".join(cell["source"]) for cell in made["cells"] if cell["cell_type"] == "code"]
    assert code == [block.strip("\n") for block in blocks]
    attached = {name for cell in made["cells"] for name in cell.get("attachments", {})}
    assert attached == {Path(found).name for found in re.findall(r"\]\(([^)]+\.svg)\)", text)}


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=() if page.stem == "pytest-checks" else pytest.mark.soak) for page in uses.USES],
    ids=lambda page: page.stem,
)
def test_a_page_of_uses_does_what_it_shows(page, tmp_path):
    made = uses.run(page, tmp_path)
    kept = uses.shown(page)
    assert made.transcripts.keys() == kept.keys()
    for name, text in made.transcripts.items():
        assert uses.lasting(text) == uses.lasting(kept[name]), "run `make uses` and look at what changed"
