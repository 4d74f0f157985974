"""The gallery of bundled scenarios, docs/gallery.md: ``make gallery`` flies each of them and draws one figure of it.

A scenario shows the figure that says most about it, by its name in `sim.figures`; the plan view unless FIGURES names
another. Studies are listed: what one of them draws is in docs/uses.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import sim
from sim.reporting.drawing import svg
from sim.reporting.run_figures import Run, figures_of
from sim.scenario import catalogue

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "gallery.md"
PICTURES = ROOT / "docs" / "figures" / "gallery"
FEW = 12  # draws of noise, which a picture shows as well as the 130 of a run

GROUPS = {
    "Whole approaches": ("an26_pattern", "an26_pattern_right", "c172x", "a320", "b747", "a320_vectored"),
    "Weather": ("an26_crosswind", "an26_shear", "an26_turbulence", "an26_gust", "an26_windshear"),
    "One line to capture": (
        "route_capture",
        "route_capture_point_mass",
        "limit_cycle",
        "beacon_homing",
        "vasylyev2003_jsbsim",
        "vasylyev2003_own_gains",
    ),
    "Something is not as announced": ("an26_departure", "an26_wrong_mode", "an26_noisy_radar"),
    "Flown on an estimate": ("an26_talkdown", "an26_talkdown_imm", "an26_localiser", "an26_mls_anomalies"),
    "The trackers of the papers, and what sensors bring": (
        "volovyk2022_jsbsim",
        "volovyk2018_mls",
        "kychak2011_jsbsim",
        "glistin_jsbsim",
        "mls_profile",
        "an26_downlink",
        "downlink_trade",
        "two_radars",
        "clutter",
    ),
}
FIGURES = {
    "an26_pattern": "contrast",
    "vasylyev2003_jsbsim": "contrast",
    "vasylyev2003_own_gains": "contrast",
    "volovyk2022_jsbsim": "contrast",
    "an26_shear": "wind_and_turbulence_over_height",
    "an26_turbulence": "bank",
    "an26_gust": "wind_met",
    "an26_windshear": "profile",
    "limit_cycle": "bank",
    "beacon_homing": "portrait",
    "an26_departure": "conformance",
    "an26_wrong_mode": "conformance",
    "an26_noisy_radar": "monitor",
    "an26_talkdown": "deviations",
    "an26_talkdown_imm": "deviations",
    "an26_localiser": "deviations",
    "an26_mls_anomalies": "deviations",
    "volovyk2018_mls": "errors",
    "kychak2011_jsbsim": "measurement_anomalies",
    "glistin_jsbsim": "errors",
    "mls_profile": "profile",
    "an26_downlink": "errors",
    "downlink_trade": "errors",
    "two_radars": "errors",
    "clutter": "estimates",
    "b747": "touchdown",
    "c172x": "profile",
    "a320": "speed",
}
HEAD = """# Gallery

Every scenario that is bundled, with one figure of its report; `make gallery` flies them and draws this page. A name
runs it, with its whole report: `shortfinal run an26_gust -o out/gust`.
"""


def about(name: str) -> str:
    """The first line of a bundled file: what it is."""
    file = catalogue.bundled(name)
    assert file is not None
    return file.read_text(encoding="utf-8").split("\n", 1)[0].removeprefix("# ")


def picture(name: str) -> str:
    """The figure of one scenario as SVG, on paper of its own."""
    scenario: Any = sim.read(name)
    draws = None if scenario.autopilot.navigation != "truth" else min(FEW, scenario.draws)
    result = sim.run(name, flights=1, draws=draws)
    run = Run(result.prepared, result.number, result.flight, result.records, result.tracks, result.metrics)
    chart = figures_of(run)[FIGURES.get(name, "plan")]
    return svg.written(chart.figure, chart.title).replace("<svg ", '<svg style="background:#fff" ', 1)


def page() -> str:
    """The page as Markdown."""
    parts = [HEAD]
    for title, names in GROUPS.items():
        figures = (
            f'<figure><img src="figures/gallery/{name}.svg" alt="{about(name)}" loading="lazy">'
            f"<figcaption><code>{name}</code><br>{about(name)}</figcaption></figure>\n"
            for name in names
        )
        parts.append(f'\n## {title}\n\n<div class="gallery">\n{"".join(figures)}</div>\n')
    studies = "".join(f"| `{name}` | {about(name)} |\n" for name in catalogue.studies())
    parts.append("\n## Studies\n\n`shortfinal study gain_map -o out/gain_map` flies one.\n\n")
    parts.append(f"| name | what it asks |\n|---|---|\n{studies}")
    return "".join(parts)


def main() -> None:
    """Draw all pictures and write the page."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for names in GROUPS.values():
        for name in names:
            (PICTURES / f"{name}.svg").write_text(picture(name), encoding="utf-8")
            print(PICTURES / f"{name}.svg", flush=True)
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
