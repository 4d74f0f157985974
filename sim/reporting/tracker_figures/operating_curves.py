"""Delay over false alarms: a panel for each tracker, a curve for each test that watches it."""

from __future__ import annotations

import numpy as np

from sim.metrics.alarms.operating_curve import OperatingCurve
from sim.reporting.drawing.figure import Drawing
from sim.reporting.drawing.legends import entries_of
from sim.reporting.drawing.marks import PAPER
from sim.reporting.drawing.scales import LOGARITHMIC
from sim.reporting.figures import style
from sim.reporting.text.labels import words

COLOURS = (style.SKY, style.BLUE, style.BLACK, style.VERMILION)
HEIGHT = 1.5  # in
PROMISED = 1.0  # false alarms in 1000 looks, of the larger dots


def drawn_curves(curves: dict[str, list[OperatingCurve]]) -> Drawing | None:
    """Figure of the curves of each tracker; None where nothing was noticed, or there was nothing to notice."""
    every = [curve for own in curves.values() for curve in own]
    if not any((np.isfinite(curve.delay) & np.isfinite(curve.false_alarms)).any() for curve in every):
        return None
    figure, panels = style.grid(1, len(curves), HEIGHT)
    edge = 500.0 / max(max(curve.looks for curve in every), 1)
    for axes, (name, own) in zip(panels, curves.items(), strict=True):
        for colour, curve in zip(COLOURS, own, strict=False):
            seen = np.isfinite(curve.delay) & np.isfinite(curve.false_alarms)
            none = seen & (curve.false_alarms == 0.0)
            at = np.where(none, edge, curve.false_alarms)
            axes.line(at[seen], curve.delay[seen], colour=colour, label=curve.test)
            axes.points(at[none], curve.delay[none], colour=colour, marker="o", size=3.0, fill=PAPER)
            some = seen & ~none
            axes.points(at[some], curve.delay[some], colour=colour, marker="o", size=2.0)
            promised = seen & np.isclose(curve.stated, PROMISED)
            axes.points(at[promised], curve.delay[promised], colour=colour, marker="o", size=4.5)
        axes.title = words(name)
    panels[0].x.scale = LOGARITHMIC
    panels[0].x.label = "false alarms in 1000 looks"
    panels[0].x.limits = 0.8 * edge, 700.0
    panels[0].y.limits = 0.0, None
    panels[0].y.label = "median delay, s"
    figure.legend = [entries_of(panels)]
    return figure
