"""The uses that README.md and docs show: ``make uses`` runs them and renews their transcripts and figures.

A transcript stands in its page behind ``<!-- transcript: NAME -->``; its figure is one chart of the report that the
commands wrote, kept in docs/figures.
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
README = ROOT / "README.md"
CHOOSING = ROOT / "docs" / "choosing-a-tracker.md"

APPROACH = """\
name = "crosswind"

[aircraft]
model = "an26"

[start]
phase = "base"

[route]
kind = "pattern"

[wind]
from_deg = 110
speed_kt = 20

[[checks]]
name   = "bank on the turn to final"
metric = "bank_deg"
during = "final_turn"
max    = 15.5
source = "our operations manual"

[[checks]]
name   = "stabilised: sink"
metric = "sink_mps"
during = "gate"
max    = 5.08
source = "1000 ft/min below 1000 ft, Flight Safety Foundation"

[[checks]]
name   = "overshoot onto final"
metric = "overshoot_m"
max    = 30
source = "the parallel runway"
"""
TESTS = """\
import pytest

@pytest.mark.parametrize("speed", [0, 10, 20])
def test_lands_in_wind(shortfinal, speed):
    result = shortfinal("crosswind.scenario.toml", {"wind.speed_kt": speed})
    assert result.metrics["flight"]["outcome"] == "landed"
"""


class Use(NamedTuple):
    """Commands in a folder with some files, and the chart that they lead to."""

    name: str
    files: dict[str, str]
    commands: tuple[str, ...]
    report: str = ""
    chart: str = ""  # of the report; "" = none is shown
    page: Path = README
    until: str = ""  # the transcript ends before the line that begins so


USES = (
    Use(
        "comparison",
        {},
        ("shortfinal run -o out/an26_pattern",),
        "out/an26_pattern/report.html",
        "Linear feedback against saturated control (each at its best)",
        until="\ntracker",
    ),
    Use(
        "approach",
        {},
        ("shortfinal run an26_crosswind --set wind.speed_kt=20 -o out/crosswind",),
        "out/crosswind/report.html",
        "Plan view",
    ),
    Use(
        "study",
        {},
        ("shortfinal study orbit_map -j 2 -o out/orbit_map",),
        "out/orbit_map/report.html",
        "Outcomes",
    ),
    Use(
        "checks",
        {"crosswind.scenario.toml": APPROACH, "test_winds.py": TESTS},
        ("pytest -v --no-header --shortfinal-report=kept",),
        "kept/crosswind/report.html",
        "Bank and its limits",
    ),
    Use(
        "captured",
        {},
        ("shortfinal run vasylyev2003_jsbsim -o out/captured",),
        page=CHOOSING,
        until="Conformance",
    ),
    Use(
        "pattern",
        {},
        ("shortfinal run an26_pattern -o out/pattern",),
        page=CHOOSING,
        until="Conformance",
    ),
)


def transcript(use: Use, folder: Path) -> str:
    """What a terminal shows of the commands of a use."""
    for name, text in use.files.items():
        (folder / name).write_text(text)
    environment = {
        **os.environ,
        "COLUMNS": "100",
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONPATH": str(ROOT),
        "PYTEST_PLUGINS": "sim.pytest_plugin",  # as an installed shortfinal is found
    }
    programs = {"shortfinal": "sim", "pytest": "pytest"}
    shown = []
    for command in use.commands:
        program, *arguments = shlex.split(command)
        call = [sys.executable, "-m", programs[program], *arguments]
        done = subprocess.run(call, cwd=folder, env=environment, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):
            raise RuntimeError(f"{command}:\n{done.stdout}{done.stderr}")
        shown += [f"$ {command}", (done.stdout + done.stderr).rstrip()]
    text = "\n".join(shown)
    return text.partition(f"\n{use.until}")[0].rstrip() if use.until else text


def chart(report: Path, title: str) -> bytes:
    """The SVG of one chart of a report, on paper of its own: a page that shows it may be dark."""
    head = re.escape(html.escape(title))
    pattern = rf'<h3>{head}</h3>.*?(<svg class="drawing".*?</svg>)\s*<figcaption'
    found = re.search(pattern, report.read_text(), re.DOTALL)
    if found is None:
        raise RuntimeError(f"{report}: has no chart '{title}'")
    return found[1].replace("<svg ", '<svg style="background:#fff" ', 1).encode()


def renewed(page: str, name: str, text: str) -> str:
    """The page with another transcript."""
    pattern = re.compile(rf"(<!-- transcript: {name} -->\n```\n).*?(^```\n)", re.DOTALL | re.MULTILINE)
    if not pattern.search(page):
        raise RuntimeError(f"there is no place for the transcript '{name}'")
    return pattern.sub(lambda found: f"{found[1]}{text}\n{found[2]}", page)


def main() -> None:
    """All uses, or those that the command line names."""
    FIGURES.mkdir(parents=True, exist_ok=True)
    for use in USES:
        if sys.argv[1:] and use.name not in sys.argv[1:]:
            continue
        with tempfile.TemporaryDirectory() as place:
            text = transcript(use, Path(place))
            if use.chart:
                (FIGURES / f"{use.name}.svg").write_bytes(chart(Path(place) / use.report, use.chart))
        use.page.write_text(renewed(use.page.read_text(), use.name, text))
        print(text)


if __name__ == "__main__":
    main()
