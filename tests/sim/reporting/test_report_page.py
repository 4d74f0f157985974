"""The page as a browser takes it: complete in itself, well formed, inert, and good for any flight."""

from __future__ import annotations

import dataclasses
import itertools
import re
import subprocess
import sys
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.modes.radio_beacon import RadioBeacon
from autopilot.route import Leg, Route, pattern_route
from sim.flight.record import Event
from sim.metrics.flight import flight_metrics
from sim.reporting import run_page
from sim.reporting.drawing.marks import Blocks
from sim.reporting.figures import style
from sim.reporting.figures.histories import bank_history
from sim.reporting.figures.phase_portrait import phase_portrait
from sim.reporting.figures.plan_view import plan_view
from sim.reporting.run_page import Seen, write
from sim.scenario.reading import read
from sim.scenario.tables import Runway
from tests.sim.drawn import drawings, marks
from tests.sim.one_flight import judged

LAW = LateralNavigation(0.0025, 0.029, np.radians(15.0), 412.0, 50.0)
LARGEST = 3_000_000  # bytes, what the report may weigh
EVIL = "<script>alert('x')</script><img src=http://example.org/x onerror=alert(1)>\"'&{{ 7 * 7 }}"
CHECKS = [{"metric": "bank_deg", "max": 16.1, "source": "limit 15 deg"}, {"metric": "touchdown.sink_mps", "max": 3.05}]
EACH = [{"flight": k, "metrics": {"outcome": "landed"}, "checks": []} for k in range(4)]
VOID = {"meta", "img", "br", "hr", "link", "input"}


