"""What docs/extending.md quotes is what the tests run: the files, one section for each thing, and three examples."""

from __future__ import annotations

import dataclasses
import importlib.util
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import sim
from sim.claims.ledger import measure
from sim.claims.verdict import number
from sim.reporting.drawing import svg
from sim.scenario import catalogue

ROOT = Path(__file__).resolve().parents[2]
PARTS = ROOT / "tests" / "parts"
RENEW = "run `make extending` and look at what changed"
SECTIONS = {
    "Sensor": "doppler_radar.py",
    "Tracker": "alpha_beta.py",
    "Mode": "wings_level.py",
    "Wind event": "updraught.py",
    "Aircraft": "light_twin/light_twin.xml",
    "Metric": "metric_row.py",
    "Figure": "drift_history.py",
    "Claim": "claims_of_averaging.py",
}


def load(path: Path) -> ModuleType:
    """A module beside the tests: they are no package."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


extending = load(ROOT / "tests" / "docs" / "extending.py")
PAGE = extending.PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("path", extending.quotes(PAGE))
def test_a_quoted_file_is_the_one_that_the_tests_run(path):
    assert extending.quotes(PAGE)[path] == (ROOT / path).read_text(encoding="utf-8"), RENEW


@pytest.mark.parametrize("title", SECTIONS)
def test_everything_that_can_be_added_has_a_section_with_a_whole_file(title):
    sections = dict(re.findall(r"^## ([^\n]+)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL))
    assert f"tests/parts/{SECTIONS[title]}" in extending.quotes(sections[title])


def test_every_family_of_kinds_has_its_row_and_its_entry_points():
    """A family is a folder of the catalogue; the kinematic truths of the papers are no kinds of a scenario."""
    for family, (package, _) in catalogue.FOLDERS.items():
        if family != "truths":
            assert f"`{package.replace('.', '/')}/`" in PAGE
            assert f"`shortfinal.{family}`" in PAGE


def test_a_quote_is_brought_up_to_date(tmp_path):
    (tmp_path / "part.py").write_text("x = 2\n", encoding="utf-8")
    page = "a\n\n<!-- file: part.py -->\n```python\nx = 1\n```\n\n```python\nx = 1\n```\n"
    assert extending.renewed(page, tmp_path) == page.replace("x = 1", "x = 2", 1)
    with pytest.raises(FileNotFoundError):
        extending.renewed(page, tmp_path / "elsewhere")


@pytest.fixture(scope="module")
def captured():
    """The aircraft's own scenario, run where its folder lies."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(PARTS)
        return sim.run("capture.toml")


def test_the_aircraft_captures_its_line_within_the_limits_of_its_scenario(captured):
    assert captured.flight.outcome == "completed"
    assert [check["metric"] for check in captured.metrics["checks"] if not check["passed"]] == []
    assert abs(captured.flight.deviation.cross_track[-1]) < 1.0


def test_the_figure_shows_the_drift_across_north_and_nothing_without_any(captured):
    drift_history = load(PARTS / "drift_history.py").drift_history
    state = captured.flight.state
    motion = {"velocity_north": 70.0, "velocity_east": 7.0, "heading": np.radians(359.0)}
    drifting = state._replace(**{name: np.full(len(state.time), value) for name, value in motion.items()})
    figure = drift_history(dataclasses.replace(captured.flight, state=drifting))
    assert "drift, deg (+ right)" in svg.written(figure, "Drift")
    still = drifting._replace(heading=drifting.course)
    assert drift_history(dataclasses.replace(captured.flight, state=still)) is None
    (curve,) = figure.panels[1].lines
    assert curve.y == pytest.approx(np.degrees(np.arctan(0.1)) + 1.0)


def test_the_claim_is_judged_by_the_print_and_not_by_itself():
    (claim,) = load(PARTS / "claims_of_averaging.py").CLAIMS
    row = measure("textbook", claim, seed=7, quick=True)
    assert row.verdict == "reproduced"
    assert [found.value for found in row.measured] == pytest.approx([np.sqrt(25.0), np.sqrt(26.0)], rel=0.15)
    misprinted = dataclasses.replace(claim, printed=number("25"))
    assert measure("textbook", misprinted, seed=7, quick=True).verdict == "refuted"
