"""The tracker half of the report, judged by arithmetic on tracks that were made by hand."""

from __future__ import annotations

import json
import re
import runpy
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from aircraft.state import AircraftState
from sim.estimation.tracked.outcome import Tracked
from sim.metrics.conformance import MISMATCHED
from sim.metrics.error_curves import FEW_WINDOWS, error_curves, windows
from sim.metrics.flight import flight_metrics
from sim.metrics.tracker import plot_errors, tracker_errors
from sim.observation.record import SensorRecord
from sim.observation.sensors.precision_radar import PrecisionRadar
from sim.observation.sensors.surveillance_radar import SurveillanceRadar
from sim.reporting.drawing.marks import Points
from sim.reporting.figures import style
from sim.reporting.replay import ellipse
from sim.reporting.run_page import Seen, write
from sim.reporting.text.best_tracker import best_tracker, leading
from sim.reporting.text.tracker_tables import tracker_tables
from sim.reporting.tracker_figures.charts import error_charts
from sim.reporting.tracker_figures.error_curves import shown_trackers
from sim.reporting.tracker_figures.model_probabilities import anomaly_strip, mode_names
from sim.reporting.tracker_figures.path_bound import path_bound
from sim.reporting.tracker_figures.tracking_errors import azimuth_norm, containment, error_over_time
from sim.scenario.reading import read
from tests.sim import one_flight
from tests.sim.drawn import marks
from tracking.measurement import LinearMeasurement
from tracking.motion import CoordinatedTurn, ScheduledTurn
from tracking.track import Measurements, Track
from tracking.trackers.imm import InteractingMultipleModel, ModelSet, improved_set, published_set
from tracking.trackers.imm_published import PublishedModels
from tracking.trackers.switching_noise import SwitchingNoise

_page = runpy.run_path(str(Path(__file__).with_name("test_report_page.py")))  # tests are modules without a package
EVIL, LARGEST, LAW, Page = (_page[name] for name in ("EVIL", "LARGEST", "LAW", "Page"))

POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
CHANNELS = ("north", "north_rate", "east", "east_rate")
KINDS = {"best": "saturated_control", "twin": "saturated_control", "plain": "imm"}
"""Names and kinds of the trackers of most tests; ``twin`` assumes a mismatched law."""


def scenario(trackers=KINDS, **tables):
    told = {name: {"kind": kind, "sensors": ["radar"]} for name, kind in trackers.items()}
    if "twin" in told:
        told["twin"]["law"] = {"k1_factor": 1.3}
    tables = {"sensors": {"radar": {"kind": "precision_radar"}}, "trackers": told} | tables
    return read({"name": "tested", **tables})


@pytest.fixture
def flight(make_flight):
    """Northwards down a line through the threshold, 60 s in two phases."""
    time = np.arange(0.0, 60.0, 1 / 30)
    north = -12000.0 + 70.0 * time
    return make_flight(time, np.where(time < 30, "final", "glide"), north=north, height=300.0 + 0 * time)


def at(north, east):
    """The state of an aircraft at 300 m; nothing else of it is asked."""
    still = AircraftState(*np.zeros((len(AircraftState._fields), len(north))))
    return still._replace(north=north, east=np.full(len(north), east), height=np.full(len(north), 300.0))


def followed_by(flight, errors, law_from=None, sigma=10.0, seen=None, probabilities=None, epochs=40):
    """A track whose errors (2, draws) or (k, 2, draws), north and east, are given, with plots 50 m to the right."""
    errors = np.asarray(errors, float)
    errors = np.broadcast_to(errors, (epochs, *errors.shape[-2:]))
    draws = errors.shape[2]
    time = np.linspace(1.0, 59.0, epochs)
    mean = np.zeros((epochs, 4, draws))
    mean[:, 0] = (-12000.0 + 70.0 * time)[:, None] + errors[:, 0]
    mean[:, 2] = errors[:, 1]
    cov = np.broadcast_to(np.diag([sigma, 1.0, sigma, 1.0])[..., None] ** 2, (epochs, 4, 4, 1)).copy()
    white = np.ones((epochs, 3, draws))
    track = Track(
        CHANNELS, time, mean, cov, white, np.full((epochs, draws), 3.0), np.zeros((epochs, draws)), probabilities
    )
    z = np.full((epochs, 3, draws), np.nan)
    seen = np.ones(epochs, bool) if seen is None else seen
    radar = scenario().sensors["radar"]
    z[seen] = radar.truth(at(-12000.0 + 70.0 * time, 50.0)).T[seen][:, :, None]
    names = tuple(f"radar.{channel}" for channel in radar.channels)
    measured = Measurements(names, time, time, z, np.broadcast_to(np.eye(3)[..., None], (epochs, 3, 3, 1)))
    return judged(flight, {"radar": radar}, track, measured, law_from)