class Page(HTMLParser):
    """What a parser sees: tags with attributes, text, and whether every tag is closed."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.tags, self.open, self.text, self.faults, self.scripts = [], [], "", [], []
        self.drawings = drawings(text)
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.faults.append(tag)

    def handle_data(self, data):
        if self.open[-1:] == ["script"]:
            self.scripts.append(data)
        elif "svg" not in self.open:
            self.text += data

    def titles(self):
        return [a["aria-label"].partition(": ")[0] for tag, a in self.tags if a.get("class") == "drawing"]


def scenario(**tables):
    return read({"name": "tested", "checks": CHECKS, **tables})


def written(tmp_path, flight, law=LAW, given=None, **more):
    given = given or scenario()
    figures = flight_metrics(flight, given.runway, given.autopilot.bank_limit)
    metrics = {
        "flight": figures,
        "checks": judged(given.checks, flight, given.runway, figures),
        "seed": 1,
        "draws": 130,
    } | more
    seen = Seen(0, flight, {}, {}, figures, metrics.get("trackers", {}))
    path = write(
        tmp_path / "report.html", scenario=given, law=law, metrics=metrics,
        versions={"shortfinal": "0.1.0"}, flights=[seen],
    )  # fmt: skip
    return Page(path.read_text(encoding="utf-8"))


def capture(make_flight, seconds=60.0, **signals):
    """A one-leg capture from 300 m: intercept, then final."""
    time = np.arange(0.0, seconds, 1 / 30)
    phase = ["final"] * len(time)
    east = 300.0 * np.exp(-time / 15.0)
    signals = {
        "east": east,
        "velocity_east": -east / 15.0,
        "north": -40000 + 70 * time,
        "height": 400.0 + 0 * time,
    } | signals
    return make_flight(time, phase, **signals)


def landing(make_flight):
    """The last kilometres of an approach down to the first contact."""
    time = np.arange(0.0, 60.0, 1 / 30)
    north = -3000.0 + 58.0 * time
    height = np.maximum((300.0 - north) * np.tan(np.radians(8 / 3)), 1.0)
    phase = np.where(height > 9.0, "glide", "flare")
    wheels = (height <= 1.0).astype(float)
    end = int(np.argmax(wheels)) + 1
    cut = {"north": north[:end], "height": height[:end], "main_wheels": wheels[:end], "velocity_up": np.full(end, -0.7)}
    flight = make_flight(time[:end], phase[:end], **cut, airspeed=np.full(end, 58.0), throttle=np.full(end, 0.4))
    return dataclasses.replace(flight, outcome="landed")


def texts(image):
    return ["".join(node.itertext()) for node in ElementTree.fromstring(image).iter() if node.tag.endswith("}text")]


@pytest.fixture(scope="module")
def kept():
    """What is written once and read by many tests."""
    return {}


@pytest.fixture
def landed(kept, make_flight, tmp_path):
    """The page about a landing."""
    if "page" not in kept:
        kept["page"] = written(tmp_path, landing(make_flight))
        kept["bytes"] = (tmp_path / "report.html").read_bytes()
    return kept["page"]


def test_the_page_needs_nothing_but_itself(landed):
    page = landed
    assert page.faults == []
    assert page.open == []
    links = [value for _, a in page.tags for key, value in a.items() if key in ("src", "href", "action", "data")]
    assert links
    assert all(link.startswith("#") for link in links)
    policy = next(a["content"] for tag, a in page.tags if a.get("http-equiv") == "Content-Security-Policy")
    assert "default-src 'none'" in policy
    assert "img-src" not in policy
    assert len(page.drawings) == len(page.titles()) >= 8


def test_links_inside_the_page_lead_somewhere(make_flight, tmp_path):
    short = make_flight(np.arange(3.0), ["final"] * 3)
    page = written(tmp_path, short, trackers={"t": {"kind": "kalman", "overall": {}, "by_phase": {}}})
    places = {a["id"] for _, a in page.tags if "id" in a}
    assert {a["href"][1:] for tag, a in page.tags if tag == "a"} <= places


def test_the_first_screen_says_what_happened_before_all_else(landed):
    page = landed
    assert "Flare and touchdown" in page.text
    sentence = "m past the threshold, on the centreline, sinking at 0.70 m/s; both checks held."
    assert sentence in page.text
    assert page.text.index(sentence) < page.text.index("Plan view") < page.text.index("flight time")
    assert "Research software, not for operational use" in page.text


def test_the_sources_are_those_of_what_flew(make_flight, tmp_path):
    flight = make_flight(np.arange(3.0), ["final"] * 3)
    own = written(tmp_path, flight, given=scenario(aircraft={"model": "an26"}))
    assert "Antonov An-26" in own.text
    assert "JSBSim integrates the equations of motion" in own.text
    beacon = {"kind": "radio_beacon", "law": {"k3": 6.0, "k4": 1.2, "bearing_limit_deg": 5.0}}
    law = RadioBeacon(6.0, 1.2, np.radians(20.0), np.radians(5.0))
    point = written(tmp_path, flight, law=law, given=scenario(autopilot=beacon))
    assert "JSBSim" not in point.text
    assert "Vasylyev 2003, eq. (5)" in point.text
    assert "Vasylyev 2003, eq. (4)" not in point.text


def test_several_flights_tell_how_all_of_them_ended(make_flight, tmp_path):
    band = {"p5": 0.4, "p50": 0.5, "p95": 0.9}
    summary = {"outcomes": {"go_around": 1, "landed": 19}, "touchdown.sink_mps": band}
    page = written(tmp_path, make_flight(np.arange(3.0), ["final"] * 3), flights=20, flights_summary=summary)
    assert page.text.count("Outcomes of all 20 flights: 19 landed, 1 go around.") == 2
    assert "flight 0" in page.text


def test_a_page_draws_further_flights_while_there_is_room(make_flight, tmp_path, monkeypatch):
    """What does not fit is said to be left out, and nothing is drawn beyond."""
    given, flight = scenario(), capture(make_flight)
    figures = flight_metrics(flight, given.runway, given.autopilot.bank_limit)
    checks = judged(given.checks, flight, given.runway, figures)
    metrics = {
        "flight": figures,
        "checks": checks,
        "seed": 1,
        "flights": 4,
        "flights_summary": {"outcomes": {"landed": 4}},
    }

    def drawn(largest):
        monkeypatch.setattr(run_page, "LARGEST", largest)
        monkeypatch.setattr(run_page, "ROOM", 2_000)
        asked = []
        flights = (asked.append(number) or Seen(number, flight, {}, {}, figures, {}) for number in (2, 0, 1, 3))
        write(
            tmp_path / "r.html", scenario=given, law=LAW, metrics={**metrics, "each_flight": EACH},
            versions={}, flights=flights,
        )  # fmt: skip
        text = (tmp_path / "r.html").read_text()
        return asked, Page(text), len(text)

    whole, page, one = drawn(1)
    assert (whole, page.faults, page.open) == ([2], [], [])
    images = sum(map(len, page.drawings))
    few, page, two = drawn(int(1.5 * images) + len(page.scripts[0]))
    assert (few, page.faults) == ([2, 0], [])
    assert "more figures when it is flown again" in page.text
    assert "This is the worst, flight 2; also drawn: flight 0." in " ".join(page.text.split())
    assert one < two < one + 0.6 * images


def test_whatever_a_scenario_says_stays_text(make_flight, tmp_path):
    given = scenario(checks=[{"metric": "bank_deg", "name": EVIL, "max": 16.1, "source": EVIL}])
    given = dataclasses.replace(given, name=EVIL)
    flight = capture(make_flight)
    flight = dataclasses.replace(flight, events=(Event(0.0, EVIL, EVIL),), outcome="diverged", reason=EVIL)
    tracks = {EVIL: {"kind": EVIL, "law_from": EVIL, "overall": {}, "by_phase": {}}}
    page = written(tmp_path, flight, given=given, trackers=tracks, warnings=[EVIL])
    assert {tag for tag, _ in page.tags} & {"iframe", "object", "link", "base", "form"} == set()
    kinds = [(a.get("type"), a.get("src")) for tag, a in page.tags if tag == "script"]
    assert kinds == [("application/json", None), (None, None)]  # the replay's data and its script
    assert [a for _, a in page.tags if any(key.startswith("on") for key in a)] == []
    assert "img" not in {tag for tag, _ in page.tags}
    assert page.faults == []
    assert page.text.count("{{ 7 * 7 }}") >= 6
    assert "49" not in page.text.replace("49.", "")


def no_final():
    route = pattern_route("right", 400.0, 7000.0, 13800.0, 72.0, 69.0, 300.0, 1.0)
    return {"route": route}


FLIGHTS = {
    "crashed after three records": lambda make: dataclasses.replace(
        make(np.arange(3) / 30, ["go_around"] * 3), outcome="diverged", reason="no longer finite at 0.07 s"
    ),
    "one record": lambda make: make(np.zeros(1), ["final"]),
    "no final leg": lambda make: make(np.arange(0, 90, 1 / 30), ["go_around"] * 2700, **no_final()),
    "one leg, due east": lambda make: make(
        np.arange(90.0),
        ["final"] * 90,
        Route((Leg((0.0, 0.0), (0.0, 40000.0), 70.0, 400.0),)),
        heading=np.full(90, 1.6),
    ),
    "a value missing": lambda make: capture(make, height=np.where(np.arange(1800) < 900, 400.0, np.nan)),
    "all missing but the place": lambda make: make(
        np.arange(9.0),
        ["final"] * 9,
        **dict.fromkeys(("height", "bank", "airspeed", "heading", "flaps"), np.full(9, np.nan)),
    ),
}


@pytest.mark.parametrize("case", FLIGHTS)
def test_any_flight_gives_a_whole_report(make_flight, tmp_path, case):
    page = written(tmp_path, FLIGHTS[case](make_flight))
    assert page.faults == []
    titles = page.titles()
    assert {"Plan view", "Vertical profile", "Bank and its limits", "Phase portrait of the law", "Deviations"} <= set(
        titles
    )
    assert "Flare and touchdown" not in titles
    assert not re.search(r"\bnan\b|\binf\b|None", page.text)
    for image in page.drawings:
        ElementTree.fromstring(image)
        assert not re.search(r"nan|\binf\b", re.sub(r'aria-label="[^"]*"', "", image))


@pytest.mark.soak
def test_half_an_hour_of_noise_stays_below_the_limit(make_flight, tmp_path):
    random = np.random.default_rng(1)
    time = np.arange(0, 1800, 1 / 30)
    noisy = {
        name: random.normal(size=len(time))
        for name in ("bank", "height", "velocity_up", "pitch", "aileron", "elevator")
    }
    noisy |= {"north": 70 * time, "airspeed": 70 + random.normal(size=len(time)), "throttle": random.random(len(time))}
    flight = make_flight(
        time, random.permutation(["final", "glide", "flare"] * 18000), **noisy
    )  # a new phase each record
    written(tmp_path, flight)
    assert (tmp_path / "report.html").stat().st_size < LARGEST


def test_the_same_flight_gives_the_same_bytes(landed, kept, make_flight, tmp_path):
    written(tmp_path, landing(make_flight))
    assert (tmp_path / "report.html").read_bytes() == kept["bytes"]


def test_a_report_is_written_without_matplotlib():
    """It costs a second to import; the page has a writer of its own."""
    code = """
