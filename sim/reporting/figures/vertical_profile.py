"""The flight from the side: height over the distance flown, the glide path, the flare."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.metrics.signals import height_error
from sim.reporting.figures import style
from sim.reporting.figures.curves import by_phase, pad
from sim.reporting.figures.thinning import peaks
from sim.scenario.tables import Runway

FLARE_SHOWN = 30.0  # m, height at which the picture of the flare begins


def vertical_profile(flight: Flight, runway: Runway) -> Any:
    """Figure of the height and the commanded height over the distance flown."""
    state = flight.state
    figure, (axes,) = style.panels(1.5)
    flown = _distance_flown(flight) * 1e-3
    wanted = state.height - height_error(flight, runway)
    chosen = peaks(wanted)
    axes.plot(flown[chosen], wanted[chosen], color="#C8C8C8", linewidth=4.5, label="height of the leg, then glide path")
    by_phase(axes, flight, flown, state.height)
    pad(axes, 20.0)
    axes.set_xlabel("distance flown, km")
    axes.set_ylabel("height above threshold, m")
    axes.legend(loc="lower left")
    return figure


def touchdown_view(flight: Flight, runway: Runway) -> Any | None:
    """Figure of the last metres of height over the runway; None for a flight that never came so low."""
    low = flight.during(("glide", "flare", "ground")) & (flight.state.height < FLARE_SHOWN)
    if not low.any():
        return None
    past, _ = runway.from_local(flight.state.north, flight.state.east)
    figure, (axes,) = style.panels(1.7)
    glide = np.array((np.nanmin(past[low]), runway.aiming_point))
    axes.plot(
        glide,
        (runway.aiming_point - glide) * np.tan(runway.glide_path),
        color="#555555",
        linewidth=0.8,
        dashes=(5, 3),
        label="glide path",
    )
    by_phase(axes, flight, past, flight.state.height, low)
    axes.axhline(0.0, color=style.BLACK, linewidth=0.6)
    axes.plot([0.0], [0.0], "|", color=style.BLACK, markersize=12, markeredgewidth=2, label="threshold")
    axes.plot(
        [runway.aiming_point], [0.0], "^", color="white", markeredgecolor="#555555", markersize=6, label="aiming point"
    )
    contact = np.flatnonzero(flight.state.main_wheels > 0)
    if contact.size:
        at = contact[0]
        axes.plot(
            [past[at]],
            [flight.state.height[at]],
            "v",
            color=style.VERMILION,
            markersize=7,
            label="first contact of a main wheel",
        )
    pad(axes, 5.0)
    axes.set_xlabel("distance past the threshold, m")
    axes.set_ylabel("height, m")
    axes.legend(loc="upper right")
    return figure


def _distance_flown(flight: Flight) -> np.ndarray:
    """Length of the track over the ground since the start, m."""
    step = np.hypot(np.diff(flight.state.north), np.diff(flight.state.east))
    return np.concatenate(([0.0], np.cumsum(step)))