def judged(flight, sensors, track, measured, law_from=None, tracker=None):
    """A track compared with the flight, as a run leaves it."""
    plots = plot_errors(flight, sensors, 400.0, measured)
    with np.errstate(invalid="ignore", divide="ignore"):
        curves = error_curves(flight, sensors, track, tracker_errors(flight, sensors, track, plots))
    return Tracked(tracker, law_from, measured, track, curves)


def record_of(tracked):
    m = tracked.measurements
    return SensorRecord(("range", "azimuth", "elevation"), m.time, m.arrival, m.z, m.R[..., 0])


def summaries(given, rmse, **more):
    """As in metrics.json, of trackers with a cross-track RMSE each; raw is 50 m."""

    def figures(value):
        return {
            "cross_track_m": {"rmse": value, "low": 0.9 * value, "high": 1.1 * value, "raw": 50.0, "gain": 50.0 / value}
        }

    return {
        name: {"kind": given.trackers[name].kind, "law_from": None, "overall": figures(value), "lost_fraction": 0.0,
               "by_phase": {phase: figures(value) for phase in ("final", "glide")}, "anees": 1.0, "anees_low": 0.9,
               "monitor": {"alarms_per_1000": 0.0, "fault_s": None},
               "anees_high": 1.1, "anis": 1.0} | more.get(name, {})
        for name, value in rmse.items()
    }  # fmt: skip


def written(tmp_path, flight, given, tracked, trackers, records=None, **more):
    figures = flight_metrics(flight, given.runway, given.autopilot.bank_limit)
    checks = one_flight.judged(given.checks, flight, given.runway, figures)
    metrics = {"flight": figures, "checks": checks, "seed": 1, "draws": 2, "trackers": trackers} | more
    seen = Seen(0, flight, records or {}, tracked, figures, trackers)
    path = write(tmp_path / "report.html", scenario=given, law=LAW, metrics=metrics, versions={}, flights=[seen])
    return Page(path.read_text(encoding="utf-8"))


# ------------------------------------------------------------------------------------------------- curves by arithmetic


def test_curves_are_the_arithmetic_of_their_errors(flight):
    given = scenario()
    one, = shown_trackers(given, {"best": followed_by(flight, [[3.0, -3.0], [4.0, -4.0]], sigma=5.0)})  # fmt: skip
    position, across = one.curves.channels["position_m"], one.curves.channels["cross_track_m"]
    np.testing.assert_allclose(position.rmse, 5.0, rtol=1e-9)
    np.testing.assert_allclose(position.sigma, 5.0 * np.sqrt(2), rtol=1e-12)
    np.testing.assert_allclose(position.anees, 25.0 / 25.0 / 2, rtol=1e-9)
    np.testing.assert_allclose(across.rmse, 4.0, rtol=1e-9)
    np.testing.assert_allclose((across.low + across.high) / 2, 0.0, atol=1e-9)
    np.testing.assert_allclose(across.raw, 50.0, rtol=1e-6)  # plots lie 50 m to the right
    np.testing.assert_allclose(across.of_draws, 16.0, rtol=1e-9)
    np.testing.assert_allclose(one.curves.nis, 1.0)  # 3 per three components
    np.testing.assert_allclose(one.curves.path.place[:, 1], 4.0 * 0 + 4.0)  # draw 0


def test_before_its_first_plot_a_track_is_not_shown(flight):
    seen = np.arange(40) >= 15
    one, = shown_trackers(scenario(), {"best": followed_by(flight, np.ones((2, 3)), seen=seen)})  # fmt: skip
    assert one.curves.time[0] == pytest.approx(one.curves.path.time[15])
    assert len(one.curves.channels["cross_track_m"].rmse) == len(one.curves.time) == 25
    assert np.isnan(one.curves.path.place[:15]).all()
    assert np.isfinite(one.curves.path.place[15:]).all()


