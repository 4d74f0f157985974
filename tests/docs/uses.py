"""What README.md and docs show of the command line: ``make uses`` runs it and renews transcripts and figures.

A page is run from top to bottom in one empty folder. A block behind ``<!-- file: NAME -->`` is a file of that folder.
One behind ``<!-- transcript: NAME -->`` has commands behind its ``$`` and what they print; ``until: WORD`` in the
comment ends it before the line that begins so. A picture behind ``<!-- chart: REPORT: TITLE -->`` is that chart of a
report which the commands have written, kept in docs/figures.
"""

from __future__ import annotations

import html
import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
FIGURES = ROOT / "docs" / "figures"
USES = sorted((ROOT / "docs" / "uses").glob("*.md"))
PAGES = (ROOT / "README.md", *(ROOT / "docs" / f"{name}.md" for name in ("choosing-a-tracker", "studies")), *USES)
PROGRAMS = {
    "shortfinal": [sys.executable, "-m", "sim"],
    "pytest": [sys.executable, "-m", "pytest"],
    "python": [sys.executable],
}
STEP = re.compile(
    r"^<!-- file: (?P<file>\S+) -->\n```\w*\n(?P<content>.*?)^```$"
    r"|^<!-- transcript: (?P<transcript>[\w-]+)(?:, until: (?P<until>.+?))? -->\n```\n(?P<shown>.*?)^```$"
    r"|^<!-- chart: (?P<report>\S+): (?P<title>.+?) -->\n!\[[^\]]*\]\((?P<picture>[^)]+)\)",
    re.MULTILINE | re.DOTALL,
)
OTHERS = re.compile(r"PYTEST_|CI$|BUILD_NUMBER$")  # with these pytest writes as another session or a CI has it
TIMES = re.compile(r"\b\d+\.\d+s\b|=+(?= \d)|(?<=s )=+")  # of pytest's last line, whose rule is as long as they leave


class Made(NamedTuple):
    """What a page leads to: the text of its transcripts by name, its charts as SVG by the file that keeps them."""

    transcripts: dict[str, str]
    charts: dict[Path, bytes]


def lasting(text: str) -> str:
    """A transcript without what differs from run to run."""
    return TIMES.sub("", text)


def shown(page: Path) -> dict[str, str]:
    """The transcripts of a page as it stands."""
    found = STEP.finditer(page.read_text(encoding="utf-8"))
    return {step["transcript"]: step["shown"].rstrip() for step in found if step["transcript"]}


def run(page: Path, folder: Path) -> Made:
    """Do in a folder what a page does; raises ``RuntimeError`` for a command that ends with an error."""
    made = Made({}, {})
    for step in STEP.finditer(page.read_text(encoding="utf-8")):
        if step["file"]:
            (folder / step["file"]).write_text(step["content"], encoding="utf-8")
        elif step["transcript"]:
            commands = [line[2:] for line in step["shown"].splitlines() if line.startswith("$ ")]
            text = "\n".join(f"$ {command}\n{output(command, folder)}".rstrip() for command in commands)
            made.transcripts[step["transcript"]] = text.partition(f"\n{step['until']}")[0].rstrip()
        else:
            made.charts[(page.parent / step["picture"]).resolve()] = chart(folder / step["report"], step["title"])
    return made


def output(command: str, folder: Path) -> str:
    """What a terminal of 100 columns shows of a command; a check or a test may fail."""
    environment = {
        **{name: value for name, value in os.environ.items() if not OTHERS.match(name)},
        "COLUMNS": "100",
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONPATH": str(ROOT),
        "PYTEST_PLUGINS": "sim.pytest_plugin",  # as an installed shortfinal is found
    }
    program, *arguments = shlex.split(command, comments=True)
    call = [*PROGRAMS[program], *arguments]
    done = subprocess.run(call, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{command}:\n{done.stdout}{done.stderr}")
    return (done.stdout + done.stderr).rstrip()


def chart(report: Path, title: str) -> bytes:
    """The SVG of one chart of a report, on paper of its own: a page that shows it may be dark."""
    head = re.escape(html.escape(title))
    pattern = rf'<h3>{head}</h3>.*?(<svg class="drawing".*?</svg>)\s*<figcaption'
    found = re.search(pattern, report.read_text(encoding="utf-8"), re.DOTALL)
    if found is None:
        raise RuntimeError(f"{report}: has no chart '{title}'")
    return found[1].replace("<svg ", '<svg style="background:#fff" ', 1).encode()


def renewed(page: str, made: Made) -> str:
    """The text of a page with other transcripts."""

    def step(found: re.Match[str]) -> str:
        if not found["transcript"]:
            return found[0]
        return found[0].replace(found["shown"], made.transcripts[found["transcript"]] + "\n")

    return STEP.sub(step, page)


def main() -> None:
    """All pages, or those that the command line names."""
    FIGURES.mkdir(parents=True, exist_ok=True)
    for page in PAGES:
        if sys.argv[1:] and page.stem not in sys.argv[1:]:
            continue
        with tempfile.TemporaryDirectory() as place:
            made = run(page, Path(place))
        for figure, drawn in made.charts.items():
            figure.write_bytes(drawn)
        page.write_text(renewed(page.read_text(encoding="utf-8"), made), encoding="utf-8")
        print(page.relative_to(ROOT))


if __name__ == "__main__":
    main()
