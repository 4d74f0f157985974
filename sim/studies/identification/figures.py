"""Figures of many identified captures: how each number is spread, what no law explains, and some of the captures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autopilot.identification import EXPLAINED_BANK, EXPLAINED_CROSS_TRACK, LawFit
from autopilot.law_search import NAMES
from sim.reporting.drawing.scales import LOGARITHMIC
from sim.reporting.figures import style
from sim.reporting.figures.style import Chart, Key
from sim.studies.identification.spread import SHARES, outlying
from sim.studies.identification.survey import LABELS, UNIT_WORDS, Survey, scaled

PANEL = 1.0  # in, of one distribution
SHOWN = 3  # captures that are drawn
SHOWN_RESIDUALS = 2.0  # of the limits, up to which residuals are told apart


def charts(found: Survey) -> list[Chart]:
    """All of them."""
    drawn = [_residuals(found), *_captures(found)]
    return [_distributions(found), *drawn] if found.explained else drawn


def _distributions(found: Survey) -> Chart:
    figure, axes = style.panels(*(PANEL,) * len(NAMES), share=False, gap=0.5)
    explained = [fit for fit in found.fits.values() if fit.explained]
    for place, name in zip(axes, NAMES, strict=True):
        apart = [name in outlying(fit, found.spread) for fit in explained]
        values = np.array([scaled(name, getattr(fit, name).value) for fit in explained])
        order = np.argsort(values, kind="stable")
        share = (np.arange(len(values)) + 0.5) / len(values)
        for height, i in zip(share, order, strict=True):
            one = getattr(explained[i], name)
            colour = style.VERMILION if apart[i] else style.BLUE if one.met else style.GREY
            if one.met and math.isfinite(one.sigma):
                half = scaled(name, one.sigma)
                ends = max(values[i] - half, 0.0), values[i] + half
                place.line(ends, (height, height), colour=style.LIGHT, width=1.6)
            place.points(values[i], height, colour=colour, marker="o" if one.met else ">")
        spread = found.spread[name]
        place.line([scaled(name, q) for q in spread.quantiles], SHARES, width=0.9)
        place.x.limits = 0.0, 1.1 * float(np.quantile(values, 0.98)) or 1.0
        place.y.limits = 0.0, 1.0
        place.y.label = "share"
        place.x.label = f"{LABELS[name]}, {UNIT_WORDS[name]}"
    caption = (
        "Each dot is a capture, in the order of its value, with its standard error; grey arrows are limits that were "
        "never met and lie no lower; red dots lie apart from the others. Line: quantiles at 5, 25, 50, 75 and 95 % of "
        "estimates and bounds together (Kaplan and Meier)."
    )
    return Chart("Distributions", figure, caption)


def _residuals(found: Survey) -> Chart:
    figure, (axes,) = style.panels(2.4)
    most = SHOWN_RESIDUALS * EXPLAINED_CROSS_TRACK, SHOWN_RESIDUALS * math.degrees(EXPLAINED_BANK)
    for good, colour in ((True, style.BLUE), (False, style.VERMILION)):
        fits = [fit for fit in found.fits.values() if fit.explained is good]
        x = [min(fit.cross_track_rms, most[0]) for fit in fits]
        axes.points(x, [min(math.degrees(fit.bank_rms), most[1]) for fit in fits], colour=colour, marker="o")
    axes.rule(x=EXPLAINED_CROSS_TRACK, width=0.8, dashes=style.BROKEN)
    axes.rule(y=math.degrees(EXPLAINED_BANK), width=0.8, dashes=style.BROKEN)
    axes.x.limits, axes.y.limits = (0.0, 1.02 * most[0]), (0.0, 1.02 * most[1])
    axes.x.label = "cross-track residuals, m RMS"
    axes.y.label = "bank, deg RMS"
    caption = "What the best law leaves of each capture; what is not explained is red. At the edge: as much or more."
    return Chart("Residuals", figure, caption)


def _captures(found: Survey) -> list[Chart]:
    """The median of the captures that are explained, the worst of them, and the worst of all."""
    ranked = sorted(found.fits, key=lambda name: found.fits[name].misfit)
    explained = [name for name in ranked if found.fits[name].explained]
    chosen = [*explained[len(explained) // 2 : len(explained) // 2 + 1], *explained[-1:], *ranked[-1:]]
    return [_capture(name, found.fits[name]) for name in dict.fromkeys(chosen)][:SHOWN]


def _capture(name: str, fit: LawFit) -> Chart:
    figure, (path, bank) = style.panels(1.5, 1.2)
    time: Any = fit.capture.time - fit.capture.time[0]
    for axes, recorded, flown in (
        (path, fit.capture.cross_track, fit.flown.cross_track),
        (bank, np.degrees(fit.capture.bank), np.degrees(fit.flown.bank)),
    ):
        axes.line(time, recorded)
        axes.line(time, flown, colour=style.VERMILION, dashes=style.BROKEN)
    path.y.label = "cross-track, m"
    bank.y.label = "bank, deg"
    bank.x.label = "s from 12 s before the turn"
    keys = (Key("recorded", style.BLACK), Key("law", style.VERMILION, style.BROKEN))
    verdict = "explained" if fit.explained else "not explained: " + "; ".join(fit.objections)
    return Chart(name, figure, f"{verdict[0].upper()}{verdict[1:]}.", keys)
