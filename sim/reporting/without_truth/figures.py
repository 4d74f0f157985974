"""Figures of tracks of which no truth is known."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.reporting.drawing.figure import Drawing
from sim.reporting.figures import style
from sim.reporting.figures.histories import TIME
from sim.reporting.figures.style import Chart
from sim.reporting.text.labels import words
from sim.reporting.tracker_figures.charts import keys_of
from sim.reporting.tracker_figures.error_curves import Shown
from sim.reporting.tracker_figures.estimate_map import estimate_map
from sim.reporting.tracker_figures.tracking_errors import band_of_one, legend, logarithmic, thinned
from tracking.height_profile import Charted


def plot_charts(
    scenario: Any,
    flight: Flight,
    trackers: dict[str, Any],
    followed: list[Shown],
    records: dict[str, Any],
    chart: Charted | None = None,
) -> list[Chart]:
    """What plots alone say of the trackers; ``trackers`` as in metrics.json."""
    if not followed:
        return []
    drawn: list[Chart] = []

    def add(title: str, figure: Drawing | None, caption: str) -> None:
        if figure is not None:
            drawn.append(Chart(title, figure, caption, keys_of(followed)))

    with np.errstate(invalid="ignore", divide="ignore"):
        add(
            "Tracks in plan",
            estimate_map(flight, scenario, followed, records, chart),
            "Above all of it, below the middle of the plots enlarged, with ellipses of two standard deviations here "
            "and there; dots are the plots.",
        )
        add(
            "Innovations over time",
            innovations_over_time(flight, followed),
            "Mean normalised innovation squared (NIS) per dimension: 1 where covariances are right, and within the "
            "band in 95 % of the epochs of a consistent tracker.",
        )
        add(
            "Look-ahead",
            look_ahead_to_plots(trackers, followed),
            "Root mean square distance of later plots from where they were predicted so many seconds ahead; the errors "
            "of the plots are in it.",
        )
    return drawn


def innovations_over_time(flight: Flight, followed: list[Shown]) -> Drawing:
    """Figure of the mean NIS of each tracker with the band that 95 % of consistent trackers keep."""
    figure, (axes,) = style.panels(1.9)
    for one in followed:
        thinned(axes, one.curves.time, one.curves.nis, label=words(one.name), width=0.9, **one.look)
    most = max((one.curves for one in followed), key=lambda curves: len(curves.time))
    seen = most.nis_samples > 0
    band_of_one(axes, most.nis_samples[seen].astype(float), most.time[seen])
    axes.x.limits = float(flight.time[0]), float(flight.time[-1]) + 1e-6
    axes.y.label = "mean NIS"
    axes.x.label = TIME
    legend(figure, axes, followed)
    return figure


def look_ahead_to_plots(trackers: dict[str, Any], followed: list[Shown]) -> Drawing | None:
    """Figure of the distance of later plots over how far ahead they were predicted; None where none were."""
    found = {one.name: trackers[one.name]["plots"]["look_ahead"] for one in followed}
    if not any(found.values()):
        return None
    figure, (axes,) = style.panels(1.7)
    for one in followed:
        points = [(float(span.partition("_")[0]), its["rmse_m"]) for span, its in found[one.name].items()]
        ahead, errors = np.array(points).reshape(-1, 2).T
        axes.line(ahead, errors, label=words(one.name), **one.look)
        axes.points(ahead, errors, colour=one.look["colour"], marker="o")
    logarithmic(axes)
    axes.y.label = "distance RMS, m"
    axes.x.label = "looked ahead, s"
    legend(figure, axes, followed)
    return figure
