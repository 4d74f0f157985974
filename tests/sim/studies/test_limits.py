"""Limit studies: theory against filters that are run and sums by hand; maps and sentences of figures that are known."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from autopilot.route import Leg, Route
from sim.errors import ScenarioError
from sim.metrics.contrasts.pairing import entry
from sim.metrics.ensemble.contrasts import contrasts_over_flights
from sim.reporting.drawing import svg
from sim.reporting.drawing.marks import Blocks
from sim.reporting.text.broken_checks import run_again
from sim.scenario.plugins import catalogue_with
from sim.scenario.reading import read
from sim.scenario.tables import Contrast
from sim.scenario.toml_writer import dumps
from sim.studies.figures import edges, label, short, study_charts
from sim.studies.limits.answer import answer
from sim.studies.limits.capture import Filters, capture, contact
from sim.studies.limits.drawing import ratio_chart
from sim.studies.limits.maps import ratio_maps, undecided
from sim.studies.limits.prediction import BANK, CROSS_TRACK, OFFSET, cell_figures, predict
from sim.studies.metrics import study_metrics
from sim.studies.page import page, shown_metrics
from sim.studies.plan import plan, read_text
from sim.studies.theory import THEORIES
from tests.capture import CAPTURE
from tests.sim.drawn import marks
from tests.tracking.law_truth import CROSS_TRACK as ACROSS
from tests.tracking.law_truth import GRAVITY, LINE, NOMINAL, prior, record, route_truth
from tracking.track import follow
from tracking.trackers.linear_feedback import LinearFeedback
from tracking.trackers.saturated_control import SaturatedControl

FILTERS = Filters(4.0, 100.0, (100.0, 5.0), 0.1, 0.1)
BUNDLED = catalogue_with()
FAST = 1e4  # m/s: courses stay so small that the motion is the double integrator


def test_the_ratio_is_that_of_filters_that_are_run():
    """8 %: the ratio of 100 runs has a spread of 3 %, what theory leaves out is worth 3 % in the paper's captures."""
    starts, runs = (800.0, 2000.0, 5000.0), 100
    route = Route((Leg((0.0, 0.0), (60000.0, 0.0), 100.0, 600.0),))
    begin = np.array([[0.0, 100.0, z, 0.0] for z in starts]).T
    flown = np.concatenate(
        [route_truth(NOMINAL, route, begin[:, i], 300.0, None, 1, density=0.0).x[:, 2:] for i in range(3)], axis=2
    )
    predicted = capture(NOMINAL, np.array(starts), 100.0, 300.0, FILTERS).ratio
    for i, expected in enumerate(predicted):
        truth = np.repeat(flown[1:, :, i : i + 1], runs, axis=2)  # the first scan is one period after the start
        linear, saturated = (
            rmse(kind(NOMINAL, LINE, ACROSS, 0.1), truth) for kind in (LinearFeedback, SaturatedControl)
        )
        assert linear / saturated == pytest.approx(expected, rel=0.08)


def rmse(tracker, truth):
    """Of the deviation over all scans, of which the first corrects the prior; the same noise for every tracker."""
    generator = np.random.default_rng(5)
    start, plots = prior(truth, generator), record(truth, generator)
    errors = [epoch.estimate.mean[0] - truth[epoch.row, 0] for epoch in follow(tracker, plots, start, start=0.0)]
    return float(np.sqrt(np.mean(np.square(errors))))


def test_time_at_the_bank_limit_by_hand():
    """Only the bank limit: from rest at g tan(c) until k1 z + k2 z' is c, and the brake never comes to it again."""
    law = replace(NOMINAL, cross_track_limit=1e9, cross_track_rate_limit=1e9)
    start = 1.2 * law.bank_limit / law.k1
    push = GRAVITY * math.tan(law.bank_limit)
    # k1 (z0 - push t^2 / 2) - k2 push t = c
    a, b, c = 0.5 * law.k1 * push, law.k2 * push, law.bank_limit - law.k1 * start
    by_hand = (-b + math.sqrt(b * b - 4 * a * c)) / (2 * a)
    assert by_hand > 2.0
    found = capture(law, np.array([start, 0.9 * law.bank_limit / law.k1]), FAST, 200.0, None)
    assert found.at_limits == pytest.approx([by_hand, 0.0], abs=0.2)  # a step
    assert found.ratio is None


