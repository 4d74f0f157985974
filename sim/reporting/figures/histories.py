"""Records over time: bank against its limits, speed and configuration, deviations from the path."""

from __future__ import annotations

from typing import Any

import numpy as np

from autopilot.mode import Mode
from sim.flight.record import Flight
from sim.metrics.figures import GLIDE_CAPTURE
from sim.metrics.signals import height_error
from sim.reporting.figures import style
from sim.reporting.figures.curves import by_phase, over_time, pad, phase_strip
from sim.reporting.figures.deviations import BANK, COMPONENTS, acting_limits
from sim.reporting.figures.thinning import where
from sim.scenario.tables import Runway

STRIP = 0.17  # in, height of the strip of phases
TIME = "time, s"
STRETCHES = {"Deviations on the glide path": ("glide", "flare"), "Deviations on the final leg": ("final",)}
LEAST_SCALE = 0.25  # m, so that hundredths do not look like errors


def bank_history(flight: Flight, law: Mode, bank_limit: float) -> Any:
    """Figure of bank and its command; below, when each limit of the law was reached."""
    acting = acting_limits(flight, law, bank_limit)
    limiters = {COMPONENTS[name].short if name in COMPONENTS else name: where for name, where in acting.items()}
    figure, (strip, axes, bars) = style.panels(STRIP, 1.9, 0.2 * len(limiters))
    phase_strip(strip, flight)
    limit = float(np.degrees(bank_limit))
    for side in (-limit, limit):
        axes.axhline(
            side, color=style.VERMILION, linewidth=0.8, dashes=(4, 3), label="bank limit" if side > 0 else None
        )
    over_time(axes, flight, np.degrees(flight.command.bank), color=style.BLACK, linewidth=0.9, label="command")
    over_time(axes, flight, np.degrees(flight.state.bank), color=style.BLUE, linewidth=1.3, label="bank")
    pad(axes, 2.0, 0.17)
    full = axes.get_xaxis_transform()
    axes.broken_barh(_spans(flight, acting[BANK]), (0, 1), transform=full, color=style.ORANGE, alpha=0.25, linewidth=0)
    axes.set_ylabel("bank, deg (+ right)")
    axes.legend(loc="upper right", ncols=3)
    colours = {"bank": style.ORANGE}
    _bars(bars, flight, {f"{n} limited": (reached, colours.get(n, style.SKY)) for n, reached in limiters.items()})
    return figure


def _spans(flight: Flight, mask: np.ndarray) -> list[tuple[float, float]]:
    """(begin, width) in s of the stretches of a mask; an instant is as wide as a line."""
    return [(flight.time[a], max(flight.time[b - 1] - flight.time[a], 1e-3)) for a, b in where(mask)]


def _bars(axes: Any, flight: Flight, rows: dict[str, tuple[np.ndarray, str]]) -> None:
    """One row for each name, with a bar wherever its mask is True."""
    for row, (mask, colour) in enumerate(rows.values()):
        axes.broken_barh(_spans(flight, mask), (row + 0.15, 0.7), color=colour, linewidth=0)
    axes.set_ylim(len(rows), 0)
    axes.set_yticks(np.arange(len(rows)) + 0.5, list(rows), fontsize=6)
    axes.grid(False, axis="y")
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(TIME)


def motion_history(flight: Flight, bank_limit: float) -> Any:
    """Figure of what is known of a recorded flight: bank, ground speed, rate of climb; ``bank_limit`` in rad."""
    state = flight.state
    figure, (strip, bank, speed, vertical) = style.panels(STRIP, 1.4, 1.0, 0.9)
    phase_strip(strip, flight)
    for side in (-1.0, 1.0):
        bank.axhline(side * np.degrees(bank_limit), color=style.VERMILION, linewidth=0.8, dashes=(4, 3))
    for axes, values, label in (
        (bank, np.degrees(state.bank), "bank, deg (+ right)"),
        (speed, state.ground_speed, "ground speed, m/s"),
        (vertical, state.velocity_up, "climb, m/s"),
    ):
        over_time(axes, flight, values, color=style.BLUE, linewidth=1.3)
        pad(axes, 4.0)
        axes.set_ylabel(label)
    vertical.set_xlabel(TIME)
    return figure


