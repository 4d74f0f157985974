"""Every measured figure becomes a row; the rows of a whole run are written to docs/acceptance.md."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "out" / "acceptance.jsonl"
PAGE = ROOT / "docs" / "acceptance.md"


@pytest.fixture
def row(request: pytest.FixtureRequest) -> Callable[..., None]:
    """``row(what, asked, measured, met)``: note one figure; the test itself decides what it asserts."""
    group = request.node.path.stem.removeprefix("test_")

    def note(what: str, asked: str, measured: str, met: bool) -> None:
        entry = {"group": group, "what": what, "asked": asked, "measured": measured, "met": bool(met)}
        KEPT.parent.mkdir(exist_ok=True)
        with KEPT.open("a") as file:
            file.write(json.dumps(entry) + "\n")
        print(f"\n{what}: {measured} (asked {asked}) {'met' if met else 'SHORT'}")

    return note


def pytest_sessionstart(session: pytest.Session) -> None:
    if not hasattr(session.config, "workerinput"):
        KEPT.unlink(missing_ok=True)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Replace the rows of the groups that were measured; groups that were not run keep theirs."""
    if not KEPT.exists() or hasattr(session.config, "workerinput"):
        return
    measured: dict[str, list[dict[str, object]]] = {}
    for line in KEPT.read_text().splitlines():
        entry = json.loads(line)
        measured.setdefault(entry["group"], []).append(entry)
    groups = {**_kept(), **{name: _table(rows) for name, rows in measured.items()}}
    head = (
        "# Measured figures\n\nWritten by `make acceptance`; each row is asked by an issue and measured at full size.\n"
    )
    PAGE.parent.mkdir(exist_ok=True)
    PAGE.write_text(head + "".join(f"\n## {name}\n\n{table}" for name, table in sorted(groups.items())))


def _table(rows: list[dict[str, object]]) -> str:
    lines = ["| what | asked | measured | |", "|---|---|---|---|"]
    lines += [f"| {r['what']} | {r['asked']} | {r['measured']} | {'met' if r['met'] else '**short**'} |" for r in rows]
    return "\n".join(lines) + "\n"


def _kept() -> dict[str, str]:
    if not PAGE.exists():
        return {}
    parts = PAGE.read_text().split("\n## ")[1:]
    return {part.split("\n", 1)[0]: part.split("\n", 1)[1].strip() + "\n" for part in parts}
