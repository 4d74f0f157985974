"""Delay over false alarms: a panel for each tracker, a curve for each test that watches it."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.metrics.alarms.operating_curve import OperatingCurve
from sim.reporting.figures import style
from sim.reporting.text.labels import words

COLOURS = (style.SKY, style.BLUE, style.BLACK, style.VERMILION)
HEIGHT = 1.5  # in
PROMISED = 1.0  # false alarms in 1000 looks, of the larger dots


def drawn_curves(curves: dict[str, list[OperatingCurve]]) -> Any | None:
    """Figure of the curves of each tracker; None where nothing was noticed, or there was nothing to notice."""
    every = [curve for own in curves.values() for curve in own]
    if not any(np.isfinite(curve.delay).any() for curve in every):
        return None
    from matplotlib.ticker import FuncFormatter

    figure, panels = style.grid(1, len(curves), HEIGHT, top=0.24)
    edge = 500.0 / max(max(curve.looks for curve in every), 1)
    handles: dict[str, Any] = {}
    for axes, (name, own) in zip(panels, curves.items(), strict=True):
        for colour, curve in zip(COLOURS, own, strict=False):
            seen = np.isfinite(curve.delay) & np.isfinite(curve.false_alarms)
            none = seen & (curve.false_alarms == 0.0)
            at = np.where(none, edge, curve.false_alarms)
            (handles[curve.test],) = axes.plot(at[seen], curve.delay[seen], color=colour, label=curve.test)
            axes.plot(at[none], curve.delay[none], "o", markersize=3, color=colour, markerfacecolor="white")
            some = seen & ~none
            axes.plot(at[some], curve.delay[some], "o", markersize=2, color=colour)
            promised = seen & np.isclose(curve.stated, PROMISED)
            axes.plot(at[promised], curve.delay[promised], "o", markersize=4.5, color=colour)
        axes.set_title(words(name), pad=2)
        axes.set_xscale("log")
        axes.set_xlabel("false alarms in 1000 looks")
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.minorticks_off()
    panels[0].set_xlim(0.8 * edge, 700.0)
    panels[0].set_ylim(0.0, None)
    panels[0].set_ylabel("median delay, s")
    figure.legend(handles.values(), handles, loc="upper left", ncols=4, bbox_to_anchor=(style.LEFT / style.WIDTH, 1.0))
    return figure
