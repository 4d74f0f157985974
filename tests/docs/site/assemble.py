"""The pages of the documents' site, from what lies in the repository: ``make docs`` builds it.

``python -m tests.docs.site.assemble`` writes them into build/docs, where mkdocs.yml looks for them: README.md as the
first page, docs as they are, CONTRIBUTING.md and CHANGELOG.md, the reference of scenario files from their schema, that
of the commands from the program, the tutorials as notebooks, and each file of code that a page links to.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from tests.docs.site import command_reference, mathml, notebooks, scenario_reference, sources

ROOT = Path(__file__).resolve().parents[3]
PAGES = ROOT / "build" / "docs"
OUTSIDE = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
SCENARIO_REFERENCE = "scenario-reference.md"
COMMANDS = "commands.md"
MADE = (*OUTSIDE.values(), SCENARIO_REFERENCE)  # pages that lie nowhere in docs
KEPT = (".svg", ".png", ".csv", ".toml", ".css", ".js")  # files of docs beside its pages


def from_root(page: str) -> str:
    """Links of a page of the root, as a page of the site has them."""
    page = re.sub(r"\]\(docs/", "](", page)
    return re.sub(r"\]\((README|CONTRIBUTING|CHANGELOG)\.md", lambda found: f"]({OUTSIDE[found[1] + '.md']}", page)


def from_docs(page: str) -> str:
    """Links of a page of docs to the pages of the root, which lie beside it on the site."""
    outside = "|".join(re.escape(name) for name in OUTSIDE)
    return re.sub(rf"\]\((?P<up>(?:\.\./)*)\.\./(?P<name>{outside})", _beside, page)


def _beside(found: re.Match[str]) -> str:
    return f"]({found['up']}{OUTSIDE[found['name']]}"


def without_files(page: str) -> str:
    """The page with the names of files that are no part of the site as plain words."""
    return re.sub(r"\[([^\]]+)\]\((?:\.\./)*(?:CITATION\.cff|LICENSE|NOTICE)\)", r"\1", page)


def with_language(page: str) -> str:
    """The page with what a terminal shows marked as text, whose long lines the site folds."""
    inside, lines = False, []
    for line in page.split("\n"):
        lines.append("```text" if line == "```" and not inside else line)
        inside ^= line.startswith("```")
    return "\n".join(lines)


def finished(page: str) -> str:
    """A page with everything in it that only the site has."""
    return mathml.with_formulas(with_language(sources.relinked(without_files(page), ROOT)))


def pages() -> dict[str, str]:
    """Every page by its path on the site."""
    found = {to: from_root((ROOT / name).read_text(encoding="utf-8")) for name, to in OUTSIDE.items()}
    docs = ROOT / "docs"
    for file in sorted(docs.rglob("*.md")):
        found[file.relative_to(docs).as_posix()] = from_docs(file.read_text(encoding="utf-8"))
    found[SCENARIO_REFERENCE] = scenario_reference.reference()
    found[COMMANDS] += "\n## Every command\n" + command_reference.reference()
    for name in [name for name in found if name.startswith("tutorials/")]:
        found[name] = notebooks.with_offer(found[name], Path(name).stem)
    code = set().union(*(sources.linked(page) for page in found.values()))
    found = {name: finished(page) for name, page in found.items()}
    return found | {
        f"{sources.FOLDER}/{file.removesuffix('.py')}.md": sources.source_page(ROOT, file) for file in sorted(code)
    }


def main() -> None:
    """Write all pages, and the files beside them."""
    shutil.rmtree(PAGES, ignore_errors=True)
    for name, page in pages().items():
        (PAGES / name).parent.mkdir(parents=True, exist_ok=True)
        (PAGES / name).write_text(page, encoding="utf-8")
    for file in (ROOT / "docs").rglob("*"):
        if file.suffix in KEPT:
            place = PAGES / file.relative_to(ROOT / "docs")
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, place)
    for name, notebook in notebooks.every().items():
        (PAGES / "tutorials" / name).write_text(notebook, encoding="utf-8")


if __name__ == "__main__":
    main()
