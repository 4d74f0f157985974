"""One self-contained HTML page about the laws that were identified."""

from __future__ import annotations

import math

from autopilot.law_search import NAMES
from sim.reporting.page import picture, rendered
from sim.reporting.text.labels import ABSENT
from sim.studies.identification.figures import charts
from sim.studies.identification.spread import SHARES, correlations, outlying
from sim.studies.identification.survey import LABELS, UNIT_WORDS, Survey, cells, digits, scaled, sentence, why
from sim.versions import rows, versions

MOST_ROWS = 500  # of the table on the page; identification.json has them all


def page(found: Survey, law: str | None) -> str:
    """The text of identification.html; ``law`` is that of law.toml."""
    drawn = [picture(chart) for chart in charts(found)] if found.fits else []
    fits = [*found.fits.items()]
    return rendered(
        "identification.html",
        source=found.source,
        sentence=sentence(found),
        charts=drawn,
        spread_heads=["", *(f"{100 * share:g} %" for share in SHARES), "estimates", "bounds"],
        spread=[
            [
                f"{LABELS[name]}, {UNIT_WORDS[name]}",
                *(_number(scaled(name, value)) for value in spread.quantiles),
                str(spread.estimated),
                str(spread.bounds),
            ]
            for name, spread in found.spread.items()
        ],
        correlations=[(pair, f"{value:.2f}") for pair, value in correlations([*found.fits.values()]).items()],
        outliers=[
            (name, ", ".join(LABELS[one] for one in apart))
            for name, fit in fits
            if fit.explained and (apart := outlying(fit, found.spread))
        ],
        heads=["capture", "", *(f"{LABELS[name]}, {UNIT_WORDS[name]}" for name in NAMES), "residuals", "why"],
        rows=[
            [
                name,
                "explained" if fit.explained else "not explained",
                *cells(fit),
                f"{fit.cross_track_rms:.1f} m, {math.degrees(fit.bank_rms):.1f} deg",
                "; ".join(why(fit)),
            ]
            for name, fit in fits[:MOST_ROWS]
        ],
        left_out=max(0, len(fits) - MOST_ROWS),
        refused=[*found.refused.items()],
        law=law or "",
        versions=rows(versions()),
    )


def _number(value: float) -> str:
    return digits(value) if math.isfinite(value) else ABSENT
