"""Trackers with several hypotheses: probabilities of their modes, anomalies of their measurements."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.metrics.error_curves import MANY, pooled, windows
from sim.reporting.drawing.figure import Drawing, Legend
from sim.reporting.drawing.scales import Scale, written
from sim.reporting.figures import style
from sim.reporting.figures.curves import phase_strip
from sim.reporting.figures.histories import STRIP, TIME
from sim.reporting.figures.thinning import peaks
from sim.reporting.text.labels import words
from tracking.track import ACCURACY, LAW, modes_of

BINS = 200  # of the stated accuracy
MOST_SAMPLES = 2500  # points of the anomaly strip
MODES = ("#08519C", "#3182BD", "#6BAED6", "#9ECAE1", "#C6DBEF")  # laws, from the least limit to the greatest
FREE = ("#FDD0A2", "#D94801", "#7F2704", "#A1A1A1", "#FD8D3C", "#636363")


def mode_names(tracker: Any, count: int) -> list[str]:
    """What each hypothesis of a tracker is called, in the order of its probabilities."""
    names = modes_of(tracker)
    return list(names) if len(names) == count else [f"model {i + 1}" for i in range(count)]


def model_probabilities(flight: Flight, tracked: dict[str, Any], modes: dict[str, list[str]]) -> Drawing | None:
    """Figure of the probabilities of all models over time, mean over draws, stacked: a panel for each tracker."""
    shown = {name: one.track for name, one in tracked.items() if one.track.model_probabilities is not None}
    if not shown:
        return None
    figure, (strip, *panels) = style.panels(STRIP, *(1.0 for _ in shown))
    phase_strip(strip, flight)
    for axes, (name, track) in zip(panels, shown.items(), strict=True):
        edges = windows(track.time, 0, flight, track.mean.shape[2])
        time = pooled(track.time, edges)
        low = np.zeros(len(edges))
        for index, (label, colour) in enumerate(zip(modes[name], _colours(modes[name]), strict=True)):
            share = pooled(track.model_probabilities[:, index], edges)
            axes.band(time, low, low + share, colour, label=label)
            low = low + share
        axes.y.limits, axes.y.ticks = (0.0, 1.0), style.SHARES
        axes.grid = ""
        axes.y.label, axes.y.label_size = words(name), 7.0 if len(name) < 18 else 5.5
        axes.legend = Legend("left", size=6.5, boxed=True, reverse=True)
    panels[-1].x.label = TIME
    return figure


def _colours(names: list[str]) -> list[str]:
    """Blues for laws, browns for flight without one, distinct colours where the names say neither."""
    laws = [name for name in names if name.startswith(LAW)]
    if laws:
        blues = [MODES[round(i * (len(MODES) - 1) / max(len(laws) - 1, 1))] for i in range(len(laws))]
        return blues + [FREE[i % len(FREE)] for i in range(len(names) - len(laws))]
    palette = (style.LIGHT, style.ORANGE, style.BLUE, style.VERMILION, *style.TRACKERS[2:])
    return [palette[i % len(palette)] for i in range(len(names))]


def anomaly_strip(
    flight: Flight, scenario: Any, tracked: dict[str, Any], modes: dict[str, list[str]]
) -> Drawing | None:
    """Figure of angle measurements minus truth (draw 0) and the probability that each is anomalous.

    For the first tracker whose hypotheses are accuracies of the measurement; None where there is none.
    """
    for name, one in tracked.items():
        record, weights = one.measurements, one.track.model_probabilities
        row = next((i for i, channel in enumerate(record.channels) if channel.endswith(".elevation")), None)
        if weights is None or row is None or not modes[name][0].startswith(ACCURACY):
            continue
        from sim.flight.interpolation import truth_at

        sensor_name, _, channel = record.channels[row].partition(".")
        sensor = scenario.sensors[sensor_name]
        order = np.argsort(record.arrival, kind="stable")
        time = record.time[order]
        exact = sensor.truth(truth_at(flight, time).state)[sensor.channels.index(channel)]
        error = np.degrees(record.z[order, row, 0] - exact)
        sigma = np.degrees(np.sqrt(np.reshape(record.R[order, row, row], (len(time), -1))[:, 0]))
        worse = 1.0 - weights[:, 0, 0]
        figure, (strip, samples, belief) = style.panels(STRIP, 1.7, 0.9)
        phase_strip(strip, flight)
        few = np.flatnonzero(np.isfinite(error))
        few = few[:: max(1, len(few) // MOST_SAMPLES)]
        odd = worse[few] > 0.5
        for among, colour, label in (
            (~odd, style.BLUE, "taken for nominal"),
            (odd, style.VERMILION, "taken for anomalous"),
        ):
            samples.points(time[few[among]], error[few[among]], colour=colour, size=1.8, label=label)
        chosen = peaks(sigma, BINS)
        for side in (-2, 2):
            samples.line(time[chosen], side * sigma[chosen], width=0.6, dashes=(4, 2))
        linear = max(2 * float(np.nanmedian(sigma)), 1e-6)
        samples.y.scale = Scale("symmetric", linear, 1.1)
        half = 1.4 * float(np.abs(error[few]).max()) if few.size else 1.0
        ticks = [tick for tick in (0.01, 0.1, 1.0, 10.0) if linear <= tick <= half]
        samples.y.limits = -half, half
        samples.y.ticks = [(tick, written(tick)) for tick in (*(-tick for tick in ticks), 0.0, *ticks)]
        samples.y.label = f"error of {channel}, deg"
        figure.legend = [samples.labelled]
        edges = windows(one.track.time, 0, flight, MANY)
        belief.band(pooled(one.track.time, edges), 0.0, pooled(worse, edges), style.VERMILION)
        belief.y.limits = 0.0, 1.0
        belief.y.label = "mean probability"
        belief.x.label = TIME
        return figure
    return None
