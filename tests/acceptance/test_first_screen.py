"""The first screen of the reports that exist to compare two trackers: both by name, by how much, and why."""

from __future__ import annotations

import re

import pytest

from sim.experiment import report, run
from sim.reporting.text.labels import words

pytestmark = pytest.mark.acceptance
INTERVAL = r"\d[\d.]* to \d[\d.]*\)"
LARGEST = 3_000_000  # bytes


@pytest.mark.parametrize("name", ["an26_pattern", "vasylyev2003_jsbsim", "volovyk2022_jsbsim"])
def test_the_first_screen_names_both_with_their_ratios_and_why(name, tmp_path, row):
    result = run(name)
    report(result, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    screen = page.partition('<dl class="figures">')[0].partition("<body")[2]
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
