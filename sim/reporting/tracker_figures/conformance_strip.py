"""Who is flying, as a tracker of intents believes it, and the test that alarms when it is not the assumed law."""

from __future__ import annotations

import numpy as np

from sim.flight.record import Flight
from sim.metrics.error_curves import pooled, windows
from sim.reporting.drawing.figure import Drawing
from sim.reporting.drawing.legends import entries_of
from sim.reporting.figures import style
from sim.reporting.figures.curves import phase_strip
from sim.reporting.figures.histories import STRIP, TIME
from tracking.conformance import Watched

COLOURS = {"route law": style.BLUE, "armed": style.SKY, "beacon law": style.ORANGE, "manual": "#B9B9B9"}
LEVELS = (5, 95)  # %, of the draws


def alert_strip(flight: Flight, watched: Watched) -> Drawing:
    """Figure of the probability of each intent, mean over the draws, above the test's sum and its limit."""
    figure, (strip, belief, test) = style.panels(STRIP, 0.9, 1.2)
    phase_strip(strip, flight)
    draws = watched.sum.shape[1]
    edges = windows(watched.time, 0, flight, draws)
    time = pooled(watched.time, edges)
    low = np.zeros(len(edges))
    for intent, probability in watched.belief.items():
        share = pooled(probability, edges)
        belief.band(time, low, low + share, COLOURS[intent], label=intent)
        low = low + share
    belief.y.limits = 0.0, 1.0
    belief.y.ticks = style.SHARES
    belief.grid = ""
    belief.y.label = "probability"

    middle = np.median(watched.sum, axis=1)
    if draws > 1:
        under, over = np.percentile(watched.sum, LEVELS, axis=1)
        test.band(watched.time, under, over, style.SHADE, label="nine draws in ten")
    test.line(watched.time, middle, width=1.0, label="median draw" if draws > 1 else "test")
    test.rule(y=watched.limit, colour=style.VERMILION, width=0.9, dashes=(4, 2), label="alarm above")
    for number, event in enumerate(event for event in flight.events if event.name == "departure"):
        for axes in (belief, test):
            label = "departure" if axes is test and number == 0 else ""
            axes.rule(x=event.time, colour=style.VERMILION, width=0.8, label=label)
    test.y.limits = 0.0, 2.5 * watched.limit
    test.y.label = "evidence against it"
    test.x.label = TIME
    figure.legend = [entries_of([belief, test])]
    return figure
