"""Drawings as plain values and their two writers: places against matplotlib's, ticks, paths, words that stay text."""

from __future__ import annotations

import io
import itertools
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from sim.reporting.drawing import contours, legends, paths, shapes, svg
from sim.reporting.drawing.colours import BLUE_RED, Colours, add_scale
from sim.reporting.drawing.figure import Box, Drawing, Legend, Panel
from sim.reporting.drawing.marks import NONE, Line
from sim.reporting.drawing.matplotlib_backend import figure
from sim.reporting.drawing.scales import LINEAR, LOGARITHMIC, Scale, named
from sim.reporting.figures import style

SVG = "{http://www.w3.org/2000/svg}"
EVIL = "<script>alert('x')</script>\"'&\x00 {{ 7 * 7 }}"
SIZE = (400.0, 100.0)


def drawn(**panel):
    """A drawing of one panel, and the panel."""
    made = Panel(Box(50.0, 10.0, *SIZE))
    for name, value in panel.items():
        setattr(made, name, value)
    return Drawing(518.4, 150.0, [made]), made


def elements(drawing):
    """The SVG as a tree."""
    return ElementTree.fromstring(svg.written(drawing, "title"))


def points(d):
    """(n, 2) units: corners of a path of M, m and l."""
    at, found = np.zeros(2), []
    for letter, text in re.findall(r"([Mml])([^MmlhvVz]*)", d):
        for pair in np.reshape([float(one) for one in re.findall(r"-?\d+", text)], (-1, 2)):
            at = pair if letter == "M" else at + pair
            found.append(at.copy())
    return np.array(found)


def curve(drawing, name):
    """Points of the path of a labelled mark."""
    (path,) = [one for one in elements(drawing).iter(f"{SVG}path") if one.get("data-name") == name]
    return points(path.get("d"))


SCALES = {
    "linear": (LINEAR, (-3.0, 8.0)),
    "upside down": (LINEAR, (8.0, -3.0)),
    "logarithmic": (LOGARITHMIC, (0.03, 500.0)),
    "symmetric": (Scale("symmetric", 0.5, 1.0 / 0.9), (-40.0, 90.0)),
}


@pytest.mark.parametrize("across", SCALES)
@pytest.mark.parametrize("up", SCALES)
def test_values_lie_where_matplotlib_puts_them(across, up):
    drawing, panel = drawn()
    (panel.x.scale, panel.x.limits), (panel.y.scale, panel.y.limits) = SCALES[across], SCALES[up]
    x, y = (np.array([0.05, 7.0, 0.4, 3.0]), np.array([0.2, 0.3, 6.0, 1.0]))
    panel.points(x, y, label="here")
    made = figure(drawing)
    (axes,) = made.axes
    expected = axes.transData.transform(np.column_stack((x, y))) * 72 / made.dpi  # points, from below
    expected = np.column_stack((expected[:, 0] - 50.0, SIZE[1] - (expected[:, 1] - 40.0)))
    np.testing.assert_allclose(curve(drawing, "here"), 10 * expected, atol=0.51 + 1e-6)  # rounded to whole units


def test_a_script_can_turn_places_into_values():
    drawing, panel = drawn()
    panel.y.scale, panel.y.limits, panel.x.limits = LOGARITHMIC, (0.1, 100.0), (2.0, 12.0)
    panel.line([3.0, 11.0], [0.5, 40.0], label="it")
    (inner,) = [one for one in elements(drawing).iter(f"{SVG}svg") if one.get("class") == "panel"]
    x0, x1, y0, y1 = (float(inner.get(f"data-{name}")) for name in ("x0", "x1", "y0", "y1"))
    assert (inner.get("data-x-scale"), inner.get("data-y-scale")) == (None, "log")
    width, height = float(inner.get("width")), float(inner.get("height"))
    at = curve(drawing, "it")
    np.testing.assert_allclose(x0 + at[:, 0] / width * (x1 - x0), [3.0, 11.0], atol=1.01 * (x1 - x0) / width)
    np.testing.assert_allclose(y0 * (y1 / y0) ** (1 - at[:, 1] / height), [0.5, 40.0], rtol=0.01)


def distance(point, line):
    """From a point to the nearest place of a line through points."""
    a, b = line[:-1], line[1:]
    along = b - a
    share = np.clip(((point - a) * along).sum(1) / np.maximum((along**2).sum(1), 1e-12), 0.0, 1.0)
    return float(np.hypot(*(a + share[:, None] * along - point).T).min())


@pytest.mark.parametrize("seed", range(3))
def test_a_thinned_line_stays_within_a_fifth_of_a_point(seed):
    """Half a unit of rounding, and three quarters of one for each of two passes."""
    random = np.random.default_rng(seed)
    x, y = np.linspace(0.0, 400.0, 600), 50.0 + np.cumsum(random.normal(size=600)) * (0.05, 0.5, 3.0)[seed]
    line = points(paths.path(x, y, SIZE)) / paths.UNIT
    inside = (y > -20.0) & (y < 120.0)
    assert max(distance(point, line) for point in np.column_stack((x, y))[inside]) < 0.2
    assert len(line) < 600


