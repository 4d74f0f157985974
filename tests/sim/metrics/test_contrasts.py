"""The paired contrast of two trackers, judged by arithmetic on squares that are given, and on short flights."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy import stats

import sim
from sim.estimation.setup import build
from sim.metrics.contrasts.pairing import contrasts_of_flight, figure
from sim.metrics.contrasts.squares import Squares
from sim.metrics.ensemble.contrasts import contrasts_over_flights
from sim.reporting.text.warnings import contrast_warnings
from sim.scenario.tables import Contrast
from tests.capture import CAPTURE

RADAR = {"kind": "surveillance_radar", "period_s": 4, "position_sigma_m": 50}
LAW, PLAIN = {"kind": "saturated_control"}, {"kind": "kalman"}
PAIR = [{"of": "plain", "against": "law"}]
WATCHED = {
    **CAPTURE,
    "draws": 8,
    "until_s": 60.0,
    "sensors": {"radar": RADAR},
    "trackers": {"plain": PLAIN, "law": LAW},
    "contrasts": PAIR,
}
ASKED = (Contrast("a", "b"),)


def paired(of, against):
    (found,) = contrasts_of_flight(ASKED, {"a": {"overall": {"m": of}}, "b": {"overall": {"m": against}}}).values()
    return found["overall"].get("m")


def test_the_ratio_is_that_of_the_root_mean_squares_and_shared_noise_is_not_in_its_interval():
    noise = np.random.default_rng(1).exponential(1.0, (40, 30)) * np.linspace(1.0, 5.0, 30)
    time = np.arange(40.0)
    for against, narrow in ((noise / 9.0, True), (noise[:, ::-1] / 9.0, False)):
        found = paired(Squares(time, noise), Squares(time, against))
        assert found["ratio"] == pytest.approx(3.0, rel=1e-12)
        assert found["of"] == pytest.approx(math.sqrt(noise.mean()), rel=1e-12)
        assert found["against"] == pytest.approx(found["of"] / 3.0, rel=1e-12)
        assert found["n"] == 30
        assert (found["high"] - found["low"] < 1e-9) is narrow
    assert found["low"] < 2.8
    assert found["high"] > 3.2


def test_the_interval_is_student_s_for_the_logarithm():
    """Beside the one that a plain paired t-test of logarithms gives where every draw's noise is small."""
    rng = np.random.default_rng(2)
    of, against = (1.0 + 1e-4 * rng.standard_normal(12) for _ in range(2))
    found = figure(4.0 * of, against)
    interval = stats.ttest_rel(0.5 * np.log(4.0 * of), 0.5 * np.log(against)).confidence_interval(0.95)
    assert (found["low"], found["high"]) == pytest.approx((math.exp(interval.low), math.exp(interval.high)), rel=1e-7)


@pytest.mark.parametrize("squares", [[4.0], [0.0, 0.0], [1.0, 1e9, 3.0, 0.1]])
def test_two_that_err_alike_are_equal_for_sure(squares):
    found = figure(np.array(squares), np.array(squares))
    assert (found["ratio"], found["low"], found["high"]) == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("of", "against", "ratio", "roots"),
    [
        ([4.0, math.nan], [1.0, 1.0], None, (None, 1.0)),
        ([4.0, 4.0], [1.0, math.inf], None, (2.0, None)),
        ([math.inf, 1.0], [math.inf, 1.0], None, (None, None)),
        ([1e308, 1e308], [1.0, 1.0], None, (None, 1.0)),
        ([4.0, 4.0], [0.0, 0.0], None, (2.0, 0.0)),
        ([0.0, 0.0], [4.0, 4.0], 0.0, (0.0, 2.0)),
        ([4.0], [1.0], 2.0, (2.0, 1.0)),
    ],
)
def test_what_there_is_no_number_for_is_null(of, against, ratio, roots):
    """A lost draw is not left out: that would flatter the tracker that lost it."""
    found = figure(np.array(of), np.array(against))
    assert (found["ratio"], found["low"], found["high"]) == (ratio, None, None)
    assert (found["of"], found["against"]) == roots
    json.dumps(found, allow_nan=False)


def test_only_common_epochs_count_and_of_two_at_one_time_the_last():
    of = Squares(np.array([1.0, 2.0, 2.0, 3.0]), np.array([[5.0], [9.0], [4.0], [16.0]]))
    against = Squares(np.array([2.0, 2.5, 3.0]), np.array([[1.0], [100.0], [4.0]]))
    found = paired(of, against)
    assert (found["of"], found["against"]) == (math.sqrt(10.0), math.sqrt(2.5))
    assert paired(of, Squares(np.array([7.0]), np.array([[1.0]]))) is None
    assert paired(Squares(np.zeros(0), np.zeros((0, 1))), against) is None


