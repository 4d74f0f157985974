"""Records over time: bank against its limits, speed and configuration, deviations from the path."""

from __future__ import annotations

import numpy as np

from autopilot.mode import Mode
from sim.flight.record import Flight
from sim.metrics.figures import GLIDE_CAPTURE
from sim.metrics.signals import height_error
from sim.reporting.drawing.figure import Drawing, Legend, Panel
from sim.reporting.figures import style
from sim.reporting.figures.curves import by_phase, over_time, pad, phase_strip
from sim.reporting.figures.deviations import BANK, COMPONENTS, acting_limits
from sim.reporting.figures.thinning import where
from sim.scenario.tables import Runway

STRIP = 0.17  # in, height of the strip of phases
TIME = "time, s"
STRETCHES = {"Deviations on the glide path": ("glide", "flare"), "Deviations on the final leg": ("final",)}
LEAST_SCALE = 0.25  # m, so that hundredths do not look like errors


def bank_history(flight: Flight, law: Mode, bank_limit: float) -> Drawing:
    """Figure of bank and its command; below, when each limit of the law was reached."""
    acting = acting_limits(flight, law, bank_limit)
    limiters = {COMPONENTS[name].short if name in COMPONENTS else name: where for name, where in acting.items()}
    figure, (strip, axes, bars) = style.panels(STRIP, 1.9, 0.2 * len(limiters))
    phase_strip(strip, flight)
    limit = float(np.degrees(bank_limit))
    for side in (-limit, limit):
        label = "bank limit" if side > 0 else ""
        axes.rule(y=side, colour=style.VERMILION, width=0.8, dashes=(4, 3), label=label)
    over_time(axes, flight, np.degrees(flight.command.bank), colour=style.BLACK, width=0.9, label="command")
    over_time(axes, flight, np.degrees(flight.state.bank), colour=style.BLUE, width=1.3, label="bank")
    pad(axes, 2.0, 0.17)
    begin, end = _spans(flight, acting[BANK])
    axes.blocks(begin, end, -np.inf, np.inf, style.ORANGE, alpha=0.25)
    axes.y.label = "bank, deg (+ right)"
    axes.legend = Legend("upper right", 3)
    colours = {"bank": style.ORANGE}
    _bars(bars, flight, {f"{n} limited": (reached, colours.get(n, style.SKY)) for n, reached in limiters.items()})
    return figure


def _spans(flight: Flight, mask: np.ndarray) -> np.ndarray:
    """(2, n) s, begin and end of the stretches of a mask."""
    return np.array([(flight.time[a], flight.time[b - 1]) for a, b in where(mask)]).reshape(-1, 2).T


def _bars(axes: Panel, flight: Flight, rows: dict[str, tuple[np.ndarray, str]]) -> None:
    """One row for each name, with a bar wherever its mask is True."""
    for row, (mask, colour) in enumerate(rows.values()):
        begin, end = _spans(flight, mask)
        axes.blocks(begin, end, row + 0.15, row + 0.85, colour)
    axes.y.limits = len(rows), 0.0
    axes.y.ticks, axes.y.size = [(row + 0.5, name) for row, name in enumerate(rows)], 6.0
    axes.grid = "x"
    axes.x.label = TIME


def motion_history(flight: Flight, bank_limit: float) -> Drawing:
    """Figure of what is known of a recorded flight: bank, ground speed, rate of climb; ``bank_limit`` in rad."""
    state = flight.state
    figure, (strip, bank, speed, vertical) = style.panels(STRIP, 1.4, 1.0, 0.9)
    phase_strip(strip, flight)
    for side in (-1.0, 1.0):
        bank.rule(y=side * np.degrees(bank_limit), colour=style.VERMILION, width=0.8, dashes=(4, 3))
    for axes, values, label in (
        (bank, np.degrees(state.bank), "bank, deg (+ right)"),
        (speed, state.ground_speed, "ground speed, m/s"),
        (vertical, state.velocity_up, "climb, m/s"),
    ):
        over_time(axes, flight, values, colour=style.BLUE, width=1.3)
        pad(axes, 4.0)
        axes.y.label = label
    vertical.x.label = TIME
    return figure