def test_lines_are_broken_where_nothing_is_known_and_cross_the_panel_from_far_outside():
    broken = paths.path(np.array([0.0, 10.0, np.nan, 20.0, 30.0, np.inf, 40.0]), np.arange(7.0), SIZE)
    assert broken.count("M") == 2  # one point alone is no line
    assert points(broken)[:, 0].tolist() == [0, 100, 200, 300]
    through = points(paths.path(np.array([-9e3, 9e3]), np.array([-9e3, 9e3]), SIZE))
    assert through.tolist() == [[-9e4, -9e4], [9e4, 9e4]]
    beside = paths.path(np.array([0.0, 100.0, 200.0, 300.0, 400.0]), np.array([50.0, -300, -400, -300, 50.0]), SIZE)
    assert points(beside).tolist() == [[0, 500], [1000, -3000], [3000, -3000], [4000, 500]]


def test_ticks_are_round_and_at_least_two():
    random = np.random.default_rng(4)
    for size, most in itertools.product(10.0 ** np.arange(-6, 7), (1, 2, 5, 9)):
        low, high = np.sort(size * random.normal(size=2))
        ticks = LINEAR.ticks(low, high, most)
        assert 2 <= len(ticks) <= max(most + 1, 6)
        assert all(low - 1e-6 * (high - low) <= tick <= high + 1e-6 * (high - low) for tick in ticks)
        steps = np.diff(ticks)
        assert np.ptp(steps) < 1e-6 * steps[0]
        first = steps[0] / 10.0 ** np.floor(np.log10(steps[0] * (1 + 1e-9)))
        assert min(abs(first - one) for one in (1.0, 2.0, 2.5, 5.0, 10.0)) < 1e-6
        assert len(set(named(ticks))) == len(ticks)  # enough digits to tell them apart
    assert named([-0.5, 0.0, 0.5]) == ["\N{MINUS SIGN}0.5", "0.0", "0.5"]
    assert named([-0.0, 1000.0]) == ["0", "1000"]


def test_logarithmic_ticks_are_1_2_5_or_powers_of_ten_alone():
    assert named(LOGARITHMIC.ticks(0.15, 30.0, 9), LOGARITHMIC) == ["0.2", "0.5", "1", "2", "5", "10", "20"]
    # an axis that holds but one of them is nearly linear
    assert named(LOGARITHMIC.ticks(0.65, 1.53, 6), LOGARITHMIC) == ["0.8", "1", "1.2", "1.4"]
    assert LOGARITHMIC.ticks(0.5, 2e4, 9) == [1.0, 10.0, 100.0, 1000.0, 10000.0]


def test_axes_without_limits_hold_the_data_of_all_panels_that_share_them():
    figure_, panels = style.panels(1.0, 1.0)
    panels[0].line([0.0, 4.0], [1.0, 1.0])
    panels[1].points([10.0, np.nan], [np.inf, 2.0])
    assert figure_.limits(panels[0].x) == pytest.approx((-0.5, 10.5))
    low, high = figure_.limits(panels[0].y)  # one value alone
    assert low < 1.0 < high
    panels[1].y.limits = 0.0, None
    assert figure_.limits(panels[1].y) == pytest.approx((0.0, 2.1))
    panels[1].y.limits = 3.0, 3.0
    low, high = figure_.limits(panels[1].y)
    assert low < 3.0 < high


def test_words_of_any_kind_stay_words():
    drawing, panel = drawn(title=EVIL, legend=Legend("upper right"))
    panel.x.label = panel.y.label = EVIL
    panel.line([0, 1], [0, 1], label=EVIL)
    panel.words(EVIL, 0.5, 0.5)
    drawing.legend = [panel.labelled]
    text = svg.written(drawing, EVIL)
    tree = ElementTree.fromstring(text)
    assert not [one for one in tree.iter() if one.tag.endswith("script")]
    shown = ["".join(one.itertext()) for one in tree.iter(f"{SVG}text")]
    assert shown.count(EVIL.replace("\x00", "")) == 6
    assert text == svg.written(drawing, EVIL)


def test_blocks_reach_the_edges_and_bars_of_a_logarithmic_axis_its_foot():
    drawing, panel = drawn()
    panel.x.limits = panel.y.limits = 1.0, 3.0
    panel.blocks(2.0, np.inf, -np.inf, np.inf, "#123456", label="right half")
    (path,) = [one for one in elements(drawing).iter(f"{SVG}path") if one.get("data-name") == "right half"]
    assert path.get("d") == "M2000 0h2000v1000h-2000z"
    panel.y.scale, panel.y.limits = LOGARITHMIC, (1.0, 100.0)
    panel.blocks(1.0, 2.0, 0.0, 10.0, "#654321", label="bar")
    (path,) = [one for one in elements(drawing).iter(f"{SVG}path") if one.get("data-name") == "bar"]
    assert path.get("d") == "M0 500h2000v500h-2000z"