def record(of, against):
    overall = {"m": {"ratio": of / against, "low": None, "high": None, "n": 3, "of": of, "against": against}}
    found = {"of": "a", "against": "b", "name": None, "overall": overall, "by_phase": {}, "look_ahead": {}}
    return {"metrics": {"contrasts": {"a/b": found}}}


def test_over_flights_each_counts_once():
    pairs = [(2.0, 1.0), (4.0, 3.0), (8.0, 2.0)]
    crashed = {"metrics": {"outcome": "crashed"}}
    (pooled,) = contrasts_over_flights(ASKED, [crashed, *(record(*pair) for pair in pairs)])
    of, against = (np.array(side) ** 2 for side in zip(*pairs, strict=True))
    assert pooled["overall"]["m"] == figure(of, against)
    assert pooled["overall"]["m"]["ratio"] == pytest.approx(math.sqrt(84.0 / 14.0))
    assert pooled["overall"]["m"]["n"] == 3
    alone = record(2.0, 1.0)
    assert contrasts_over_flights(ASKED, [alone]) == [alone["metrics"]["contrasts"]["a/b"]]
    (none,) = contrasts_over_flights(ASKED, [crashed])
    assert (none["of"], none["overall"], none["by_phase"], none["look_ahead"]) == ("a", {}, {}, {})
    lost = record(1.0, 1.0)
    lost["metrics"]["contrasts"]["a/b"]["overall"]["m"] |= {"of": None, "ratio": None}
    (pooled,) = contrasts_over_flights(ASKED, [record(2.0, 1.0), lost])
    assert (pooled["overall"]["m"]["ratio"], pooled["overall"]["m"]["of"]) == (None, None)


def figures(entry):
    """Every figure of a contrast with its address."""
    for table in ("overall",):
        yield from ((f"{table}.{channel}", found) for channel, found in entry[table].items())
    for table in ("by_phase", "look_ahead"):
        for name, by_channel in entry[table].items():
            yield from ((f"{table}.{name}.{channel}", found) for channel, found in by_channel.items())


def test_equal_trackers_beside_others_in_one_batch_are_exactly_equal():
    trackers = {"plain": LAW, "between": {**LAW, "law": {"k1_factor": 1.3}}, "law": LAW}
    entry = sim.run({**WATCHED, "trackers": trackers}).metrics["contrasts"][0]
    found = dict(figures(entry))
    assert {"overall.position_m", "look_ahead.20_s.position_m"} <= set(found)
    assert {(one["ratio"], one["low"], one["high"]) for one in found.values()} == {(1.0, 1.0, 1.0)}


def test_a_flight_s_contrast_has_the_errors_of_its_trackers_and_checks_read_it():
    name = "contrasts.plain/law"
    asked = {f"{name}.overall.position_m.low": "", f"{name}.overall.position_m.of": "m"}
    asked |= {f"{name}.by_phase.final.cross_track_m.ratio": "", f"{name}.look_ahead.20_s.position_m.high": ""}
    checks = [{"metric": metric, "min": 1e-3} for metric in asked]
    metrics = sim.run({**WATCHED, "checks": checks}).metrics
    (entry,) = metrics["contrasts"]
    for address, one in figures(entry):
        for side in ("of", "against"):
            table, *rest = address.split(".")
            its = metrics["trackers"][entry[side]][table]
            for key in rest:
                its = its[key]
            assert one[side] == pytest.approx(its if table == "look_ahead" else its["rmse"], rel=1e-12)
        assert one["low"] < one["ratio"] < one["high"]
    found = dict(figures(entry))
    for check, (metric, unit) in zip(metrics["checks"], asked.items(), strict=True):
        address, _, key = metric.removeprefix(f"{name}.").rpartition(".")
        assert (check["value"], check["unit"], check["passed"]) == (found[address][key], unit, True)


def test_trackers_with_other_sensors_are_paired_where_both_were_measured():
    """A radar of 4 s against two, of 4 s and 1 s: the epochs of the first, the look-aheads from the same instants."""
    sensors = {"radar": RADAR, "quick": {**RADAR, "period_s": 1}}
    trackers = {"plain": {**PLAIN, "sensors": ["radar"]}, "law": {**LAW, "sensors": ["radar", "quick"]}}
    metrics = sim.run({**WATCHED, "until_s": 100.0, "sensors": sensors, "trackers": trackers}).metrics
    (entry,) = metrics["contrasts"]
    rmse = [metrics["trackers"][name]["overall"]["position_m"]["rmse"] for name in ("plain", "law")]
    assert entry["overall"]["position_m"]["of"] == rmse[0]
    assert entry["overall"]["position_m"]["against"] != rmse[1]
    look = metrics["trackers"]["plain"]["look_ahead"]["20_s"]["position_m"]
    assert entry["look_ahead"]["20_s"]["position_m"]["of"] == pytest.approx(look, rel=1e-12)


