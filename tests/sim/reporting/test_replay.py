"""The replay: its data against the flight, its page against a parser, its moves in a browser where there is one."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from autopilot.route import Leg, Route
from sim.observation.record import observe
from sim.reporting.replay import MOST_ESTIMATES, MOST_PLOTS, MOST_STATES, replay
from sim.reporting.tracker_figures.error_curves import shown_trackers
from tests.sim.chromium import CHROMIUM, Browser
from tracking.height_profile import HeightProfile

_trackers = runpy.run_path(str(Path(__file__).with_name("test_report_trackers.py")))  # tests are modules in no package
followed_by, record_of, scenario, written = (
    _trackers[name] for name in ("followed_by", "record_of", "scenario", "written")
)


@pytest.fixture
def flight(make_flight):
    """Northwards for a minute, banking to the right in the second half."""
    time = np.arange(0.0, 60.0, 1 / 30)
    bank = np.where(time < 30, 0.0, np.radians(14.0))
    phase = np.where(time < 30, "final", "glide")
    return make_flight(time, phase, north=-12000.0 + 70.0 * time, height=400.0 - 3.0 * time, bank=bank)


def tracked(flight):
    error = np.full((2, 3), 30.0)
    return {"best": followed_by(flight, error, "autopilot"), "plain": followed_by(flight, -error)}


# -------------------------------------------------------------------------------------------------------- its data


def test_the_replay_passes_through_the_flight(flight):
    data = replay(flight, scenario(), [], {})["flight"]
    assert len(data["t"]) <= MOST_STATES
    time = np.array(data["t"])
    np.testing.assert_allclose(data["x"], -12000.0 + 70.0 * time, atol=0.1)  # rounded to 1 ms and 0.1 m
    np.testing.assert_allclose(data["y"], 0.0)
    np.testing.assert_allclose(data["height"], 400.0 - 3.0 * time, atol=0.1)
    np.testing.assert_allclose(data["flown"], 70.0 * time, atol=1.0)
    np.testing.assert_allclose(data["bank"], np.where(time < 29.999, 0.0, 14.0), atol=0.05)


def test_estimates_and_plots_lie_beside_the_flight_as_made(flight):
    given, tracks = scenario(), tracked(flight)
    data = replay(flight, given, shown_trackers(given, tracks), {"radar": record_of(tracks["best"])})
    best = data["trackers"][0]
    np.testing.assert_allclose(best["y"], 30.0, atol=0.05)  # right is positive
    np.testing.assert_allclose(best["long"], 20.0, atol=0.05)  # twice the sigma of 10 m
    (plots,) = data["plots"]
    np.testing.assert_allclose(plots["y"], 50.0, atol=0.1)
    np.testing.assert_allclose(plots["height"], 300.0, atol=0.1)


@pytest.mark.parametrize("course_deg", [0.0, 90.0, 217.0])
def test_the_map_is_turned_and_never_mirrored(make_flight, course_deg):
    course = np.radians(course_deg)
    along, right = np.array((np.cos(course), np.sin(course))), np.array((-np.sin(course), np.cos(course)))
    route = Route((Leg(tuple(-30000 * along), tuple(0 * along), 70.0, 400.0),))
    place = np.linspace(-20000, -1000, 50)[:, None] * along + 700.0 * right
    flight = make_flight(
        np.arange(50.0), ["final"] * 50, route, north=place[:, 0], east=place[:, 1], heading=np.full(50, course)
    )
    data = replay(flight, scenario(runway={"heading_deg": course_deg}), [], {})
    np.testing.assert_allclose(data["flight"]["y"], 700.0, atol=0.05)
    np.testing.assert_allclose(np.remainder(np.add(data["flight"]["heading"], 180.0), 360.0), 180.0, atol=0.05)
    assert data["flight"]["x"][0] < data["flight"]["x"][-1] < data["runway"][1][0]
    assert data["runway"][1][1] == pytest.approx(0.0, abs=0.1)


def test_long_records_are_thinned(make_flight):
    time = np.arange(0.0, 1500.0, 1 / 30)
    flight = make_flight(time, ["final"] * len(time), north=-12000.0 + 8.0 * time, height=0 * time + 300.0)
    long = followed_by(flight, np.ones((2, 1)), epochs=4000)
    given = scenario()
    data = replay(flight, given, shown_trackers(given, {"best": long}), {"radar": record_of(long)})
    assert len(data["flight"]["t"]) <= MOST_STATES
    assert len(data["trackers"][0]["t"]) <= MOST_ESTIMATES
    assert len(data["plots"][0]["t"]) <= MOST_PLOTS


def test_a_flight_of_one_record_has_no_replay(make_flight):
    assert replay(make_flight(np.zeros(1), ["final"]), scenario(), [], {}) is None


# -------------------------------------------------------------------------------------------------------- its page


@pytest.fixture(scope="module")
def kept():
    return {}


@pytest.fixture
def page(kept, flight, tmp_path_factory):
    """The page about three draws of two trackers, written once."""
    if "page" not in kept:
        given, tracks = scenario(), tracked(flight)
        empty = {"overall": {}, "by_phase": {}, "monitor": {"alarms_per_1000": None, "fault_s": None}}
        trackers = {name: {"kind": given.trackers[name].kind, **empty} for name in tracks}
        kept["folder"] = tmp_path_factory.mktemp("replay")
        records = {"radar": record_of(tracks["best"])}
        kept["page"] = written(kept["folder"], flight, given, tracks, trackers, records)
    return kept["page"]


def test_only_our_own_script_may_run(page):
    policy = next(a["content"] for tag, a in page.tags if a.get("http-equiv") == "Content-Security-Policy")
    own = re.search(r"script-src 'sha256-([^']+)'", policy)[1]
    data, script = page.scripts
    assert own == base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert "unsafe" not in policy.partition("script-src")[2]
    json.loads(data, parse_constant=pytest.fail)  # no NaN, no Infinity
    assert not re.search(r"https?:|fetch|XMLHttpRequest|import\(|eval|innerHTML|localStorage|cookie", script)


def test_every_control_has_a_name_for_those_who_cannot_see_it(page):
    inside = [(tag, a) for tag, a in page.tags if "data-part" in a]
    named = {a["data-part"] for tag, a in inside if tag in ("select", "input", "button")}
    assert named == {"play", "start", "end", "speed", "view", "time"}
    order = [tag for tag, _ in page.tags]
    for index, (tag, a) in enumerate(page.tags):
        if tag in ("select", "input"):
            assert order[index - 1] == "label"
        if tag == "canvas":
            assert a["role"] == "img"
            assert a["aria-label"]


# ----------------------------------------------------------------------------------------------------- in a browser


PART = "document.querySelector('#replay [data-part={}]')".format
PIXELS = f"(() => {{ const c = {PART('plan')}; return c.toDataURL(); }})()"


@pytest.fixture
def browser(page, kept, tmp_path):
    if CHROMIUM is None:
        pytest.skip("no Chromium on the PATH, so the replay was not moved")
    browser = Browser(tmp_path)
    try:
        browser.open(kept["folder"] / "report.html")
        yield browser
    finally:
        browser.close()


def test_in_a_browser_the_replay_moves_and_the_console_is_silent(browser):
    def now():
        return float(browser.value(f"{PART('clock')}.textContent").removesuffix(" s"))

    assert browser.value(f"{PART('plan')}.checkVisibility()")
    first = browser.value(PIXELS)
    assert now() == 0.0
    browser.value(f"{PART('plan')}.focus()")
    browser.press("ArrowRight")
    assert now() == 1.0
    browser.press("ArrowRight", shift=True)
    assert now() == 11.0
    assert browser.value(PIXELS) != first  # the picture moved with the clock
    browser.press("ArrowLeft")
    assert now() == 10.0
    browser.press("End")
    assert now() == pytest.approx(60.0, abs=0.1)
    assert browser.value(f"{PART('phase')}.textContent") == "glide"
    browser.press("Home")
    assert now() == 0.0
    assert browser.value(PIXELS) == first  # one instant, one picture

    browser.press(" ")
    assert browser.value(f"{PART('play')}.textContent") == "Pause"
    browser.value(f"new Promise(done => {{ const look = () => parseFloat({PART('clock')}.textContent) > 1 ? done(1) : "
                  "requestAnimationFrame(look); look(); })")  # fmt: skip
    browser.press(" ")
    assert browser.value(f"{PART('play')}.textContent") == "Play"
    paused = now()
    assert paused > 1.0
    browser.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert now() == paused

    browser.value(f"{PART('time')}.value = 42; {PART('time')}.dispatchEvent(new Event('input'))")
    assert now() == 42.0
    browser.value(f"{PART('view')}.value = '800'; {PART('view')}.dispatchEvent(new Event('change'))")
    close = browser.value(PIXELS)
    cells = browser.value(f"[...{PART('trackers')}.rows].map(row => [...row.cells].map(cell => cell.textContent))")
    assert [row[0] for row in cells] == ["best", "plain"]
    assert [float(row[1]) for row in cells] == pytest.approx([42.4, 42.4], abs=0.3)  # 30 m north, 30 m east, rounded
    assert [row[2] for row in cells] == ["20.0", "20.0"]
    assert [row[3] for row in cells] == ["beyond 4 σ"] * 2
    browser.value(f"{PART('trackers')}.querySelector('input').click()")
    assert browser.value(PIXELS) != close  # a tracker that is switched off is not drawn
    assert browser.value("[...document.images].every(image => image.naturalWidth > 0)")
    assert browser.said == []


@pytest.mark.parametrize("mode", ["none", "mode_c"])
def test_plots_of_a_surveillance_radar_lie_where_the_chart_or_the_transponder_puts_them(make_flight, mode):
    """Below the height of the leg: by that, a plot near the radar would be hundreds of metres off."""
    time = np.arange(0.0, 60.0, 1 / 30)
    flight = make_flight(time, ["final"] * len(time), north=-3000.0 + 70.0 * time, height=0 * time + 1200.0)
    radar = {"kind": "surveillance_radar", "position_m": [0, 1500, 0], "range_sigma_m": 1e-3, "azimuth_sigma_deg": 1e-6}
    given = scenario(sensors={"radar": {**radar, "height": mode}}, trackers={})
    records = observe(flight, given.sensors, 1)
    chart = HeightProfile(((-50_000.0, 0.0, 10_000.0, 0.0),), (0.0, 60_000.0), (1200.0, 1200.0))
    (plots,) = replay(flight, given, [], records, chart)["plots"]
    np.testing.assert_allclose(plots["y"], 0.0, atol=40.0)  # the altimetry errs by 19 m, at a slope of .8
    np.testing.assert_allclose(plots["x"], np.interp(plots["t"], time, flight.state.north), atol=40.0)