import sys, sim.reporting.run_page, sim.studies.page, sim.claims.page
from sim.reporting.drawing import svg
from sim.reporting.figures import style
figure, (panel,) = style.panels(1.0)
panel.line([0, 1], [0, 1])
assert "<path" in svg.written(figure, "")
print({"matplotlib", "PIL"} & set(sys.modules))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == "set()", done.stdout + done.stderr[-500:]


def test_every_axis_has_its_name_and_unit(landed):
    for image in landed.drawings:
        labels = [
            text for text in texts(image) if re.search(r", (m|km|s|deg|m/s)\b", text) or text == "share of travel"
        ]
        assert len(labels) >= 2


def test_seen_by_the_colour_blind_phases_that_meet_differ_in_lightness_or_hue():
    # Machado's matrix for full deuteranopia, on linear light; two greys 0.12 apart are told apart at a glance
    simulate = np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    )
    order = ["intercept", "downwind", "base_turn", "base", "final_turn", "final", "glide", "flare", "ground"]
    seen = [
        simulate @ (np.array([int(style.phase_colour(p)[i : i + 2], 16) for i in (1, 3, 5)]) / 255) ** 2.2
        for p in order
    ]
    for before, after in itertools.pairwise(seen):
        assert np.linalg.norm(before - after) > 0.12


