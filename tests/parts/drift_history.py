"""A figure of the report: the angle between where the nose points and where the aircraft goes."""

from __future__ import annotations

import numpy as np

from sim.flight.record import Flight
from sim.reporting.drawing.figure import Drawing
from sim.reporting.figures import style
from sim.reporting.figures.curves import over_time, pad, phase_strip

STRIP = 0.17  # in, of the names of the phases
CALM = np.radians(0.1)  # rad; a flight that never drifts more has nothing to show


def drift_history(flight: Flight) -> Drawing | None:
    """Figure of the drift angle over time; None for a flight in air that does not move across it."""
    drift = np.angle(np.exp(1j * (flight.state.course - flight.state.heading)))
    if np.abs(drift).max() < CALM:
        return None
    figure, (strip, axes) = style.panels(STRIP, 1.5)
    phase_strip(strip, flight)
    over_time(axes, flight, np.degrees(drift), colour=style.BLUE)
    pad(axes, 2.0)
    axes.x.label = "time, s"
    axes.y.label = "drift, deg (+ right)"
    return figure