def test_few_draws_are_pooled_over_windows_without_losing_an_error(flight):
    errors = noisy(10.0, 4, 1)[np.zeros(4000, int)] * np.random.default_rng(5).normal(size=(4000, 1, 1))
    one, = shown_trackers(scenario(), {"best": followed_by(flight, errors, epochs=4000)})  # fmt: skip
    curves = one.curves.channels["cross_track_m"]
    assert len(curves.rmse) <= FEW_WINDOWS
    lengths = [b - a for a, b in windows(one.curves.path.time, 0, flight, 1)]
    assert sum(lengths) == 4000
    assert np.average(curves.rmse**2, weights=lengths) == pytest.approx(float(np.mean(errors[:, 1] ** 2)), rel=1e-9)
    first = errors[: lengths[0], 1]
    assert (curves.low[0], curves.high[0]) == pytest.approx(tuple(np.percentile(first, (2.5, 97.5))), rel=1e-6)


def test_twins_share_a_colour_and_the_wrong_law_is_dashed(flight):
    error = np.ones((2, 2))
    tracked = {name: followed_by(flight, error, origin) for name, origin in
               (("best", "autopilot"), ("twin", "told wrong"), ("plain", None))}  # fmt: skip
    best, twin, plain = shown_trackers(scenario(), tracked)
    assert best.look["colour"] == twin.look["colour"] != plain.look["colour"]
    assert best.look["dashes"] == plain.look["dashes"] != twin.look["dashes"]


def test_no_two_trackers_look_alike(flight):
    """Three of one kind have three colours, three mismatched twins three ways to be dashed, the eleventh a colour's
    second use dashed differently from all mismatched ones."""
    told = {f"s{k}": "saturated_control" for k in range(6)} | {f"i{k}": "imm" for k in range(8)}
    given = scenario(told)
    wrong = ("s3", "s4", "s5")
    tracked = {name: followed_by(flight, np.ones((2, 2)), "told wrong" if name in wrong else None) for name in told}
    looks = {one.name: (one.look["colour"], one.look["dashes"]) for one in shown_trackers(given, tracked)}
    assert len(set(looks.values())) == len(told)
    assert len({looks[f"s{k}"][0] for k in range(3)}) == 3
    assert {looks[name][0] for name in wrong} == {looks["s0"][0]}
    assert all(looks[name][1] == style.SOLID for name in list(told)[:3])
    again = looks["i7"]  # the eleventh that is not mismatched
    assert again[0] == looks["s0"][0]
    assert again[1] not in (style.SOLID, *style.DASHES)


def test_ellipses_agree_with_eigenvectors():
    factor = np.random.default_rng(3).normal(size=(50, 2, 2))
    cov = factor @ factor.transpose(0, 2, 1)
    long, short, direction = ellipse(cov)
    values, vectors = np.linalg.eigh(cov)
    np.testing.assert_allclose(np.stack((short, long), 1) ** 2, values, rtol=1e-7, atol=1e-12)
    along = np.abs(vectors[:, 0, 1] * np.cos(direction) + vectors[:, 1, 1] * np.sin(direction))
    np.testing.assert_allclose(along, 1.0, rtol=1e-9)


def test_the_bound_is_that_of_one_least_squares_fit(flight):
    """Without process noise the recursion is the fit of place and velocity to all plots at once."""
    time = np.arange(1.0, 20.0, 4.0)
    z = np.zeros((len(time), 2, 3))
    R = np.broadcast_to(np.diag((40.0, 30.0)) ** 2, (len(time), 2, 2))
    sensor = SurveillanceRadar(position_sigma=40.0)
    bound = path_bound(flight, {"radar": sensor}, {"radar": SensorRecord(("north", "east"), time, time, z, R)})
    since = time - time[0]
    for sigma, row in ((40.0, 0), (30.0, 1)):
        design = np.stack((np.ones_like(since), since), axis=1) / sigma
        fit = np.linalg.inv(design.T @ design + np.diag((100.0**-2, 5.0**-2)))
        last = np.array((1.0, since[-1]))
        variance = last @ fit @ last
        if row == 1:
            assert bound.cross_track[-1] == pytest.approx(np.sqrt(variance), rel=1e-9)  # the leg runs north
        else:
            along = bound.position[-1] ** 2 - bound.cross_track[-1] ** 2
            assert along == pytest.approx(variance, rel=1e-9)
    assert path_bound(flight, {}, {}) is None


def test_the_norm_is_what_the_radar_s_accuracy_is_made_of():
    slant = np.array((500.0, 1500.0, 1501.0, 16700.0))
    sigma = PrecisionRadar().sigmas(slant, np.zeros(4), np.zeros(4))[1]
    np.testing.assert_allclose(azimuth_norm(slant), 2 * sigma * slant, rtol=1e-12)
    np.testing.assert_allclose(azimuth_norm(slant), (9.0, 9.0, 9.006, 100.2))


