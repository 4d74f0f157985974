"""What the pages tell the reader to type: commands parse, names are bundled, tables are scenarios."""

from __future__ import annotations

import ast
import re
import shlex
import tomllib
from pathlib import Path

import pytest
import typer

from sim.claims import PAPERS
from sim.cli.commands import app
from sim.scenario import catalogue
from sim.scenario.reading import read

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
PAGES = (
    README,
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs" / "tutorials").glob("*.md")),
    *(
        page
        for page in sorted((ROOT / "docs").glob("*.md"))
        if page.stem not in ("acceptance", "equations")  # made, and long
    ),
    *sorted((ROOT / "docs" / "uses").glob("*.md")),
)
TEXTS = {page.name: page.read_text(encoding="utf-8") for page in PAGES}
SAID_THERE = ("scenarios", "weather", "contrasts", "monitoring", "checks", "studies", "pytest", "python")
BLOCKS = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(language: str) -> list[str]:
    """Blocks in a language, of the README and the pages of what it speaks of in short."""
    pages = (README.name, *(f"{name}.md" for name in SAID_THERE))
    return [text for page in pages for named, text in BLOCKS.findall(TEXTS[page]) if named == language]


def commands() -> list[list[str]]:
    """Every command line of ours, in blocks and in running text, without prompt, comment and redirection."""
    found = set()
    for text in TEXTS.values():
        for _, block in BLOCKS.findall(text):
            found |= {line[2:] for line in block.splitlines() if line.startswith("$ shortfinal ")}
        found |= set(re.findall(r"`(shortfinal [^`\n]+)`", BLOCKS.sub("", text)))
    return [shlex.split(line.split(">")[0], comments=True)[1:] for line in sorted(found)]


@pytest.mark.parametrize("words", commands(), ids=" ".join)
def test_a_command_is_one(words):
    group = typer.main.get_command(app)
    command = group.commands[words[0]]
    if len(words) == 1:  # the text may speak of a verb without its arguments
        return
    context = command.make_context(words[0], words[1:])
    if words[0] in ("run", "study", "explain"):
        scenario = context.params["scenario"]
        assert catalogue.bundled(scenario) is not None or scenario.endswith(".toml")
    if words[0] == "claims":
        assert set(context.params["papers"] or []) <= set(PAPERS)


def test_bundled_names_are_bundled():
    """A name in a page that begins like one of ours is one."""
    bundled = {*catalogue.scenarios(), *catalogue.studies()}
    named = set(re.findall(rf"`((?:an26|{'|'.join(PAPERS)})_\w+)`", "\n".join(TEXTS.values())))
    assert named
    assert named - bundled == set()


@pytest.mark.parametrize("table", blocks("toml"), ids=lambda text: text.strip().split("\n")[0])
def test_a_table_is_of_a_scenario(table):
    """A block without a name is part of a scenario; it is put into the default one."""
    tables = tomllib.loads(table)
    if "name" not in tables:
        tables = tomllib.loads(catalogue.bundled("an26_pattern").read_text()) | tables
    assert read(tables).name in ("mine", "an26_pattern")


@pytest.mark.parametrize("code", blocks("python"), ids=lambda text: text.strip().split("\n")[0])
def test_code_is_code(code):
    assert ast.parse(code).body


def test_make_knows_its_targets():
    named = set(re.findall(r"(?:^|`)make (\w+)", "\n".join(TEXTS.values()), re.MULTILINE))
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert {"demo", "test", "tutorials"} <= named
    assert named - targets == set()