def test_hatching_stays_within_and_goes_on_in_the_next_block():
    strokes = points(shapes.hatching(100, 50, 300, 400)).reshape(-1, 2, 2)
    assert len(strokes) > 5
    assert (strokes[..., 0] >= 100).all()
    assert (strokes[..., 0] <= 400).all()
    assert (strokes[..., 1] >= 50).all()
    assert (strokes[..., 1] <= 450).all()
    beside = points(shapes.hatching(400, 50, 300, 400)).reshape(-1, 2, 2)
    phases = {int(stroke.sum(axis=1)[0]) % shapes.WIDE for stroke in (*strokes, *beside)}
    assert phases == {0}
    assert (np.diff(strokes.sum(axis=2), axis=1) == 0).all()  # at 45 degrees


def test_contours_of_a_cone_are_circles_and_rings():
    x = y = np.linspace(-2.0, 2.0, 81)
    height = np.hypot(x[None, :], y[:, None])
    line = np.array(contours.lines(x, y, height, 1.0))
    radius = np.hypot(*line[:, np.isfinite(line[0])])
    assert radius == pytest.approx(np.ones(len(radius)), abs=2e-3)
    rings = contours.regions(x, y, height, 0.5, 1.0)
    areas = sorted(0.5 * float(np.sum(a[:-1, 0] * a[1:, 1] - a[1:, 0] * a[:-1, 1])) for a in rings)
    assert areas == pytest.approx([-0.25 * np.pi, np.pi], rel=0.01)  # a hole runs the other way round
    hidden = np.where(x[None, :] > 0.0, np.nan, height)
    assert np.nanmax(contours.lines(x, y, hidden, 1.0)[0]) <= 0.0


def test_numbers_between_two_colours_are_mixed_evenly():
    found = Colours(("#000000", "#0000FF"), 0.0, 10.0).of(np.array([[-1.0, 0.0, 4.0], [10.0, 99.0, np.nan]]))
    assert found == ["#000000", "#000000", "#000066", "#0000FF", "#0000FF", ""]


def test_a_scale_of_colours_takes_its_room_from_the_panels():
    drawing, panels = style.grid(1, 3, 1.0)
    add_scale(drawing, Colours(BLUE_RED, -1.0, 1.0), "ratio", [(0.0, "1")])
    *maps, _ = drawing.panels
    assert maps == panels
    edges = [(one.box.left, one.box.left + one.box.width) for one in drawing.panels]
    assert all(before[1] < after[0] for before, after in itertools.pairwise(edges))
    assert edges[-1][1] < drawing.width
    assert maps[0].box.left == style.LEFT * style.INCH


def test_a_legend_above_the_panels_has_as_many_rows_as_it_needs():
    drawing, _ = style.panels(1.0)
    drawing.legend = [[Line(NONE, NONE, label=f"a rather long name, number {k}") for k in range(12)]]
    entries, height = legends.above(drawing)
    rows = sorted({one.y for one in entries})
    assert len(rows) > 2
    assert height > rows[-1]
    for row in rows:
        ends = [(one.x, one.x + legends.width(one.mark.label, one.size)) for one in entries if one.y == row]
        assert all(before[1] < after[0] for before, after in itertools.pairwise(ends))
        assert ends[-1][1] < drawing.width


def everything():
    """A drawing with a mark of each kind on either kind of axis."""
    drawing, panels = style.panels(1.0, 1.0, share=False)
    for panel in panels:
        panel.line([1, 2, 3], [1, 5, 2], label="line", dashes=(3, 1))
        for marker in ".osD^v>Xx|":
            panel.points([1.5, 2.5], [2, 3], marker=marker, fill="white")
        panel.band([1, 2, 3], 1.0, [2, 2, 4], "#AABBCC", label="band")
        panel.blocks([1, 2], [2, np.inf], -np.inf, [3, 4], ["#112233", "#445566"], edge="#000000", hatch="#777777")
        panel.area([np.array([[1, 1], [2, 1], [2, 3.0]])], "#DDEEFF", label="area")
        panel.rule(x=2.0, label="rule")
        panel.rule(y=2.0)
        panel.words("words", 2.0, 2.0, turn=30.0, above=0.5)
        panel.arrows([1.0], [1.0], [20.0], [10.0])
        panel.legend = Legend("lower left", 2)
        panel.title = "title"
    panels[1].y.scale = LOGARITHMIC
    drawing.legend = [panels[0].labelled]
    return drawing


def test_matplotlib_draws_every_mark_and_keeps_the_user_s_own_settings():
    import matplotlib

    with matplotlib.rc_context({"font.size": 31.0, "axes.grid": False, "svg.fonttype": "none"}):
        made = figure(everything())
        assert (matplotlib.rcParams["font.size"], matplotlib.rcParams["axes.grid"]) == (31.0, False)
        buffer = io.BytesIO()
        made.savefig(buffer, format="svg")
    words = {"".join(one.itertext()) for one in ElementTree.fromstring(buffer.getvalue()).iter(f"{SVG}text")}
    assert {"words", "title", "line", "band", "area", "rule"} <= words
    assert made.get_size_inches() == pytest.approx((7.2, made.get_figheight()))
    ours = {"".join(one.itertext()) for one in elements(everything()).iter(f"{SVG}text")}
    assert {one for one in words if one} == {one for one in ours if one}  # the same ticks, too