def test_containment_counts_the_epochs_within_the_norm(flight):
    inside, outside = np.full((2, 4), 5.0), np.full((2, 4), 500.0)
    tracked = {"best": followed_by(flight, inside), "plain": followed_by(flight, outside)}
    _, said = containment(flight, scenario(), shown_trackers(scenario(), tracked))
    assert said == "best 100 %; plain 0 %"
    assert containment(flight, scenario(sensors={}, trackers={}), []) is None


def test_modes_are_named_in_the_order_of_the_models():
    turns = [m for m in improved_set().models if isinstance(m, ScheduledTurn)]
    names = mode_names(InteractingMultipleModel(POSITION), len(improved_set().models))
    assert [name for name in names if "turn" in name] == ["right turn" if m.bank > 0 else "left turn" for m in turns]
    assert names.index("right turn") == improved_set().models.index(turns[0])
    published = published_set().models
    left = sorted((m for m in published if isinstance(m, CoordinatedTurn)), key=lambda m: abs(m.turn_rate))
    names = mode_names(PublishedModels(POSITION), len(published))
    assert [names[published.index(m)] for m in left] == ["slow left turn", "fast left turn"]
    assert mode_names(SwitchingNoise(("mls.elevation",)), 2) == ["noise × 1", "noise × 30"]
    assert mode_names(None, 2) == ["model 1", "model 2"]
    unnamed = ModelSet(published, published_set().switching, published_set().probabilities)
    assert mode_names(InteractingMultipleModel(POSITION, unnamed), 3) == ["model 1", "model 2", "model 3"]


# -------------------------------------------------------------------------------------------------------- who won


def noisy(size, seed, draws=60):
    return size * np.random.default_rng(seed).normal(size=(40, 2, draws))


def told(flight, sizes, law_from, short=False, **more):
    given = scenario()
    tracked = {name: followed_by(flight, noisy(size, 1), law_from.get(name)) for name, size in sizes.items()}
    followed = shown_trackers(given, tracked)
    rmse = {one.name: float(np.sqrt(one.curves.channels["cross_track_m"].of_draws.mean())) for one in followed}
    return best_tracker(flight, summaries(given, rmse, **more), followed, short)


LAWS = {"best": "autopilot", "twin": "told wrong"}


def test_the_winner_is_named_with_its_lead_and_its_reason(flight):
    said = told(flight, {"plain": 30.0, "twin": 20.0, "best": 10.0}, LAWS)
    assert said.startswith("Of 3 trackers of the same measurements best was best across track with ")
    assert "5.0 times better than the raw measurements (50.0" in said
    assert "next is twin with 2.00 times the error" in said
    assert "knowing a law is worth a factor of 3.00 over plain, the best without one" in said
    assert "with the mismatched law it has 2.00 times the error" in said
    assert said.count(". ") == 0  # one sentence


def test_a_mismatched_law_never_wins(flight):
    """Its errors are half those of the tracker with the law that flies, and it is told as a fault of that one."""
    said = told(flight, {"twin": 10.0, "best": 20.0, "plain": 30.0}, LAWS)
    assert said.startswith("Of 3 trackers of the same measurements best was best across track with 19.")
    assert "yet twin has 0.50 times the error although its law is mismatched" in said
    assert "next is plain with 1.50 times the error" in said
    short = told(flight, {"twin": 10.0, "best": 20.0}, LAWS, short=True)
    assert "best was best" in short
    assert "yet twin has 0.50 times the error" in short
    assert "knowing a law" not in short


def test_a_lead_within_the_noise_is_no_lead(flight):
    given, errors = scenario(), noisy(10.0, 1)
    tracked = {
        "best": followed_by(flight, errors, "autopilot"),
        "twin": followed_by(flight, noisy(10.0, 2), "told wrong"),
    }
    followed = shown_trackers(given, tracked)
    rmse = {one.name: float(np.sqrt(one.curves.channels["cross_track_m"].of_draws.mean())) for one in followed}
    said = best_tracker(flight, summaries(given, rmse), followed)
    assert "is as good within the noise" in said
    assert "makes no difference to it" in said
    assert "next is" not in said


def test_a_tracker_without_a_law_may_win(flight):
    said = told(flight, {"plain": 10.0, "best": 20.0}, LAWS)
    assert "the best that assumes a law, best, has 2.00 times the error" in said


