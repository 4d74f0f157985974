"""The tutorials as notebooks, made from their pages: text as text, code as code, and what it prints below it.

``python -m tests.docs.site.notebooks FOLDER`` writes them.
"""

from __future__ import annotations

import base64
import json
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[3]
TUTORIALS = ROOT / "docs" / "tutorials"
CODE = re.compile(r"^```python\n(?P<code>.*?)^```\n(?:\n```text\n(?P<shown>.*?)^```\n)?", re.MULTILINE | re.DOTALL)
PICTURE = re.compile(r"!\[(?P<words>[^\]]*)\]\((?P<file>[^)]+\.svg)\)")
Cell = dict[str, Any]


def notebook(page: Path) -> Cell:
    """One tutorial in the format of notebooks, version 4.5; figures of the page lie in it."""
    text, cells, end = page.read_text(encoding="utf-8"), [], 0
    for found in CODE.finditer(text):
        cells += _words(page, text[end : found.start()])
        cells.append(_code(len(cells), found["code"], found["shown"] or ""))
        end = found.end()
    cells += _words(page, text[end:])
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return {
        "cells": cells,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }


def _code(number: int, code: str, shown: str) -> Cell:
    output = {"name": "stdout", "output_type": "stream", "text": shown.splitlines(keepends=True)}
    return {
        "cell_type": "code",
        "execution_count": None,
        "metadata": {},
        "outputs": [output] if shown else [],
        "source": code.rstrip("\n").splitlines(keepends=True),
    }


def _words(page: Path, text: str) -> list[Cell]:
    """Text with its pictures inside, so that the notebook can be moved; none where there is none."""
    text, attached = text.strip(), {}

    def inside(found: re.Match[str]) -> str:
        name = Path(found["file"]).name
        attached[name] = {"image/svg+xml": base64.b64encode((page.parent / found["file"]).read_bytes()).decode()}
        return f"![{found['words']}](attachment:{name})"

    text = PICTURE.sub(inside, text)
    cell: Cell = {"cell_type": "markdown", "metadata": {}, "source": text.splitlines(keepends=True)}
    if attached:
        cell["attachments"] = attached
    return [cell] if text else []


def every() -> dict[str, str]:
    """All notebooks by the names of their files."""
    made = {page.with_suffix(".ipynb").name: notebook(page) for page in sorted(TUTORIALS.glob("*.md"))}
    return {name: json.dumps(one, indent=1, ensure_ascii=False) + "\n" for name, one in made.items()}


def with_offer(page: str, name: str) -> str:
    """The page of a tutorial with its notebook offered below the title."""
    title, _, rest = page.partition("\n")
    return f"{title}\n\n[As a notebook]({name}.ipynb){{ .md-button download }}\n{rest}"


def main() -> None:
    """Write them into the folder that is named."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in every().items():
        (folder / name).write_text(text, encoding="utf-8")
        print(folder / name)


if __name__ == "__main__":
    main()