def test_a_tracker_that_never_tracks_costs_a_sentence_and_nothing_else():
    blind = {"kind": "precision_radar", "coverage_m": 10}
    trackers = {"plain": PLAIN | {"sensors": ["radar"]}, "law": LAW | {"sensors": ["blind"]}}
    check = {"metric": "contrasts.plain/law.overall.position_m.low", "min": 1.0}
    sensors = {"radar": RADAR, "blind": blind}
    metrics = sim.run({**WATCHED, "sensors": sensors, "trackers": trackers, "checks": [check]}).metrics
    (entry,) = metrics["contrasts"]
    assert (entry["overall"], entry["by_phase"], entry["look_ahead"]) == ({}, {}, {})
    assert metrics["trackers"]["plain"]["overall"]
    said = "contrast of 'plain' against 'law': 'law' never tracked the aircraft, so there is nothing to compare"
    assert metrics["warnings"].count(said) == 1
    assert (metrics["checks"][0]["value"], metrics["checks"][0]["passed"]) == (None, False)


def test_sentences_about_contrasts_without_figures():
    entry = contrasts_of_flight(ASKED, {})["a/b"]
    tracking = {"overall": {"m": {"rmse": 1.0}}}
    (said,) = contrast_warnings([entry], {"a": tracking, "b": tracking})
    assert said.startswith("contrast of 'a' against 'b': at no epoch are both measured")
    entry = contrasts_of_flight(ASKED, {k: {"overall": {"m": Squares(np.zeros(1), v)}} for k, v in (
        ("a", np.array([[np.inf]])), ("b", np.ones((1, 1)))
    )})["a/b"]  # fmt: skip
    (said,) = contrast_warnings([entry], {"a": tracking, "b": tracking})
    assert said == "contrast of 'a' against 'b': errors of 'a' are not finite, so there is no ratio"


UNKNOWN = {"of": "plane", "against": "law"}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"contrasts": [UNKNOWN]}, "[[contrasts]] entry 0 of: no tracker 'plane'; did you mean 'plain'?"),
        (
            {"contrasts": [{"of": "law", "against": "law"}]},
            "[[contrasts]] entry 0 a contrast needs two trackers, and 'law' is one: give the other its own name",
        ),
        (
            {"contrasts": [*PAIR, {**PAIR[0], "name": "again"}]},
            "[[contrasts]] entry 1: 'plain' against 'law' is entry 0 already",
        ),
        (
            {"contrasts": [{**PAIR[0], "name": "a\nb"}]},
            "[[contrasts]] entry 0 the name of the contrast of 'plain' must be plain text on one line",
        ),
        (
            {"checks": [{"metric": "contrasts.plain/lav.overall.position_m.low", "min": 1}]},
            "[[checks]] entry 0 ('contrasts.plain/lav.overall.position_m.low') metric: no contrast 'plain/lav'; "
            "did you mean 'plain/law'?",
        ),
        (
            {"checks": [{"metric": "contrasts.plain/law.overall.position_m.low", "min": 1}], "contrasts": []},
            "[[checks]] entry 0 ('contrasts.plain/law.overall.position_m.low') metric: no contrast 'plain/law'; "
            "the scenario has no [[contrasts]]",
        ),
        (
            {"checks": [{"metric": "contrasts.plain/law.overall.positoin_m.low", "min": 1}]},
            "check of 'contrasts.plain/law.overall.positoin_m.low': no such figure; "
            "did you mean 'contrasts.plain/law.overall.position_m.ratio'?",
        ),
    ],
)
def test_a_fault_is_one_sentence(changes, said):
    with pytest.raises(sim.ScenarioError) as caught:
        sim.run({**WATCHED, "until_s": 10.0, "draws": 2, **changes})
    assert str(caught.value).removeprefix("scenario: ").removeprefix("capture: ") == said


def test_names_are_looked_at_where_one_flight_is_flown_and_the_caller_s_count():
    with pytest.raises(sim.ScenarioError, match="no tracker 'plane'"):
        sim.run({**WATCHED, "contrasts": [UNKNOWN]}, flight=0)
    short = sim.read({**WATCHED, "until_s": 20.0, "contrasts": [{"of": "mine", "against": "plain"}]})
    own, _ = build(sim.prepare(short), "plain", short.trackers["plain"])
    (entry,) = sim.run(short, trackers={"mine": own}).metrics["contrasts"]
    assert (entry["overall"]["position_m"]["ratio"], entry["overall"]["position_m"]["n"]) == (1.0, 8)
