"""The figures of a flight, in the order of the page."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.reporting.drawing.figure import Drawing
from sim.reporting.figures.histories import (
    airframe_history,
    bank_history,
    error_history,
    final_errors,
    motion_history,
    speed_history,
)
from sim.reporting.figures.phase_portrait import phase_portrait
from sim.reporting.figures.plan_view import plan_view
from sim.reporting.figures.style import Chart
from sim.reporting.figures.vertical_profile import touchdown_view, vertical_profile
from sim.reporting.figures.weather import weather_charts

# captions of what a law without limits does not have
BARS = " Bars below: when the command, and when each input of the law as flown, was at or beyond its limit."
REGIONS = (
    " Shaded: the law asks for its bank limit. Between the dotted lines an input is passed on as it is, beyond them it "
    "is cut off; where the first input is cut off, the law settles on the line of wings level: the intercept."
)


def charts(flight: Flight, scenario: Any, law: Any) -> list[Chart]:
    """All figures of a flight that has something to show in them."""
    bank_limit, whole = scenario.autopilot.bank_limit, flight.whole
    steady = None if flight.is_recorded else scenario.wind.steady
    drawn: list[Chart] = []

    def add(title: str, figure: Drawing, caption: str) -> None:
        drawn.append(Chart(title, figure, caption))

    with np.errstate(invalid="ignore"):
        add(
            "Plan view",
            plan_view(whole, scenario.runway, steady, scenario.wind.events, scenario.sensors),
            "Equal scales; turned so that the final course runs to the right, north as the arrow shows. The runway's "
            "length is drawn, not modelled. Dotted: what a sensor covers; a cross is its antenna.",
        )
        add("Vertical profile", vertical_profile(whole, scenario.runway), "Heights are exaggerated against distances.")
        touchdown = touchdown_view(flight, scenario.runway)
        if touchdown is not None:
            add(
                "Flare and touchdown",
                touchdown,
                "Height of the aircraft's reference point; it stays above the ground when the wheels touch.",
            )
        if flight.is_recorded:
            add(
                "Motion",
                motion_history(whole, bank_limit),
                "As recorded and smoothed: bank by the turn over the ground in still air, with the limit that trackers "
                "are told; speed over the ground; rate of climb. What else the aircraft did nobody recorded.",
            )
        else:
            add(
                "Bank and its limits",
                bank_history(flight, law, bank_limit),
                "Shaded: the command is at the bank limit." + (BARS if law.limits() else ""),
            )
        add(
            "Phase portrait of the law",
            phase_portrait(flight, law),
            "Coloured line: the flown deviations, by phase, each leg begun at a circle."
            + (REGIONS if law.limits() else ""),
        )
        if not flight.is_recorded:
            add(
                "Speed and configuration",
                speed_history(whole),
                "True airspeed against its schedule, and the equivalent airspeed, which the wing feels and an "
                "indicator shows; flaps and gear as they moved.",
            )
        airframe = airframe_history(whole)
        if airframe is not None:
            add(
                "Airframe",
                airframe,
                "Attitude, path and controls of the six-degree-of-freedom aircraft.",
            )
        add(
            "Deviations",
            error_history(flight, scenario.runway),
            "Cross-track from the leg then active; height from the height of the leg, on the glide path from the path.",
        )
        for title, figure, caption in weather_charts(flight, scenario):
            add(title, figure, caption)
        last = final_errors(flight, scenario.runway)
        if last is not None:
            add(
                last[0],
                last[1],
                "The last stretch enlarged; the aircraft flies to the right. Scaled to what follows the capture.",
            )
    return drawn