def test_a_winner_s_faults_are_told(flight):
    faults = {"best": {"anees": 3.0, "anees_low": 2.8, "lost_fraction": 0.02}}
    said = told(flight, {"plain": 30.0, "best": 10.0}, LAWS, **faults)
    assert "too sure of itself (ANEES 3.0)" in said
    assert "it lost 2.0 % of the draws" in said
    assert "worse than the raw measurements" in told(flight, {"best": 80.0}, LAWS)


def test_a_tracker_that_loses_draws_does_not_win_while_another_holds(flight):
    lost = {"best": {"lost_fraction": 0.25}}
    said = told(flight, {"plain": 30.0, "best": 10.0}, LAWS, **lost)
    assert said.startswith("Of 2 trackers of the same measurements plain was best across track")
    assert "yet best has 0.33 times the error although it loses 25.0 % of the draws" in said
    assert told(flight, {"best": 10.0}, LAWS, **lost).startswith("best tracked across track")


def test_nobody_wins_where_nothing_was_tracked(flight):
    assert best_tracker(flight, {}, []) == ""


# ------------------------------------------------------------------------------------------------------- the page


def test_all_figures_of_the_trackers_are_there(flight, tmp_path):
    given = scenario()
    beliefs = np.full((40, 4, 2), 0.25)
    tracked = {
        "best": followed_by(flight, noisy(10.0, 1, 2), "autopilot"),
        "twin": followed_by(flight, noisy(20.0, 1, 2), "told wrong"),
        "plain": followed_by(flight, noisy(30.0, 1, 2), probabilities=beliefs),
    }
    ahead = {"20_s": {"position_m": {"rmse": 40.0}}, "60_s": {"position_m": {"rmse": 90.0}}}
    trackers = summaries(given, {"best": 10.0, "twin": 20.0, "plain": 30.0}, best={"look_ahead": ahead})
    page = written(tmp_path, flight, given, tracked, trackers, {"radar": record_of(tracked["best"])})
    titles = page.titles()
    wanted = [
        "Error over time", "Error by phase", "Does each tracker know how good it is?", "Consistency over time",
        "Estimates in plan", "Containment against the radar's azimuth norm", "Look-ahead", "Model probabilities",
        "Does each tracker still follow?",
    ]  # fmt: skip
    assert [title for title in titles if title in wanted] == wanted
    assert page.faults == []
    assert "Of 3 trackers of the same measurements" in page.text.partition("flight time")[0]  # the first screen
    for image in page.drawings:
        ElementTree.fromstring(image)
        assert not re.search(r"\bnan\b", image)
    assert (tmp_path / "report.html").stat().st_size < LARGEST


def test_a_tracker_that_diverged_is_a_result(flight, tmp_path):
    given, errors = scenario(), noisy(10.0, 1, 2)
    errors[20:] = np.inf
    errors[30:] = np.nan
    tracked = {"best": followed_by(flight, errors, "autopilot"), "plain": followed_by(flight, noisy(1.0, 1, 2))}
    trackers = summaries(
        given, {"best": 10.0, "plain": 1.0}, best={"overall": {}, "by_phase": {}, "lost_fraction": 1.0}
    )
    page = written(tmp_path, flight, given, tracked, trackers)
    assert not re.search(r"\bnan\b|\binf\b|None", page.text)
    for image in page.drawings:
        assert not re.search(r"\b(nan|inf)\b", image)
    best = next(t for t in json.loads(page.scripts[0])["trackers"] if t["name"] == "best")
    assert best["x"][:2] != [None, None]
    assert best["x"][-1] is None


def test_the_name_of_a_tracker_stays_text(flight, tmp_path):
    given = scenario()
    tracked = {EVIL: followed_by(flight, noisy(10.0, 1, 2), EVIL)}
    trackers = {EVIL: summaries(given, {"best": 10.0})["best"] | {"kind": EVIL, "law_from": EVIL}}
    page = written(tmp_path, flight, given, tracked, trackers, {"radar": record_of(tracked[EVIL])})
    assert [a.get("type") for tag, a in page.tags if tag == "script"] == ["application/json", None]
    assert [a for _, a in page.tags if any(key.startswith("on") for key in a)] == []
    assert page.faults == []
    assert "<" not in page.scripts[0]
    assert json.loads(page.scripts[0])["trackers"][0]["name"].count("<script>") == 1
    for image in page.drawings:
        assert not any(node.tag.endswith("}script") for node in ElementTree.fromstring(image).iter())


