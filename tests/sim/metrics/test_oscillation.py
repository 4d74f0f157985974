"""What oscillation a flight ends in, where it begins, and what theory says of both before anything flies."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import sim
from autopilot.route_loop import linear_onset
from sim.cli.explain import explain
from sim.errors import ScenarioError
from sim.flight.preparation import prepare
from sim.metrics.figures import bank_cycle
from sim.reporting.text.broken_checks import run_again
from sim.scenario.axes import cells
from sim.scenario.reading import read
from sim.studies import theory as study_theory
from sim.studies.limits.bisection import find_limit
from sim.studies.metrics import study_metrics
from sim.studies.page import page
from tests.capture import CAPTURE
from tests.sim.drawn import drawings

LINE = {**CAPTURE, "name": "line", "until_s": 60.0, "start": {"cross_track_m": 3000.0}}
G = 9.80665


def swinging(bank, until=200.0):
    """A flight whose bank is a function of time."""
    time = np.arange(0.0, until, 1.0 / 30.0)
    return SimpleNamespace(time=time, state=SimpleNamespace(bank=np.radians(bank(time))))


def oscillation(flight):
    """Amplitude and period as metrics.json names them."""
    amplitude, period = bank_cycle(flight)
    return {"bank_cycle_deg": math.degrees(amplitude), "bank_cycle_period_s": period}


def test_a_steady_oscillation_has_its_amplitude_and_period_whatever_came_before():
    found = oscillation(swinging(lambda t: 1.5 + np.where(t < 75.0, 30.0, 5.0) * np.sin(math.tau * t / 7.0)))
    assert found["bank_cycle_deg"] == pytest.approx(5.0, rel=1e-3)  # 210 records of a period
    assert found["bank_cycle_period_s"] == pytest.approx(7.0, rel=1e-3)


@pytest.mark.parametrize("phase", np.linspace(0.0, math.tau, 7)[:-1])
def test_a_slow_swing_is_seen_whatever_its_phase(phase):
    """In three minutes a bank that stands at one limit for half of 115 s passes upwards once or twice."""
    found = oscillation(swinging(lambda t: 5.0 * np.clip(9.0 * np.sin(math.tau * t / 115.0 + phase), -1.0, 1.0)))
    assert found["bank_cycle_period_s"] == pytest.approx(115.0, rel=1e-3)


def test_what_fades_does_not_persist():
    """5 deg that halve every 20 s are 0.6 deg a minute later."""
    found = oscillation(swinging(lambda t: 5.0 * 2.0 ** (-(t - 80.0) / 20.0) * np.sin(math.tau * t / 7.0)))
    assert found["bank_cycle_deg"] < 0.65
    assert found["bank_cycle_period_s"] is None
    assert oscillation(swinging(lambda t: 0.9 * np.sin(t)))["bank_cycle_period_s"] is None
    one_way = oscillation(swinging(lambda t: 0.2 * (t - 80.0)))
    assert one_way["bank_cycle_period_s"] is None  # it passes its middle once


def test_a_flight_that_is_too_short_to_say_has_no_oscillation():
    assert oscillation(swinging(lambda t: 20.0 * np.sin(t), until=50.0))["bank_cycle_deg"] == 0.0


def test_bisection_finds_where_a_metric_passes_its_limit():
    """The bank of a far capture is the bank limit itself."""
    found = find_limit(LINE, "autopilot.bank_limit_deg", 8.0, 20.0, "bank_max_deg", 12.0, within=0.02)
    assert found.below <= 12.0 <= found.above <= 1.02 * found.below
    assert found.below < found.value < found.above


@pytest.mark.parametrize(
    ("low", "high", "metric", "told"),
    [
        (13.0, 20.0, "bank_max_deg", "bank_max_deg exceeds 12 already at autopilot.bank_limit_deg = 13"),
        (8.0, 11.0, "bank_max_deg", "bank_max_deg does not exceed 12 even at autopilot.bank_limit_deg = 11"),
        (20.0, 8.0, "bank_max_deg", "between 0 < low < high"),
        (8.0, 20.0, "bank_maximum", "no metric 'bank_maximum'"),
    ],
)
def test_bisection_says_where_there_is_nothing_to_find(low, high, metric, told):
    with pytest.raises(ScenarioError, match=told):
        find_limit(LINE, "autopilot.bank_limit_deg", low, high, metric, 12.0)


def test_frequency_share_is_of_the_bandwidth_of_the_bank_loop():
    prepared = prepare(read(LINE, {"autopilot": {"frequency_share": 0.1}}))
    assert math.sqrt(G * prepared.law.k1) == pytest.approx(0.1 * prepared.designed.bank_bandwidth)
    assert prepared.law.intercept_speed == pytest.approx(36.0)  # 30 deg at 72 m/s
    same = prepare(read(LINE))
    share = math.sqrt(G * same.law.k1) / same.designed.bank_bandwidth
    assert prepare(read(LINE, {"autopilot": {"frequency_share": share}})).law.k2 == pytest.approx(same.law.k2)


@pytest.mark.parametrize(
    ("autopilot", "told"),
    [
        ({"frequency_share": 0.0}, "frequency_share: must be above 0"),
        ({"frequency_share": 0.1, "law": {"k1_deg_per_m": 0.1}}, "leave them out"),
        ({"frequency_share": 0.1, "kind": "radio_beacon"}, "'frequency_share' sets k1 and k2 of the route law"),
    ],
)
def test_frequency_share_is_refused_beside_gains(autopilot, told):
    with pytest.raises(ScenarioError, match=told):
        prepare(read(LINE, {"autopilot": autopilot}))


def test_the_cycle_that_theory_predicts_is_flown():
    """The bundled scenario, whose check asks for the oscillation; theory within what its issue asks."""
    result = sim.run("limit_cycle")
    (check,) = result.metrics["checks"]
    assert check["passed"]
    cell = {"autopilot.frequency_share": result.scenario.autopilot.frequency_share, "autopilot.bank_limit_deg": 15.0}
    for name, (value,) in study_theory.gain_figures(result.scenario, [cell]).items():
        assert value == pytest.approx(result.metrics["flight"][name], rel=0.1)


def test_theory_of_the_gain_map_lies_between_its_limits():
    scenario = read("gain_map")
    margin, cycles = study_theory.gain_lines(scenario, np.array([0.1, 0.5]), np.array([2.0, 8.0, 20.0]))
    loop = prepare(read("gain_map", {"autopilot.bank_limit_deg": 8.0})).route_loop()
    assert margin.x[1] == pytest.approx(linear_onset(loop, math.radians(8.0)) / loop.bandwidth)
    assert cycles.x[0] == pytest.approx(margin.x[0], rel=1e-3)  # 2 deg are not worth a roll-rate limit of 5 deg/s
    assert margin.x[1] > cycles.x[1] > cycles.x[2]
    shares = (0.8 * cycles.x[1], 1.05 * cycles.x[1])
    cells_about_it = [{"autopilot.frequency_share": share, "autopilot.bank_limit_deg": 8.0} for share in shares]
    said = study_theory.gain_figures(scenario, cells_about_it)
    assert [column[0] for column in said.values()] == [None, None]
    assert said["bank_cycle_deg"][1] == pytest.approx(8.0, rel=0.15)


def test_a_point_mass_has_no_route_loop():
    with pytest.raises(ScenarioError, match="margins need a JSBSim aircraft"):
        prepare(read(LINE)).route_loop()
    assert "sampled loop" not in explain(read(LINE))


def test_explain_tells_of_the_cycle():
    text = explain(read("limit_cycle"))
    assert "limit cycle by theory: caught from" in text
    assert "gain margin" in text
    assert "of the full aileron" not in text
    fast = {"autopilot.frequency_share": 0.55, "autopilot.roll_rate_limit_degps": 90.0}
    assert "slower than that: it asks for 2.2 of the full aileron" in explain(read("limit_cycle", fast))
    assert "every oscillation fades" in explain(read("limit_cycle", {"autopilot.frequency_share": 0.06}))


@pytest.mark.soak
def test_the_page_of_the_gain_map_has_theory_beside_every_flight():
    """Made flights: what is looked at is the page, its lines of theory and its columns."""
    again = run_again("gain_map")
    axes = {"autopilot.frequency_share": [0.1, 0.3, 0.45], "autopilot.bank_limit_deg": [4.0, 8.0]}
    scenario = read("gain_map", {"study": {"theory": "gain", "axes": axes, "show": ["bank_cycle_deg"]}})
    records = [
        {
            "cell": i,
            "sample": 0,
            "flight": 0,
            "values": values,
            "metrics": {"outcome": "completed", "bank_cycle_deg": 50.0 * values["autopilot.frequency_share"]},
            "checks": [],
        }
        for i, values in enumerate(cells(scenario.study.varied))
    ]
    metrics = {"scenario": "gain_map", "seed": 1, "flights": 6, "versions": {}}
    metrics |= study_metrics(scenario.study.varied, records, (), again)
    metrics["predicted"] = study_theory.predicted_figures(scenario, metrics["rows"])
    text = page(scenario, metrics, records, again)
    for told in ("bank_cycle_deg by theory", "bank_cycle_period_s by theory", "theory and flights"):
        assert told in text
    drawn = drawings(text)
    assert any("theory: linear margin" in image and "describing functions, from 300 m" in image for image in drawn)
    columns = metrics["predicted"]
    assert columns["bank_cycle_deg"][:2] == [None, None]  # no cycle at a tenth of the bandwidth
    assert columns["bank_cycle_deg"][-1] == pytest.approx(8.0, rel=0.2)