@pytest.mark.parametrize(
    ("limits", "greatest"),
    [
        ({"cross_track_limit": 1e9, "cross_track_rate_limit": 1e9}, NOMINAL.k1 / NOMINAL.bank_limit),
        ({"bank_limit": 1e9, "cross_track_rate_limit": 1e9}, 1.0 / NOMINAL.cross_track_limit),
    ],
)
def test_the_first_limit_of_a_capture_by_hand(limits, greatest):
    law = replace(NOMINAL, **limits)
    assert contact(law, np.array([100.0, -700.0]), 200.0) == pytest.approx([100.0 * greatest, 700.0 * greatest])


def test_the_fastest_of_a_linear_capture_by_hand():
    """z' of a second-order loop from z0 at rest is greatest at tan(wd t) = wd / (zeta w): z0 w exp(-zeta w t)."""
    law = replace(NOMINAL, bank_limit=1e9, cross_track_limit=1e9)
    w, zeta = law.frequency, law.damping
    angle = math.acos(zeta)
    fastest = w * math.exp(-angle / math.tan(angle))
    assert contact(law, 1000.0, 200.0) == pytest.approx(1000.0 * fastest / law.cross_track_rate_limit, rel=1e-3)


LIMITS = read("limits_map", {"until_s": 100.0})


def test_predicted_figures_of_cells_are_those_of_the_map():
    """One cell at a time, all as columns, and with the offset to the other side."""
    cells = [{OFFSET: z, BANK: bank, CROSS_TRACK: 900.0} for z, bank in ((400.0, 8.0), (-2500.0, 8.0))]
    columns = cell_figures(LIMITS, cells)
    for i, cell in enumerate(cells):
        alone = predict(LIMITS, {**cell, OFFSET: abs(cell[OFFSET])})
        assert [column[i] for column in columns.values()] == pytest.approx([float(alone.at_limits), float(alone.ratio)])
    assert columns["at_limits_s"][0] == 0.0
    assert columns["at_limits_s"][1] > 40.0


def test_theory_of_another_pair_or_filter_has_no_ratio():
    """Of the reversed pair it is the inverse; of other kinds, of a mismatched law or of no stated density none."""
    cell = {OFFSET: 2500.0, BANK: 8.0}
    forward = float(predict(LIMITS, cell).ratio)
    turned = [{"of": "saturated_control", "against": "linear_feedback"}]
    assert float(predict(read(tables(contrasts=turned)), cell).ratio) == pytest.approx(1.0 / forward)
    for changes in (
        {"contrasts": [{"of": "imm", "against": "saturated_control"}]},
        {"contrasts": []},
        {"trackers.saturated_control.law.cross_track_limit_factor": 1.3},
        {"trackers.saturated_control.covariance": "jacobian"},
        {"trackers.linear_feedback": {"kind": "linear_feedback"}},
        {"sensors.radar": {"kind": "surveillance_radar"}},
    ):
        assert predict(read(LIMITS.tables, changes), cell).ratio is None


def tables(**changes):
    """limits_map as tables with some of them replaced; None takes one out."""
    return {key: value for key, value in {**LIMITS.tables, **changes}.items() if value is not None}


