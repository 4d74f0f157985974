"""Files of the code that a page links to, as pages of the site, and the line on which a name is defined."""

from __future__ import annotations

import ast
import re
from pathlib import Path

LINK = re.compile(
    r"\[`(?P<words>[^`\]]+)`\]\((?P<up>(?:\.\./)+)(?P<file>(?:aircraft|autopilot|tracking|sim)/[\w/]+\.py)\)"
)
FOLDER = "source"
HEAD = "---\nsearch:\n  exclude: true\nhide:\n  - navigation\n---\n\n"


def linked(page: str) -> set[str]:
    """The files that a page links to."""
    return {found["file"] for found in LINK.finditer(page)}


def relinked(page: str, root: Path) -> str:
    """The page with its links to code leading to the pages of that code, to the line where a name is given."""

    def link(found: re.Match[str]) -> str:
        name = found["words"].partition(":")[2]
        line = line_of(root / found["file"], name) if name else None
        anchor = f"#__codelineno-0-{line}" if line else ""
        up = found["up"].removeprefix("../")
        return f"[`{found['words']}`]({up}{FOLDER}/{found['file'].removesuffix('.py')}.md{anchor})"

    return LINK.sub(link, page)


def line_of(file: Path, name: str) -> int | None:
    """Where a function, class or method is defined; None where the file has none of that name."""
    inside: ast.AST = ast.parse(file.read_text(encoding="utf-8"))
    for part in name.split("."):
        found = next((one for one in ast.iter_child_nodes(inside) if getattr(one, "name", None) == part), None)
        if found is None:
            return None
        inside = found
    return getattr(inside, "lineno", None)


def source_page(root: Path, file: str) -> str:
    """One file of the code as a page that search leaves out."""
    code = (root / file).read_text(encoding="utf-8")
    return f'{HEAD}# {file}\n\n````python linenums="1"\n{code}````\n'
