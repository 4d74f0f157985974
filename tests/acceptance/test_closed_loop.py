"""The loop closed through a tracker on JSBSim: talk-down under a precision radar, and a glide path coupled to an MLS.

Every flight has noise of its own. Nothing was tuned on these seeds, nor for these figures at all: all trackers have
their default parameters.
"""

from __future__ import annotations

from collections import Counter
from functools import cache

import numpy as np
import pytest

import sim
from autopilot.modes.lateral_navigation import LateralNavigation
from sim.estimation.tracking_run import track
from sim.experiment import fly
from sim.flight.preparation import prepare
from sim.metrics.flight import flight_metrics
from sim.metrics.navigation import navigation_quality
from sim.observation.record import observe
from sim.scenario.reading import read
from tests.tracking.law_truth import CROSS_TRACK, LINE, NOMINAL, noise_factor
from tracking.gaussian import Gaussian
from tracking.intervals import mean_interval, proportion
from tracking.motion import GRAVITY
from tracking.trackers.saturated_control import SaturatedControl

pytestmark = pytest.mark.acceptance
SEED = 3001
# 80 of 80 leave at least 0.95 at the lower end of the interval
FLIGHTS = {"saturated_control": 80, "imm": 12, "linear_feedback": 4, "truth": 1}
BOX = 21.0 - 0.5 * 7.9  # m off the centreline that keep the outer main wheel within 21 m


@cache
def approaches(name, navigation, count, *changes):
    """Flights on a tracker (or on the truth) with their figures, among them why they failed, and its consistency."""
    everyone = sim.read(name).tables["trackers"]
    trackers = {} if navigation == "truth" else {navigation: everyone[navigation]}
    overrides = {"seed": SEED, "autopilot.navigation": navigation, "trackers": trackers, "checks": []}
    prepared = prepare(read(name, {**overrides, **dict(changes)}))
    scenario = prepared.scenario
    flown, figures, anees = [], [], []
    for number in range(count):
        one = fly(prepared, number)
        flown.append(one)
        figures.append(flight_metrics(one, scenario.runway, prepared.law.bank_limit))
        if trackers:
            records = observe(one, scenario.sensors, scenario.seed, number, 1)
            tracked, judged = track(prepared, one, records, {}, number)
            anees.append(judged[navigation]["anees"])
            figures[-1]["navigated"] = navigation_quality(prepared, one, tracked[navigation].track, judged[navigation])
    return scenario, flown, figures, anees


def told(interval, digits=2):
    return f"{interval.value:.{digits}f} ({interval.low:.{digits}f} to {interval.high:.{digits}f})"


def spread(figures, name, digits=2):
    """Root mean square and the largest magnitude of a figure over the flights that have it."""
    values = [m[name] for m in figures if m[name] is not None]
    if not values:
        return "n/a"
    return f"{np.sqrt(np.mean(np.square(values))):.{digits}f} rms, {np.abs(values).max():.{digits}f} at most"


def in_box(figure):
    return figure["outcome"] == "landed" and abs(figure["touchdown"]["cross_track_m"]) <= BOX


@pytest.mark.parametrize("navigation", ["saturated_control", "imm", "truth"])
def test_talk_down(row, navigation):
    count = FLIGHTS[navigation]
    scenario, _, figures, anees = approaches("an26_talkdown", navigation, count)
    share = proportion(sum(map(in_box, figures)), count)
    outcomes = dict(Counter(m["outcome"] for m in figures))
    law_aware = navigation == "saturated_control"
    asked = ">= 0.95 at the lower end" if law_aware else "shown"
    row(
        f"talk-down on {navigation}, {count} flights: P(60-823 m, outer wheel within 21 m)",
        asked,
        f"{told(share)}; {outcomes}",
        not law_aware or share.low >= 0.95,
    )
    at = {
        "across at 60 m, m": ("cross_track_at_decision_height_m", "<= 30", 30.0),
        "height error at 60 m, m": ("height_error_at_decision_height_m", "<= 7.5", 7.5),
    }
    for what, (name, limit, largest) in at.items():
        values = [abs(m[name]) for m in figures if m[name] is not None]
        met = bool(values) and max(values) <= largest
        wanted = limit if law_aware else "shown"
        row(f"talk-down on {navigation}: {what}", wanted, spread(figures, name), met or not law_aware)
    for what, name in (
        ("normal acceleration on the glide path, m/s2", "normal_acceleration_rms_final_mps2"),
        ("bank rate on the glide path, deg/s", "bank_rate_rms_final_degps"),
    ):
        row(f"talk-down on {navigation}: {what}", "shown", spread(figures, name, 3), True)
    down = [m["touchdown"] for m in figures if m["outcome"] == "landed"]
    if down:
        along, across = (np.array([t[key] for t in down]) for key in ("past_threshold_m", "cross_track_m"))
        found = (
            f"along {along.mean():.0f} +- {along.std():.1f} ({along.min():.0f} to {along.max():.0f}), "
            f"across {across.mean():+.1f} +- {across.std():.1f} ({across.min():+.1f} to {across.max():+.1f})"
        )
        row(f"talk-down on {navigation}: touchdown, m, mean +- sd", "shown", found, True)
    if anees:
        q = scenario.trackers[navigation].table.get("acceleration_density_m2ps3", 0.1)
        told_q = f", q {q} m2/s3" if law_aware else ""
        row(f"talk-down on {navigation}: ANEES of the position{told_q}", "reported", told(mean_interval(anees)), True)
        late = mean_interval([m["navigated"]["rate_lag_s"] for m in figures])
        tolerated = figures[0]["navigated"]["rate_lag_stood_s"]
        what = f"talk-down on {navigation}: lag of its rate, and what the law tolerates, s"
        row(what, "shown", f"{told(late)}, {tolerated:.1f}", True)
    assert not law_aware or share.value >= 0.95