def test_one_draw_has_figures_too(flight):
    given = scenario()
    tracked = {name: followed_by(flight, noisy(10.0, seed, 1)) for seed, name in enumerate(("best", "plain"))}
    followed = shown_trackers(given, tracked)
    trackers = summaries(given, {"best": 10.0, "plain": 9.0})
    charts = error_charts(given, flight, trackers, followed, {})
    assert {"Error over time", "Does each tracker know how good it is?"} <= {chart.title for chart in charts}
    assert "within the noise" not in best_tracker(flight, trackers, followed)  # one draw says nothing about the noise


def test_the_strip_shows_which_samples_were_taken_for_anomalous(flight):
    given = scenario(
        trackers={}, sensors={"mls": {"kind": "mls"}},
    )  # fmt: skip
    given = read({**given.tables, "trackers": {"two": {"kind": "switching_noise", "sensors": ["mls"]}}})
    time = np.linspace(1.0, 59.0, 40)
    sensor = given.sensors["mls"]
    exact = sensor.truth(at(-12000.0 + 70.0 * time, 0.0))[sensor.channels.index("elevation")]
    odd = np.arange(40) % 4 == 0
    z = (exact + np.where(odd, np.radians(1.0), np.radians(0.01)))[:, None, None]
    R = np.full((40, 1, 1, 1), np.radians(0.06) ** 2)
    weights = np.where(odd, 0.9, 0.1)
    track = Track(
        ("mls.elevation", "mls.elevation_rate"), time, np.stack((exact, 0 * exact), 1)[..., None],
        np.broadcast_to(1e-6 * np.eye(2)[..., None], (40, 2, 2, 1)), np.ones((40, 1, 1)), np.ones((40, 1)),
        np.zeros((40, 1)), np.stack((1 - weights, weights), 1)[..., None],
    )  # fmt: skip
    tracked = {"two": judged(flight, given.sensors, track, Measurements(("mls.elevation",), time, time, z, R))}
    figure = anomaly_strip(flight, given, tracked, {"two": ["noise × 1", "noise × 30"]})
    nominal, anomalous = marks(figure.panels[1], Points)
    np.testing.assert_allclose(anomalous.y, 1.0, rtol=1e-6)
    np.testing.assert_allclose(nominal.y, 0.01, rtol=1e-6)
    one, = shown_trackers(given, tracked)  # fmt: skip
    np.testing.assert_allclose(one.curves.path.height, 300.0, atol=1e-6)  # an angle is shown as a height


def test_a_mismatched_law_is_drawn_dashed(flight):
    tracked = {
        "best": followed_by(flight, noisy(9.0, 1), "autopilot"),
        "twin": followed_by(flight, noisy(9.0, 2), "told wrong"),
    }
    panel = error_over_time(flight, shown_trackers(scenario(), tracked), None).panels[1]
    dashed = {line.label: bool(line.dashes) for line in panel.lines if line.label in ("best", "twin")}
    assert dashed == {"best": False, "twin": True}
    assert panel.y.scale.kind == "log"


def test_tables_mark_the_best_that_keep_the_target_and_put_twins_beside_their_originals():
    given = scenario()
    wrong = {"law_from": MISMATCHED}
    rmse = {"best": 12.0, "plain": 9.0, "twin": 30.0}
    tables = tracker_tables(summaries(given, rmse, twin=wrong, plain={"lost_fraction": 0.5, "anees": 0.98}))
    errors, consistency = tables[:2]
    assert [row[0] for row in errors.rows] == ["best", "twin", "plain"]
    assert errors.lost == consistency.lost == {2}
    assert {errors.header[column] for row, column in errors.best if row == 0} == {"RMSE", "gain", "final", "glide"}
    assert {row for row, _ in errors.best} == {0}  # 9 m of the one that is lost count for nothing
    assert {consistency.header[column] for _, column in consistency.best} == set()  # two alike


def test_the_first_screen_shows_the_best_tracker_and_the_next_of_another_kind(flight):
    given = scenario()
    tracked = {
        "best": followed_by(flight, np.full((2, 2), 1.0)),
        "twin": followed_by(flight, np.full((2, 2), 0.5), MISMATCHED),
        "plain": followed_by(flight, np.full((2, 2), 2.0)),
    }
    figures = summaries(given, {"best": 1.0, "twin": 0.5, "plain": 2.0})
    shown = shown_trackers(given, tracked)
    assert [one.name for one in leading(flight, figures, shown)] == ["best", "plain"]
    figures["plain"]["lost_fraction"] = 0.5
    assert [one.name for one in leading(flight, figures, shown)] == ["best"]