OFFSETS = {"axes": {OFFSET: [300.0, 600.0]}, "theory": "limits"}
LAW = LIMITS.tables["autopilot"]["law"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"route": {"kind": "pattern"}, "start": {}, "autopilot": {}}, "needs a route of one leg"),
        ({"autopilot": {"kind": "radio_beacon"}}, "needs a law of the cross-track and its rate"),
        (
            {"autopilot": {"law": {k: v for k, v in LAW.items() if not k.startswith("k1")}}},
            "needs one law in all cells",
        ),
        ({"wind": {"speed_mps": 3.0}}, "needs still air, without [wind]"),
        ({"departures": [{"at_s": 5.0, "flies": "bank", "bank_deg": 5.0}]}, "needs a law that is flown all the time"),
        ({"study": {"axes": {OFFSET: [1.0], "draws_": [1]}}}, "no such key"),
        ({"study": {**OFFSETS, "axes": {OFFSET: [300.0], "wind.speed_mps": [0.0]}}}, 'the axis "wind.speed_mps"'),
        ({"study": {"samples": 2, "theory": "limits"}}, "needs an axis of chosen values"),
    ],
)
def test_a_study_that_theory_knows_nothing_of_is_refused_in_one_sentence(changes, said):
    with pytest.raises(ScenarioError) as caught:
        plan(read(tables(study=OFFSETS) | changes))
    (line,) = str(caught.value).splitlines()
    assert said in line


def test_an_axis_that_takes_a_contrasted_tracker_away_is_refused():
    trackers = LIMITS.tables["trackers"]
    fewer = {name: table for name, table in trackers.items() if name != "imm"}
    with pytest.raises(ScenarioError) as caught:
        plan(read(tables(study={"axes": {"trackers": [trackers, fewer]}})))
    assert str(caught.value) == (
        "limits_map: [study] axes \"trackers\": [[contrasts]] needs the tracker 'imm' in every cell"
    )


def test_a_study_keeps_the_order_of_its_axes_in_its_file():
    """Lists and grids mixed: which is across, which is up, and which is a panel follows from the order."""
    axes = {OFFSET: {"grid": [300, 900, 3]}, BANK: [4.0, 8.0], CROSS_TRACK: {"grid": [450, 900, 2]}}
    text = dumps(read(tables(study={"axes": axes})).tables)
    assert [one.address for one in read_text(text.encode(), BUNDLED).study.varied] == [*axes]
    assert dumps(read_text(text.encode(), BUNDLED).tables) == text


PAIR = {"of": "linear_feedback", "against": "saturated_control"}


def figure(value, spread):
    return {"ratio": value, "low": value / spread, "high": value * spread, "of": value, "against": 1.0, "n": 9}


def contrasted(axes, found, theory=None):
    """Scenario and metrics of a study whose ratio in each cell is ``found(values)``; None = not compared there."""
    from sim.scenario.axes import cells

    radar = {"radar": {"kind": "surveillance_radar"}}
    trackers = {name: {"kind": name} for name in PAIR.values()}
    study = {"axes": axes} | ({"theory": theory} if theory else {})
    line = {
        **CAPTURE,
        "until_s": 60.0,
        "sensors": radar,
        "trackers": trackers,
        "contrasts": [PAIR],
        "autopilot": {"law": LAW},
    }
    scenario = read({**line, "study": study})
    (asked,) = scenario.contrasts
    records = []
    for number, values in enumerate(cells(scenario.study.varied)):
        value = found(values)
        own = {} if value is None else {"overall": {"cross_track_m": figure(value, 1.2)}}
        rmse = {"overall": {"position_m": {"rmse": 50.0, "gain": 2.0}}}
        metrics = {"outcome": "completed", "bank_max_deg": 5.0, "trackers": {"linear_feedback": rmse}}
        metrics["contrasts"] = {asked.pair: entry(asked, own)}
        records.append({"cell": number, "sample": 0, "flight": 0, "values": values, "metrics": metrics, "checks": []})
    figures = study_metrics(scenario.study.varied, records, (), run_again("scenario.toml"), scenario.contrasts)
    metrics = {"scenario": "line", "seed": 1, "flights": len(records), "versions": {"python": "3"}, **figures}
    return scenario, metrics, records


