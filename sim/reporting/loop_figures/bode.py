"""Gain and phase of the route loop, opened at the bank command, with its margins."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import STEP, RouteLoop, law_response, margins
from sim.reporting.drawing.figure import Drawing
from sim.reporting.drawing.scales import LOGARITHMIC
from sim.reporting.figures import style

POINTS = 600


def bode(loop: RouteLoop, law: LateralNavigation) -> Drawing:
    """Two panels over the frequency: gain in dB, and phase, which begins at -180 deg for a double integrator."""
    natural = float(law.frequency)
    frequency = np.geomspace(0.05 * natural, 0.99 * math.pi / STEP, POINTS)
    response = -law_response(loop, law, frequency)
    gain, phase = 20.0 * np.log10(np.abs(response)), np.degrees(unwound(response))
    found = margins(loop, law)
    figure, (upper, lower) = style.panels(1.7, 1.7, top=style.TITLE + style.TOP)
    upper.x.scale = LOGARITHMIC
    upper.line(frequency, gain, colour=style.BLUE)
    upper.rule(y=0.0, colour=style.GREY)
    lower.line(frequency, phase, colour=style.BLUE)
    lower.rule(y=-180.0, colour=style.GREY)
    for panel in (upper, lower):
        panel.rule(x=found.gain_crossover, colour=style.GREEN, dashes=style.BROKEN)
        panel.rule(x=found.phase_crossover, colour=style.VERMILION, dashes=style.BROKEN)
    upper.title = (
        f"gain margin {20.0 * math.log10(found.gain):.1f} dB at {found.phase_crossover:.2f} rad/s, "
        f"phase margin {math.degrees(found.phase):.0f} deg at {found.gain_crossover:.3f} rad/s"
    )
    upper.y.label, lower.y.label, lower.x.label = "gain, dB", "phase, deg", "frequency, rad/s"
    return figure


def unwound(response: Any) -> Any:
    """Phase, rad, without steps, from that of a double integrator on."""
    phase = np.unwrap(np.angle(response))
    return phase - 2.0 * math.pi * round((phase[0] + math.pi) / (2.0 * math.pi))
