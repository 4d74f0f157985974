"""The page of a study, read as a browser reads it: the right kind of figure, every cell, nothing from elsewhere."""

from __future__ import annotations

import re

import pytest

from sim.metrics.checks import evaluate_checks
from sim.reporting.drawing import svg
from sim.reporting.drawing.colours import VIRIDIS
from sim.reporting.drawing.marks import Blocks
from sim.reporting.text.broken_checks import run_again
from sim.scenario.reading import read
from sim.studies.figures import study_charts
from sim.studies.metrics import study_metrics
from sim.studies.page import page, shown_metrics
from tests.capture import CAPTURE
from tests.sim.drawn import marks

LINE = {**CAPTURE, "name": "line"}
AGAIN = run_again("scenario.toml")


def made(axes, outcome=lambda values: "completed", samples=1, checks=(), **study):
    """A study whose overshoot is the sum of the axes' values: scenario, metrics, records."""
    from sim.scenario.axes import cells
    from sim.scenario.axes import samples as drawn

    scenario = read({**LINE, "study": {"axes": axes, "samples": samples, **study}, "checks": checks})
    records = [
        {
            "cell": i,
            "sample": j,
            "flight": j,
            "values": (values := {**chosen, **sample}),
            "metrics": {"outcome": outcome(values), "overshoot_m": float(sum(map(float, values.values())))},
            "checks": [],
        }
        for i, chosen in enumerate(cells(scenario.study.varied))
        for j, sample in enumerate(drawn(scenario.study.varied, samples, 1))
    ]
    for record in records:
        record["checks"] = evaluate_checks(scenario.checks, None, scenario.runway, record["metrics"])
    figures = study_metrics(scenario.study.varied, records, scenario.checks, AGAIN)
    metrics = {"scenario": "line", "seed": 1, "flights": len(records), "versions": {"python": "3"}, **figures}
    return scenario, metrics, records


SPEEDS = {"wind.speed_mps": {"grid": [0, 9, 10]}}
OFFSETS = {"start.cross_track_m": {"grid": [0, 700, 8]}}


@pytest.mark.parametrize(
    ("axes", "samples", "titles"),
    [
        (SPEEDS, 1, ["overshoot of the last leg, m"]),
        (SPEEDS | OFFSETS, 1, ["Outcomes", "overshoot of the last leg, m"]),
        ({"start.cross_track_m": {"uniform": [0, 9]}}, 20, ["overshoot of the last leg, m"]),
        (SPEEDS | {"start.cross_track_m": [1, 2, 3]}, 1, ["overshoot of the last leg, m"]),
    ],
    ids=["curve", "map", "distribution", "lines"],
)
def test_every_kind_of_axes_has_its_figure(axes, samples, titles):
    def outcome(values):
        return "orbit" if values.get("wind.speed_mps", 0) > 5 else "completed"

    scenario, metrics, records = made(axes, outcome, samples)
    charts = study_charts(scenario, metrics, records, shown_metrics(scenario, metrics))
    assert [chart.title for chart in charts] == titles
    for chart in charts:
        assert svg.written(chart.figure, chart.title).count("<path") > 3


def test_a_map_has_a_colour_for_each_cell():
    scenario, metrics, records = made(SPEEDS | OFFSETS)
    (chart,) = study_charts(scenario, metrics, records, ["overshoot_m"])
    (blocks,) = marks(chart.figure.panels[0], Blocks)
    assert len(blocks.colours) == len(blocks.left) == 80
    assert (blocks.colours[0], blocks.colours[-1]) == (VIRIDIS[0], VIRIDIS[-1])  # no wind on the line, most of both
    assert len(set(blocks.colours)) > 50  # of 80 sums, some closer than a step of the colours


def test_the_page_is_whole_and_asks_for_nothing():
    checks = [{"metric": "overshoot_m", "max": 3.0, "source": "<b>test</b>"}]
    scenario, metrics, records = made(SPEEDS, checks=checks)
    text = page(scenario, metrics, records, AGAIN)
    assert not re.search(r"\b(src|href)=", text)
    assert "<b>test</b>" not in text
    assert "Broken: overshoot_m: 4 of 10 flights keep it; overshoot_m = 9 m, limit 3 m" in text
    assert "flight 0, seed 1, wind.speed_mps = 9: shortfinal run scenario.toml --set wind.speed_mps=9.0" in text
    assert "not for operational use" in text
    cells = re.findall(r"<tr><td>(\d)</td><td>1</td><td>1 completed</td><td>(\d)</td></tr>", text)
    assert cells == [(str(i), str(i)) for i in range(10)]
    assert text == page(scenario, metrics, records, AGAIN)