def speed_history(flight: Flight) -> Any:
    """Figure of true airspeed against its schedule, equivalent airspeed, ground speed, flaps and gear."""
    state = flight.state
    figure, (strip, axes, settings, bars) = style.panels(STRIP, 1.7, 0.7, 0.2)
    phase_strip(strip, flight)
    over_time(axes, flight, state.ground_speed, color=style.GREY, linewidth=0.9, label="ground speed")
    over_time(axes, flight, flight.command.airspeed, color=style.BLACK, linewidth=0.9, label="true airspeed asked for")
    over_time(axes, flight, state.airspeed, color=style.BLUE, linewidth=1.3, label="true airspeed")
    over_time(axes, flight, state.equivalent_airspeed, color=style.SKY, linewidth=0.9, label="equivalent airspeed")
    pad(axes, 10.0)
    axes.set_ylabel("speed, m/s")
    axes.legend(loc="lower left", ncols=2)
    over_time(settings, flight, np.degrees(state.flaps), color=style.BLUE)
    settings.set_ylabel("flaps, deg")
    settings.set_ylim(-4, 46)
    _bars(bars, flight, {"gear down": (np.asarray(state.gear) > 0.99, style.GREEN)})
    return figure


def airframe_history(flight: Flight) -> Any | None:
    """Figure of what only a whole aircraft has: incidence, vertical speed, load factor, controls; None for a point."""
    state = flight.state
    if flight.is_recorded or (not np.any(state.elevator) and not np.any(state.throttle)):
        return None
    figure, (strip, angles, vertical, controls) = style.panels(STRIP, 1.1, 1.0, 1.2)
    phase_strip(strip, flight)
    over_time(angles, flight, np.degrees(state.pitch), color=style.BLUE, label="pitch")
    over_time(angles, flight, np.degrees(state.angle_of_attack), color=style.ORANGE, label="angle of attack")
    over_time(angles, flight, np.degrees(state.sideslip), color=style.GREEN, label="sideslip")
    angles.set_ylabel("angle, deg")
    over_time(vertical, flight, state.velocity_up, color=style.BLUE)
    vertical.set_ylabel("climb, m/s")
    for name, colour in (
        ("throttle", style.BLACK), ("elevator", style.BLUE), ("aileron", style.VERMILION), ("rudder", style.GREEN),
    ):  # fmt: skip
        over_time(controls, flight, getattr(state, name), color=colour, linewidth=0.9, label=name)
    controls.set_ylabel("share of travel")
    controls.set_xlabel(TIME)
    for axes, least in ((angles, 4.0), (vertical, 2.0), (controls, 0.4)):
        pad(axes, least, 0.2 if axes is not vertical else 0.08)
        axes.axhline(0.0, color=style.BLACK, linewidth=0.5, zorder=1)
    angles.legend(loc="upper left", ncols=3)
    controls.legend(loc="upper left", ncols=4)
    return figure


def error_history(flight: Flight, runway: Runway) -> Any:
    """Figure of cross-track and height error over the whole flight, against the leg then active."""
    figure, (strip, across, above) = style.panels(STRIP, 1.25, 1.25)
    phase_strip(strip, flight)
    by_phase(across, flight, flight.time, flight.deviation.cross_track, joined=False)
    across.set_ylabel("cross-track, m (+ right)")
    pad(across, 10.0)
    by_phase(above, flight, flight.time, height_error(flight, runway), joined=False)
    above.set_ylabel("height error, m")
    pad(above, 4.0)
    above.set_xlabel(TIME)
    for axes in (across, above):
        axes.axhline(0.0, color=style.BLACK, linewidth=0.5, zorder=1)
    return figure


def final_errors(flight: Flight, runway: Runway) -> tuple[str, Any] | None:
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
        axes.set_ylabel(name)
        settled = error[captured if np.isfinite(error[captured]).any() else among]
        half = 1.3 * max(float(np.nanmax(np.abs(settled), initial=0.0)), LEAST_SCALE)
        axes.set_ylim(-half, half)
        axes.axhline(0.0, color=style.BLACK, linewidth=0.5, zorder=1)
    far, near = float(np.nanmax(to_go[among])), float(np.nanmin(to_go[among]))
    panels[1].set_xlim(max(far, near + 1e-3), near)
    panels[1].set_xlabel("distance to the end of the leg, km")
    return title, figure
