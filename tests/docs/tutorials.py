"""The tutorials run: what their code prints and draws, beside what the pages show.

``python tests/docs/tutorials.py`` runs every page of docs/tutorials and writes what it printed into the page and its
figures into docs/figures/tutorials. A page is a series of ``python`` blocks that share one namespace; a ``text`` block
right behind one shows what it prints.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PAGES = ROOT / "docs" / "tutorials"
FIGURES = ROOT / "docs" / "figures" / "tutorials"

_BLOCK = re.compile(r"^```python\n(?P<code>.*?)^```\n(?:\n```text\n(?P<shown>.*?)^```\n)?", re.MULTILINE | re.DOTALL)
_FIGURE = re.compile(r"\]\(\.\./figures/tutorials/([^)]+)\)")

DRIVER = """
import contextlib, io, json, sys
from sim.reporting.drawing.matplotlib_backend import import_matplotlib
import_matplotlib()
outputs, space = [], {"__name__": "__main__"}
for code in json.load(sys.stdin):
    with contextlib.redirect_stdout(io.StringIO()) as said:
        exec(compile(code, sys.argv[1], "exec"), space)
    outputs.append(said.getvalue())
json.dump(outputs, sys.stdout)
"""


class Block(NamedTuple):
    """A piece of code, moved down to its line of the page, and the output that the page shows ("" = none)."""

    code: str
    shown: str


def blocks(page: Path) -> list[Block]:
    """The code of a page in its order."""
    text = page.read_text(encoding="utf-8")
    return [
        Block("\n" * text.count("\n", 0, found.start("code")) + found["code"], found["shown"] or "")
        for found in _BLOCK.finditer(text)
    ]


def figures(page: Path) -> set[str]:
    """Files that a page shows as its figures."""
    return set(_FIGURE.findall(page.read_text(encoding="utf-8")))


def run(page: Path, folder: Path) -> list[str]:
    """What each block prints, run in a process of its own that leaves its figures in ``folder``; a warning is an error.

    Raises ``RuntimeError`` with the traceback, which names the line of the page.
    """
    environment = os.environ | {
        "MATPLOTLIBRC": str(PAGES / "matplotlibrc"),
        "OPENBLAS_NUM_THREADS": "1",
        "SOURCE_DATE_EPOCH": "0",  # a figure drawn again is the same file
    }
    environment.pop("MPLBACKEND", None)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", DRIVER, str(page)],
        input=json.dumps([block.code for block in blocks(page)]),
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"{page.name} does not run:\n{done.stderr}")
    outputs: list[str] = json.loads(done.stdout)
    return outputs


def rewritten(page: Path, outputs: list[str]) -> str:
    """The page with the outputs of its blocks in it."""
    said = iter(outputs)

    def block(found: re.Match[str]) -> str:
        output = next(said)
        return f"```python\n{found['code']}```\n" + (f"\n```text\n{output}```\n" if output else "")

    return _BLOCK.sub(block, page.read_text(encoding="utf-8"))


def main() -> None:
    """Bring every page and figure up to date."""
    FIGURES.mkdir(parents=True, exist_ok=True)
    for page in sorted(PAGES.glob(f"{sys.argv[1] if len(sys.argv) > 1 else '*'}.md")):
        with tempfile.TemporaryDirectory() as place:
            outputs = run(page, Path(place))
            for made in Path(place).iterdir():
                shutil.copyfile(made, FIGURES / made.name)
        page.write_text(rewritten(page, outputs), encoding="utf-8")
        print(page.relative_to(ROOT))


if __name__ == "__main__":
    main()