def zero_line(panel):
    """Points of the line of wings level."""
    (line,) = [line for line in panel.lines if line.label.startswith("wings level")]
    return line.x[np.isfinite(line.x)], line.y[np.isfinite(line.y)]


def test_wings_are_level_where_the_law_s_own_algebra_says(make_flight):
    figure = phase_portrait(capture(make_flight), LAW)
    for panel in figure.panels:
        x, y = zero_line(panel)
        expected = -LAW.k1 / LAW.k2 * np.clip(x, -LAW.cross_track_limit, LAW.cross_track_limit)
        cell = 2 * panel.y.limits[1] / 120  # one cell of the grid at the corners
        assert np.abs(y - expected).max() < cell
        assert np.abs(x).max() > 1.1 * LAW.cross_track_limit  # the level part, the intercept, is in the picture


def test_the_beacon_portrait_has_its_own_inputs(make_flight):
    law = RadioBeacon(6.0, 1.2, np.radians(20.0), np.radians(5.0), "heading")
    whole = phase_portrait(capture(make_flight), law).panels[0]
    x, y = zero_line(whole)
    assert np.abs(y - 5.0 * np.clip(x, -5.0, 5.0)).max() < 2 * whole.y.limits[1] / 120
    assert (whole.x.label, whole.y.label) == ("bearing error, deg", "heading error, deg")


def test_a_law_without_an_offset_limit_is_drawn_too(make_flight):
    figure = phase_portrait(capture(make_flight), dataclasses.replace(LAW, cross_track_limit=np.inf))
    assert "wings level" in [mark.label for mark in figure.legend[0]]  # without an intercept


def test_saturation_is_shaded_exactly_where_the_command_stood_at_its_limit(make_flight):
    time = np.arange(0, 30, 1 / 30)
    commanded = np.where((time > 10) & (time < 12.01), -LAW.bank_limit, 0.0)
    flight = make_flight(time, ["final"] * len(time), command_bank=commanded, east=np.where(time < 5, 500.0, 0.0))
    _, history, bars = bank_history(flight, LAW, LAW.bank_limit).panels
    spans = [np.column_stack((block.left, block.right)) for block in marks(bars, Blocks)]
    np.testing.assert_allclose(spans[0], [[10 + 1 / 30, 12.0]], atol=1e-9)
    np.testing.assert_allclose(spans[1], [[0.0, 5.0 - 1 / 30]], atol=1e-9)
    assert [name for _, name in bars.y.ticks] == ["bank limited", "offset limited", "rate limited"]
    (shade,) = marks(history, Blocks)
    np.testing.assert_array_equal(np.column_stack((shade.left, shade.right)), spans[0])


@pytest.mark.parametrize("course_deg", [0.0, 90.0, 217.0])
def test_the_map_is_turned_and_never_mirrored(make_flight, course_deg):
    course = np.radians(course_deg)
    along, right = np.array((np.cos(course), np.sin(course))), np.array((-np.sin(course), np.cos(course)))
    route = Route((Leg(tuple(-30000 * along), tuple(0 * along), 70.0, 400.0),))
    place = np.linspace(-20000, -1000, 50)[:, None] * along + 700.0 * right  # 700 m right of the final course
    flight = make_flight(np.arange(50.0), ["final"] * 50, route, north=place[:, 0], east=place[:, 1])
    (panel,) = plan_view(flight, Runway(heading=course), (0.0, 0.0)).panels
    track = next(line for line in panel.lines if len(line.x) == 50)
    np.testing.assert_allclose(track.x, np.linspace(-20, -1, 50), atol=1e-9)
    np.testing.assert_allclose(track.y, 0.7, atol=1e-9)
    (left, right), (low, high) = panel.x.limits, panel.y.limits
    assert low > high  # right is down
    assert (right - left) / panel.box.width == pytest.approx((low - high) / panel.box.height)
