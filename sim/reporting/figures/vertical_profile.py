"""The flight from the side: height over the distance flown, the glide path, the flare."""

from __future__ import annotations

import numpy as np

from sim.flight.record import Flight
from sim.metrics.signals import height_error
from sim.reporting.drawing.figure import Drawing, Legend
from sim.reporting.drawing.marks import PAPER
from sim.reporting.figures import style
from sim.reporting.figures.curves import by_phase, pad
from sim.reporting.figures.thinning import peaks
from sim.scenario.tables import Runway

FLARE_SHOWN = 30.0  # m, height at which the picture of the flare begins


def vertical_profile(flight: Flight, runway: Runway) -> Drawing:
    """Figure of the height and the commanded height over the distance flown."""
    state = flight.state
    figure, (axes,) = style.panels(1.5)
    flown = _distance_flown(flight) * 1e-3
    wanted = state.height - height_error(flight, runway)
    chosen = peaks(wanted)
    axes.line(flown[chosen], wanted[chosen], colour="#C8C8C8", width=4.5, label="height of the leg, then glide path")
    by_phase(axes, flight, flown, state.height)
    pad(axes, 20.0)
    axes.x.label = "distance flown, km"
    axes.y.label = "height above threshold, m"
    axes.legend = Legend("lower left")
    return figure


def touchdown_view(flight: Flight, runway: Runway) -> Drawing | None:
    """Figure of the last metres of height over the runway; None for a flight that never came so low."""
    low = flight.during(("glide", "flare", "ground")) & (flight.state.height < FLARE_SHOWN)
    if not low.any():
        return None
    past, _ = runway.from_local(flight.state.north, flight.state.east)
    figure, (axes,) = style.panels(1.7)
    glide = np.array((np.nanmin(past[low]), runway.aiming_point))
    axes.line(
        glide,
        (runway.aiming_point - glide) * np.tan(runway.glide_path),
        colour="#555555",
        width=0.8,
        dashes=(5, 3),
        label="glide path",
    )
    by_phase(axes, flight, past, flight.state.height, low)
    axes.rule(y=0.0, width=0.6)
    axes.points(0.0, 0.0, marker="|", size=12.0, stroke=2.0, label="threshold")
    axes.points(runway.aiming_point, 0.0, colour="#555555", marker="^", size=6.0, fill=PAPER, label="aiming point")
    contact = np.flatnonzero(flight.state.main_wheels > 0)
    if contact.size:
        at = contact[0]
        axes.points(
            past[at],
            flight.state.height[at],
            colour=style.VERMILION,
            marker="v",
            size=7.0,
            label="first contact of a main wheel",
        )
    pad(axes, 5.0)
    axes.x.label = "distance past the threshold, m"
    axes.y.label = "height, m"
    axes.legend = Legend("upper right")
    return figure


def _distance_flown(flight: Flight) -> np.ndarray:
    """Length of the track over the ground since the start, m."""
    step = np.hypot(np.diff(flight.state.north), np.diff(flight.state.east))
    return np.concatenate(([0.0], np.cumsum(step)))