def speed_history(flight: Flight) -> Drawing:
    """Figure of true airspeed against its schedule, equivalent airspeed, ground speed, flaps and gear."""
    state = flight.state
    figure, (strip, axes, settings, bars) = style.panels(STRIP, 1.7, 0.7, 0.2)
    phase_strip(strip, flight)
    over_time(axes, flight, state.ground_speed, colour=style.GREY, width=0.9, label="ground speed")
    over_time(axes, flight, flight.command.airspeed, colour=style.BLACK, width=0.9, label="true airspeed asked for")
    over_time(axes, flight, state.airspeed, colour=style.BLUE, width=1.3, label="true airspeed")
    over_time(axes, flight, state.equivalent_airspeed, colour=style.SKY, width=0.9, label="equivalent airspeed")
    pad(axes, 10.0)
    axes.y.label = "speed, m/s"
    axes.legend = Legend("lower left", 2)
    over_time(settings, flight, np.degrees(state.flaps), colour=style.BLUE)
    settings.y.label = "flaps, deg"
    settings.y.limits = -4, 46
    _bars(bars, flight, {"gear down": (np.asarray(state.gear) > 0.99, style.GREEN)})
    return figure


def airframe_history(flight: Flight) -> Drawing | None:
    """Figure of what only a whole aircraft has: incidence, vertical speed, load factor, controls; None for a point."""
    state = flight.state
    if flight.is_recorded or (not np.any(state.elevator) and not np.any(state.throttle)):
        return None
    figure, (strip, angles, vertical, controls) = style.panels(STRIP, 1.1, 1.0, 1.2)
    phase_strip(strip, flight)
    over_time(angles, flight, np.degrees(state.pitch), colour=style.BLUE, label="pitch")
    over_time(angles, flight, np.degrees(state.angle_of_attack), colour=style.ORANGE, label="angle of attack")
    over_time(angles, flight, np.degrees(state.sideslip), colour=style.GREEN, label="sideslip")
    angles.y.label = "angle, deg"
    over_time(vertical, flight, state.velocity_up, colour=style.BLUE)
    vertical.y.label = "climb, m/s"
    for name, colour in (
        ("throttle", style.BLACK), ("elevator", style.BLUE), ("aileron", style.VERMILION), ("rudder", style.GREEN),
    ):  # fmt: skip
        over_time(controls, flight, getattr(state, name), colour=colour, width=0.9, label=name)
    controls.y.label = "share of travel"
    controls.x.label = TIME
    for axes, least in ((angles, 4.0), (vertical, 2.0), (controls, 0.4)):
        pad(axes, least, 0.2 if axes is not vertical else 0.08)
        axes.rule(y=0.0, order=1.0)
    angles.legend = Legend("upper left", 3)
    controls.legend = Legend("upper left", 4)
    return figure


def error_history(flight: Flight, runway: Runway) -> Drawing:
    """Figure of cross-track and height error over the whole flight, against the leg then active."""
    figure, (strip, across, above) = style.panels(STRIP, 1.25, 1.25)
    phase_strip(strip, flight)
    by_phase(across, flight, flight.time, flight.deviation.cross_track, joined=False)
    across.y.label = "cross-track, m (+ right)"
    pad(across, 10.0)
    by_phase(above, flight, flight.time, height_error(flight, runway), joined=False)
    above.y.label = "height error, m"
    pad(above, 4.0)
    above.x.label = TIME
    for axes in (across, above):
        axes.rule(y=0.0, order=1.0)
    return figure


def final_errors(flight: Flight, runway: Runway) -> tuple[str, Drawing] | None:
    """Title and figure of both errors on the last stretch, over the distance to the end of the leg.

    The stretch is the glide path down to the ground, else the final leg; None where neither was flown. The scale is
    that of the time after the capture, which may leave the frame.
    """
    flown = {title: flight.during(phases) for title, phases in STRETCHES.items()}
    title = next((title for title, among in flown.items() if among.sum() > 1), None)
    if title is None:
        return None
    among = flown[title]
    to_go = flight.deviation.distance_to_go * 1e-3
    captured = among & (flight.time >= flight.time[among][0] + GLIDE_CAPTURE)
    figure, panels = style.panels(1.25, 1.25)
    errors = (flight.deviation.cross_track, height_error(flight, runway))
    for axes, error, name in zip(panels, errors, ("cross-track, m (+ right)", "height error, m"), strict=True):
        by_phase(axes, flight, to_go, error, among, joined=False)
        axes.y.label = name
        settled = error[captured if np.isfinite(error[captured]).any() else among]
        half = 1.3 * max(float(np.nanmax(np.abs(settled), initial=0.0)), LEAST_SCALE)
        axes.y.limits = -half, half
        axes.rule(y=0.0, order=1.0)
    far, near = float(np.nanmax(to_go[among])), float(np.nanmin(to_go[among]))
    panels[1].x.limits = max(far, near + 1e-3), near
    panels[1].x.label = "distance to the end of the leg, km"
    return title, figure
