"""Every measured figure becomes a row of docs/acceptance.md; a partial run replaces the rows that it measured."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "acceptance.md"
HEAD = "# Measured figures\n\nWritten by `make acceptance`; each row is asked by an issue and measured at full size.\n"
TOP = "| what | asked | measured | |\n|---|---|---|---|\n"

Rows = dict[str, dict[str, str]]  # group -> what -> line of the table
MEASURED: Rows = {}


@pytest.fixture
def row(request: pytest.FixtureRequest) -> Callable[..., None]:
    """``row(what, asked, measured, met)``: note one figure; the test itself decides what it asserts."""
    group = request.node.path.stem.removeprefix("test_")

    def note(what: str, asked: str, measured: str, met: bool) -> None:
        verdict = "met" if met else "**short**"
        what, asked, measured = (text.replace("|", "/") for text in (what, asked, measured))
        MEASURED.setdefault(group, {})[what] = f"| {what} | {asked} | {measured} | {verdict} |"
        print(f"\n{what}: {measured} (asked {asked}) {'met' if met else 'SHORT'}")

    return note


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Put the measured rows in their places."""
    if not MEASURED:
        return
    rows = {} if "ANEW" in os.environ else _kept()  # `make acceptance` begins an empty page, when it has measured
    for group, lines in MEASURED.items():
        rows[group] = {**rows.get(group, {}), **lines}
    tables = (f"\n## {group}\n\n{TOP}" + "\n".join(lines.values()) + "\n" for group, lines in sorted(rows.items()))
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(HEAD + "".join(tables))


def _kept() -> Rows:
    if not PAGE.exists():
        return {}
    rows: Rows = {}
    for part in PAGE.read_text().split("\n## ")[1:]:
        group, *lines = part.splitlines()
        rows[group] = {line.split(" | ")[0].removeprefix("| "): line for line in lines[3:] if line.startswith("| ")}
    return rows