def said_of(axes, found, theory=None):
    scenario, metrics, _ = contrasted(axes, found, theory)
    return answer(scenario.contrasts[0], ratio_maps(scenario, metrics))


GRID = {OFFSET: {"grid": [250, 1750, 7]}, BANK: [10.0, 15.0, 20.0]}


def test_the_answer_says_where_the_ratio_passes_one_and_the_worst_cell():
    """log2 of the ratio falls on 0 at 1000 + 25 (bank - 15) m, and is straight over the offset."""
    said = said_of(GRID, lambda v: 2.0 ** ((v[OFFSET] - 1000.0 - 25.0 * (v[BANK] - 15.0)) / 250.0))
    assert said == (
        "Linear feedback errs more than saturated control in 10 of 21 cells: beyond a start cross-track of 1000 m at a "
        "bank limit of 15 deg; in the worst cell 11.3 times (9.43 to 13.6; RMSE, cross-track over the flight)."
    )


def test_the_answer_where_there_is_no_border():
    assert "in all of 21 cells; in the worst cell 2 times" in said_of(GRID, lambda v: 2.0)
    assert "in none of 21 cells; at most 1.1 times" in said_of(GRID, lambda v: 1.1)
    assert "cannot be compared in any cell" in said_of(GRID, lambda v: None)
    lacking = said_of(GRID, lambda v: None if v[OFFSET] > 1700 else 2.0)
    assert "in all of 18 cells" in lacking
    assert "; 3 cells have no ratio" in lacking


def test_the_answer_names_the_time_at_the_limits_that_tells_the_cells_apart():
    """Cells that stay longer than 20 s at a limit are worse: the cut lies between the times of theory about 20."""
    scenario, *_ = contrasted(GRID, lambda v: 1.0)
    cells = plan(scenario).cells
    every = cell_figures(scenario, cells)["at_limits_s"]
    times = dict(zip((tuple(values.values()) for values in cells), every, strict=True))
    below, above = max(t for t in every if t <= 20.0), min(t for t in every if t > 20.0)
    said = said_of(GRID, lambda values: 2.0 if times[tuple(values.values())] > 20.0 else 0.5, "limits")
    assert f"where a limit acts for more than about {0.5 * (below + above):.0f} s" in said


def test_cells_whose_interval_holds_one_are_hatched():
    scenario, metrics, _ = contrasted(GRID, lambda v: v[OFFSET] / 1000.0)
    (one,) = ratio_maps(scenario, metrics)
    (panel,) = one.panels
    assert undecided(panel)[0].tolist() == [False, False, False, True, False, False, False]
    known = one._replace(panels=(panel._replace(low=panel.ratio, high=panel.ratio),))
    for drawn in (one, known):  # exactly 1 is on neither side
        (hatched,) = [block for block in marks(ratio_chart(drawn).figure.panels[0], Blocks) if block.hatch]
        assert ((hatched.left + hatched.right) / 2).tolist() == [1000.0] * 3


def test_a_third_axis_is_a_panel_for_each_value_and_borders_reach_the_edges():
    axes = {**GRID, CROSS_TRACK: [450.0, 900.0]}
    scenario, metrics, _ = contrasted(axes, lambda v: v[OFFSET] / v[CROSS_TRACK], "limits")
    (one,) = ratio_maps(scenario, metrics)
    assert [panel.title for panel in one.panels] == ["cross-track limit 450 m", "cross-track limit 900 m"]
    for panel, limit in zip(one.panels, (450.0, 900.0), strict=True):
        assert panel.ratio[1] == pytest.approx(np.linspace(250, 1750, 7) / limit)
        (acts,) = panel.borders
        assert (acts.x[0], acts.x[-1], acts.y[0], acts.y[-1]) == (125.0, 1875.0, 7.5, 22.5)
        at = np.interp(0.0, acts.height[-1], acts.x)  # at 22.5 deg of bank the cross-track limit is the first
        assert at == pytest.approx(limit, rel=0.03)


