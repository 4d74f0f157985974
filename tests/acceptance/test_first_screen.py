"""The first screen of reports: both contrasted trackers by name, by how much, and why; the whole page in a browser."""

from __future__ import annotations

import base64
import re

import pytest

from sim.experiment import report, run
from sim.reporting.text.labels import words
from tests.sim.chromium import CHROMIUM, Browser

pytestmark = pytest.mark.acceptance
INTERVAL = r"\d[\d.]* to \d[\d.]*\)"
LARGEST = 3_000_000  # bytes
SCREEN = 1280, 800
FIVE = ("an26_pattern", "vasylyev2003_jsbsim", "volovyk2022_jsbsim", "an26_turbulence", "clutter")
FOLD, FIRST_FIGURE, WHOLE, SHEETS, WEIGHT = 800, 1700, 6000, 10, 2_000_000  # pixels, pixels, pixels, pages, bytes


@pytest.fixture
def browser(tmp_path):
    if CHROMIUM is None:
        pytest.skip("no Chromium on the PATH, so the page was not looked at")
    browser = Browser(tmp_path / "browser")  # its profile
    yield browser
    browser.close()


def shown(browser, folder, name, width=SCREEN[0]):
    report(run(name), folder)
    browser.open(folder / "report.html")
    size = {"width": width, "height": SCREEN[1], "deviceScaleFactor": 1, "mobile": width < 500}
    browser.call("Emulation.setDeviceMetricsOverride", **size)


def box(browser, selector, place=0):
    """Left, top, right, bottom of an element, pixels of the window."""
    side = "(b => [b.left, b.top, b.right, b.bottom])"
    return browser.value(f"{side}(document.querySelectorAll({selector!r})[{place}].getBoundingClientRect())")


@pytest.mark.parametrize(
    "name", ["an26_pattern", "vasylyev2003_jsbsim", "volovyk2022_jsbsim", "an26_turbulence", "clutter"]
)
def test_answer_contrast_and_a_figure_stand_on_the_first_screen(name, browser, tmp_path, row):
    shown(browser, tmp_path / "run", name)
    answer, told, figure = (box(browser, f"header {what}")[3] for what in (".sentence", ".verdict", "svg.drawing"))
    met = max(answer, told, figure) <= FOLD and browser.said == []
    row(
        f"{name}: within {SCREEN[0]} x {SCREEN[1]}",
        f"answer, contrast and one figure end above {FOLD} px",
        f"{answer:.0f}, {told:.0f} and {figure:.0f} px",
        met,
    )
    assert met


