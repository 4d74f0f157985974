"""Who is flying, as a tracker of intents believes it, and the test that alarms when it is not the assumed law."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.metrics.error_curves import pooled, windows
from sim.reporting.figures import style
from sim.reporting.figures.curves import phase_strip
from sim.reporting.figures.histories import STRIP, TIME
from tracking.conformance import Watched

COLOURS = {"route law": style.BLUE, "armed": style.SKY, "beacon law": style.ORANGE, "manual": "#B9B9B9"}
LEVELS = (5, 95)  # %, of the draws


def alert_strip(flight: Flight, watched: Watched) -> Any:
    """Figure of the probability of each intent, mean over the draws, above the test's sum and its limit."""
    figure, (strip, belief, test) = style.panels(STRIP, 0.9, 1.2, top=0.26)
    phase_strip(strip, flight)
    draws = watched.sum.shape[1]
    edges = windows(watched.time, 0, flight, draws)
    time = pooled(watched.time, edges)
    low = np.zeros(len(edges))
    for intent, probability in watched.belief.items():
        share = pooled(probability, edges)
        belief.fill_between(time, low, low + share, color=COLOURS[intent], linewidth=0, label=intent)
        low = low + share
    belief.set_ylim(0, 1)
    belief.set_yticks((0, 0.5, 1))
    belief.grid(False)
    belief.set_ylabel("probability")

    middle = np.median(watched.sum, axis=1)
    if draws > 1:
        under, over = np.percentile(watched.sum, LEVELS, axis=1)
        test.fill_between(watched.time, under, over, color=style.SHADE, linewidth=0, label="nine draws in ten")
    test.plot(watched.time, middle, color=style.BLACK, linewidth=1.0, label="median draw" if draws > 1 else "test")
    test.axhline(watched.limit, color=style.VERMILION, linewidth=0.9, dashes=(4, 2), label="alarm above")
    for number, event in enumerate(event for event in flight.events if event.name == "departure"):
        for axes in (belief, test):
            label = "departure" if axes is test and number == 0 else None
            axes.axvline(event.time, color=style.VERMILION, linewidth=0.8, label=label)
    test.set_ylim(0, 2.5 * watched.limit)
    test.set_ylabel("evidence against it")
    test.set_xlabel(TIME)
    handles = [axes.get_legend_handles_labels() for axes in (belief, test)]
    figure.legend(
        handles[0][0] + handles[1][0], handles[0][1] + handles[1][1], loc="upper left", ncols=7,
        bbox_to_anchor=(style.LEFT / style.WIDTH, 1.0), columnspacing=1.1, handletextpad=0.4,
    )  # fmt: skip
    return figure