def test_the_page_opens_with_question_answer_and_map_and_shows_trackers_unasked():
    scenario, metrics, records = contrasted(GRID, lambda v: v[OFFSET] / 1000.0)
    maps = ratio_maps(scenario, metrics)
    metrics["answer"] = answer(scenario.contrasts[0], maps)
    text = page(scenario, metrics, records, run_again("scenario.toml"), maps)
    places = [
        text.index(part)
        for part in (
            "Where does linear feedback err more than saturated control, and by how much?",
            metrics["answer"],
            "<h3>linear feedback over saturated control: ratio of RMSE, cross-track over the flight</h3>",
            "<h3>linear feedback position RMSE, m</h3>",
        )
    ]
    assert places == sorted(places)
    asked = scenario.study.__class__(axes=scenario.study.axes, show=("bank_max_deg",))
    assert shown_metrics(replace(scenario, study=asked), metrics) == ["bank_max_deg"]


def test_a_figure_says_which_cells_it_leaves_out():
    axes = {OFFSET: [250.0, 500.0], BANK: [10.0, 15.0], CROSS_TRACK: [450.0, 900.0]}
    scenario, metrics, records = contrasted(axes, lambda v: 2.0)
    (chart,) = study_charts(scenario, metrics, records, ["bank_max_deg"])
    assert chart.caption.endswith("Cells of autopilot law cross-track limit, m = 450.0; the others are in the table.")


def test_one_axis_is_a_curve():
    axes = {OFFSET: {"grid": [250, 1750, 7]}}
    scenario, metrics, _ = contrasted(axes, lambda v: v[OFFSET] / 1000.0, "limits")
    (one,) = ratio_maps(scenario, metrics)
    assert one.y is None
    chart = ratio_chart(one)
    assert "a limit acts, by theory" in svg.written(chart.figure, chart.title)
    assert "beyond a start cross-track of 1000 m" in said_of(axes, lambda v: 2.0 ** (v[OFFSET] / 250.0 - 4.0))


def test_the_contrast_of_one_flight_keeps_its_interval_over_draws():
    asked = Contrast("a", "b")
    own = entry(asked, {"overall": {"position_m": figure(2.0, 1.1)}})
    (alone,) = contrasts_over_flights([asked], [{"metrics": {"contrasts": {"a/b": own}}}])
    assert alone == own


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("trackers.mine.overall.position_m.gain", "mine position gain"),
        ("trackers.mine.overall.position_m.rmse", "mine position RMSE, m"),
        ("trackers.mine.look_ahead.60_s.position_m", "mine look ahead 60 s position, m"),
        ("contrasts.a/b.overall.cross_track_m.ratio", "a/b cross-track ratio"),
        ("start.cross_track_m", "start cross-track, m"),
    ],
)
def test_a_label_has_the_unit_of_its_figure(name, shown):
    assert label(name) == shown


def test_an_axis_in_a_sentence_is_short():
    assert short(CROSS_TRACK) == "cross-track limit"
    assert short(OFFSET) == "start cross-track"


def test_lines_of_theory_reach_the_edges_of_the_outer_cells():
    assert edges(np.array([0.0, 3.0, 6.0])).tolist() == [-1.5, 1.5, 4.5, 7.5]
    assert edges(np.array([2.0, 8.0])).tolist() == [1.0, 5.0, 11.0]  # no law is designed for a limit below 0
    from sim.studies.figures import _lines

    scenario = read("orbit_map", {"aircraft": {"model": "point_mass"}})
    described = {one.address: {"values": list(one.values)} for one in scenario.study.varied}
    (line,) = _lines(scenario, {"axes": described}, *described)
    assert (line.x[0], line.x[-1]) == (-1.5, 22.5)
    assert THEORIES["orbit"].needs(scenario) == ""