def test_the_default_report_is_short_and_prints_whole(browser, tmp_path, row):
    shown(browser, tmp_path / "run", "an26_pattern")
    first, whole = box(browser, "#trackers svg.drawing")[1], browser.value("document.documentElement.scrollHeight")
    size = (tmp_path / "run" / "report.html").stat().st_size
    printed = base64.b64decode(browser.call("Page.printToPDF", preferCSSPageSize=True)["data"])
    sheets = len(re.findall(rb"/Type\s*/Page\b(?!s)", printed))
    browser.call("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
    browser.value("document.querySelectorAll('details').forEach(one => { one.open = true; })")
    wide = browser.value("document.documentElement.scrollWidth")
    browser.value("document.querySelectorAll('details').forEach(one => { one.open = false; })")
    browser.call("Emulation.setEmulatedMedia", media="print")
    hidden = browser.value(
        "[...document.querySelectorAll('svg.drawing, table, pre')].filter(one => !one.closest('#replay') && "
        "!one.checkVisibility({contentVisibilityAuto: true})).length"
    )
    for what, asked, value, met in (
        ("first tracker figure", f"<= {FIRST_FIGURE} px", f"{first:.0f} px", first <= FIRST_FIGURE),
        ("height folded", f"<= {WHOLE} px", f"{whole} px", whole <= WHOLE),
        (
            "printed, all unfolded",
            f"<= {SHEETS} pages",
            f"{sheets} pages, {hidden} hidden",
            1 < sheets <= SHEETS and not hidden,
        ),
        ("sideways at 390 px", "<= 390 px", f"{wide} px", wide <= 390),
        ("weight", "<= 2 MB", f"{size / 1e6:.2f} MB", size <= WEIGHT),
        ("console", "silent", f"{len(browser.said)} lines", browser.said == []),
    ):
        row(f"default report: {what}", asked, value, met)
        assert met, what


def test_figures_and_tables_of_the_default_report_answer_the_hand(browser, tmp_path, row):
    """Zoom, values under the pointer, one cursor with the replay, sorted columns; by mouse, as a reader would."""
    shown(browser, tmp_path / "run", "an26_pattern")
    done = []

    def value(expression):
        return browser.value(expression)

    panel = "document.querySelectorAll('#trackers svg.panel')[1]"
    value(f"{panel}.scrollIntoView({{block: 'center'}})")
    left, top, right, bottom = box(browser, "#trackers svg.panel", 1)
    x, y = (left + right) / 2, (top + bottom) / 2
    x0, x1 = (float(value(f"{panel}.dataset.{side}")) for side in ("x0", "x1"))

    browser.point("mouseMoved", x, y)
    told = value("document.querySelector('.tip').innerText").splitlines()
    middle = float(re.search(r"time, s (\d+\.\d)", told[0])[1])
    done.append(abs(middle - (x0 + x1) / 2) < 0.5 and len(told) > 3 and "saturated control" in "".join(told))

    browser.point("mousePressed", x, y, button="left", clickCount=1)
    browser.point("mouseReleased", x, y, button="left", clickCount=1)
    clock = float(value("document.querySelector('[data-part=clock]').textContent").removesuffix(" s"))
    browser.point("mouseMoved", 2, 2)
    lines = value("[...document.querySelectorAll('.cursor')].map(one => one.getAttribute('d') != null)")
    timed = value("document.querySelectorAll('svg.panel[data-time]').length")
    done.append(abs(clock - middle) < 0.2 and all(lines) and len(lines) == timed > 10)
    before = value(f"{panel}.querySelector('.cursor').getAttribute('d')")
    value("document.querySelector('#replay canvas').focus()")
    browser.press("ArrowRight", shift=True)
    done.append(value(f"{panel}.querySelector('.cursor').getAttribute('d')") != before)

    left, top, right, bottom = box(browser, "#trackers svg.panel", 1)  # the page may have moved with the focus
    value(f"{panel}.scrollIntoView({{block: 'center'}})")
    left, top, right, bottom = box(browser, "#trackers svg.panel", 1)
    y, numbers = (top + bottom) / 2, "document.querySelectorAll('#trackers .x-numbers')[0].textContent"
    whole = value(numbers)
    begin, end = left + 0.25 * (right - left), left + 0.5 * (right - left)
    browser.point("mousePressed", begin, y, button="left", clickCount=1)
    browser.point("mouseMoved", end, y, buttons=1)
    browser.point("mouseReleased", end, y, button="left", clickCount=1)
    shares = value(
        "[...document.querySelectorAll('#trackers > figure svg.panel[data-time]')].map(p => "
        "Number(p.getAttribute('viewBox').split(' ')[2]) / Number(p.getAttribute('width')))"
    )
    done.append(len(shares) > 1 and all(abs(share - 0.25) < 0.01 for share in shares) and value(numbers) != whole)
    browser.point("mouseMoved", end, y)  # half way across the panel, which now shows the second quarter
    inside = float(re.search(r"time, s (\d+\.\d)", value("document.querySelector('.tip').innerText"))[1])
    done.append(abs(inside - (x0 + (0.25 + 0.25 * 0.5) * (x1 - x0))) < 2.0)
    for count in (1, 2):
        browser.point("mousePressed", end, y, button="left", clickCount=count)
        browser.point("mouseReleased", end, y, button="left", clickCount=count)
    done.append(value(numbers) == whole)

    table = "document.querySelector('#trackers table.sorted')"
    value(f"{table}.closest('details').open = true; {table}.rows[0].cells[2].click()")
    column = value(f"[...{table}.rows].slice(1).map(one => Number(one.cells[2].textContent))")
    value(f"{table}.rows[0].cells[2].click()")
    down = value(f"[...{table}.rows].slice(1).map(one => Number(one.cells[2].textContent))")
    done.append(len(column) > 5 and column == sorted(column) and down == sorted(column, reverse=True))
    met = all(done) and browser.said == []
    row(
        "default report: hover, click, linked cursor, zoom, reset, sort", "all work", f"{sum(done)} of {len(done)}", met
    )
    assert met, done


@pytest.mark.parametrize("name", ["an26_pattern", "vasylyev2003_jsbsim", "volovyk2022_jsbsim"])
def test_the_first_screen_names_both_with_their_ratios_and_why(name, tmp_path, row):
    result = run(name)
    report(result, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    screen = page.partition("<nav>")[0].partition("<body")[2]
    ahead, whole, lost = result.contrasted[:3]
    scenario, lines = result.scenario, [re.sub(r"\s+", " ", line) for line in (ahead, whole, lost)]
    kinds = {words(scenario.trackers[one].kind) for one in (scenario.contrasts[0].of, scenario.contrasts[0].against)}
    both = all(kind.lower() in line.lower() for kind in kinds for line in lines[:2])
    intervals = [len(re.findall(INTERVAL, line)) for line in lines[:2]]
    why = bool(re.search(r"astray since \d+ s \([a-z ]+\): [a-z]", lost))
    figures = screen.count('class="drawing"')
    drawn, light = figures == 1, len(page.encode()) <= LARGEST
    there = all(line in re.sub(r"\s+", " ", screen) for line in lines)
    met = both and min(intervals) >= 1 and why and drawn and light and there
    row(
        f"{name}: first screen",
        "both named, both ratios with intervals, why; one figure; page <= 3 MB",
        f"{ahead} {whole} {lost} {figures} figure, {len(page.encode()) / 1e6:.1f} MB",
        met,
    )
    assert met