def test_talk_down_on_the_imm_says_why_it_fails(row):
    """Without the law a turn is noticed seconds late, and later than the law of the aircraft tolerates."""
    count = FLIGHTS["imm"]
    _, _, figures, _ = approaches("an26_talkdown", "imm", count)
    lags = [(m["navigated"]["rate_lag_s"], m["navigated"]["rate_lag_stood_s"]) for m in figures]
    too_late = sum(late > tolerated for late, tolerated in lags)
    row(
        f"talk-down on imm, {count} flights: its rate comes later than the law tolerates",
        "says why",
        f"{too_late} of {count}; first: {figures[0]['navigated']['why']}",
        all(m["navigated"]["why"] for m in figures if m["outcome"] != "landed"),
    )
    assert too_late == count


def test_a_localiser_and_a_dme_lead_into_the_box(row):
    """The densities of the tracker and the lag that the recipe is told, 4 s, were chosen on seeds 1 and 2."""
    count = 24
    _, _, figures, anees = approaches("an26_localiser", "line_of_approach", count)
    share = proportion(sum(map(in_box, figures)), count)
    across, rate = (spread(figures, name) for name in ("cross_track_at_decision_height_m", "bank_rate_rms_final_degps"))
    late = mean_interval([m["navigated"]["rate_lag_s"] for m in figures])
    row(
        f"an26_localiser, 5 m/s across, {count} flights: P(box), across at 60 m, bank rate, lag, ANEES",
        "landed for every seed",
        f"{told(share)} {dict(Counter(m['outcome'] for m in figures))}; {across} m; {rate} deg/s; "
        f"{told(late)} s; {told(mean_interval(anees))}",
        share.value == 1.0,
    )
    assert share.value == 1.0


def test_talk_down_on_the_imm_with_the_law_that_tolerates_its_lag(row):
    """The lag that the recipe is told, 7 s, was chosen on seed 77."""
    count = 24
    _, _, figures, anees = approaches("an26_talkdown_imm", "imm", count)
    share = proportion(sum(map(in_box, figures)), count)
    across, rate = (spread(figures, name) for name in ("cross_track_at_decision_height_m", "bank_rate_rms_final_degps"))
    late = mean_interval([m["navigated"]["rate_lag_s"] for m in figures])
    row(
        f"an26_talkdown_imm, law for a lag of 7 s, {count} flights: P(box), across at 60 m, bank rate, lag, ANEES",
        "shown",
        f"{told(share)} {dict(Counter(m['outcome'] for m in figures))}; {across} m; {rate} deg/s; "
        f"{told(late)} s; {told(mean_interval(anees))}",
        True,
    )
    assert sum(m["outcome"] == "landed" for m in figures) > count / 2


def test_talk_down_on_linear_feedback_fails_and_says_why(row):
    _, _, figures, _ = approaches("an26_talkdown", "linear_feedback", FLIGHTS["linear_feedback"])
    reasons = "; ".join(m["navigated"]["why"] or "" for m in figures)
    landed = sum(map(in_box, figures))
    row(
        "talk-down on linear_feedback: the outcome says why it fails",
        "not landed, with a reason",
        f"{landed} of {len(figures)} in the box; {reasons}",
        landed == 0 and all(m["navigated"]["why"] for m in figures),
    )
    assert landed == 0
    assert all("was lost after" in m["navigated"]["why"] for m in figures)


@pytest.mark.parametrize("density", [0.1, 0.3])
def test_talk_down_in_the_double_integrator(row, density):
    """Flown on this tracker's own estimate the control is known exactly, and the filter is the optimal one."""
    runs, dt, scans, period, sigma = 400, 0.1, 60, 4.0, 100.0
    rng = np.random.default_rng([SEED, round(100 * density)])
    tracker = SaturatedControl(NOMINAL, LINE, CROSS_TRACK, density, dt)
    prior = np.diag((sigma**2, 25.0))
    start = np.array((500.0, 0.0))[:, None] + np.zeros((2, runs))
    x = start + np.sqrt(np.diag(prior))[:, None] * rng.standard_normal((2, runs))
    state, factor, nees = tracker.begin(Gaussian(start, prior[..., None])), noise_factor(density, dt), []
    law: LateralNavigation = NOMINAL
    for _ in range(scans):
        for i in range(round(period / dt)):
            estimate = tracker.estimate(state).mean
            acceleration = GRAVITY * law(LINE.deviation(0.0, estimate))
            x = np.array([x[0] + dt * x[1] + 0.5 * dt**2 * acceleration, x[1] + dt * acceleration])
            x = x + factor @ rng.standard_normal((2, runs))
            last = i == round(period / dt) - 1
            z = x[:1] + sigma * rng.standard_normal((1, runs)) if last else None
            state, _ = tracker.step(state, dt, z, np.array([[[sigma**2]]]) if last else None)
        mean, cov = tracker.estimate(state)
        error = mean - x
        nees.append(np.einsum("in,ij,jn->n", error, np.linalg.inv(cov[..., 0]), error) / 2)
    figure = mean_interval(np.mean(nees, axis=0))
    row(
        f"talk-down on saturated control in the double integrator, q {density}: ANEES of the full state",
        "1.00 +- .10",
        told(figure),
        figure.low >= 0.9 and figure.high <= 1.1,
    )
    assert 0.9 <= figure.value <= 1.1


# ---- glide path coupled to an MLS --------------------------------------------------------------------------------


def activity(flown, first, last):
    """Normal acceleration on the glide path over a stretch of time, m/s2 rms."""
    s = flown.state
    chosen = (s.time >= first) & (s.time < last) & flown.during("glide")
    return float(np.sqrt(np.mean((GRAVITY * (s.load_factor[2][chosen] - 1.0)) ** 2)))


def test_mls_with_independent_anomalies(row):
    count = 4
    _, filtered, figures, _ = approaches("an26_mls_anomalies", "two_hypotheses", count)
    _, plain, worse, _ = approaches("an26_mls_anomalies", "kalman", count)
    _, exact, best, _ = approaches("an26_mls_anomalies", "truth", 1)
    ratios, pairs = [], []
    for one, other in zip(filtered, plain, strict=True):
        start = max(float(f.time[np.argmax(f.during("glide"))]) for f in (one, other)) + 10.0  # past the bend
        stop = min(float(f.time[f.during("glide")][-1]) for f in (one, other))
        pairs.append((activity(one, start, stop), activity(other, start, stop)))
        ratios.append(pairs[-1][0] / pairs[-1][1])
    calm = activity(exact[0], start, stop)
    ratio = mean_interval(ratios)
    told_pairs = "; ".join(f"{a:.3f} against {b:.3f}" for a, b in pairs)
    row(
        "an26_mls_anomalies, calm, 20 %, sigma 30: normal acceleration, two hypotheses / Kalman",
        "<= 1/4",
        f"{told(ratio, 3)}; {told_pairs} m/s2 rms, on the truth {calm:.3f}",
        ratio.high <= 0.25,
    )
    for what, several in (("two hypotheses", figures), ("Kalman", worse), ("truth", best)):
        row(
            f"an26_mls_anomalies on {what}: outcome",
            "shown",
            f"{dict(Counter(m['outcome'] for m in several))}; height error at 60 m "
            f"{spread(several, 'height_error_at_decision_height_m')}; touchdown "
            + ", ".join(f"{m['touchdown']['past_threshold_m']:.0f} m" for m in several if m["touchdown"]),
            True,
        )
    assert ratio.value <= 0.25
    assert all(in_box(m) for m in figures)


@pytest.mark.parametrize("tracker", ["two_hypotheses", "markov"])
def test_mls_with_bursts(row, tracker):
    changes = (("sensors.mls.anomalies", "bursts"), ("sensors.mls.burst_length", 40.0))
    _, flown, figures, _ = approaches("an26_mls_anomalies", tracker, 4, *changes)
    outcomes = dict(Counter(m["outcome"] for m in figures))
    row(
        f"an26_mls_anomalies, bursts of 1 s, on {tracker}: outcome, height error at 60 m, normal acceleration",
        "shown",
        f"{outcomes}; {spread(figures, 'height_error_at_decision_height_m')}; "
        f"{spread(figures, 'normal_acceleration_rms_final_mps2', 3)} m/s2",
        True,
    )
    assert all(one.reason for one in flown)
