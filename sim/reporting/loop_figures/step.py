"""What the bank does after a step of its command, and the aircraft after a step of its line, inside all limits."""

from __future__ import annotations

import math

import numpy as np

from autopilot.linear_systems import after_step, bank_system, closed_system
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import BANK, CROSS_TRACK, STEP, RouteLoop
from sim.reporting.drawing.figure import Drawing
from sim.reporting.figures import style

BANK_STEP, LINE_STEP = math.radians(1.0), 10.0  # rad and m: linear, so that any other is in proportion
BANK_TIMES, LINE_TIMES = 20.0, 12.0  # of the time constants of bank loop and law that are shown


def step(loop: RouteLoop, law: LateralNavigation) -> Drawing:
    """Panels: bank for its command; cross-track and bank for a line that is displaced."""
    figure, panels = style.panels(1.3, 1.3, 1.3, share=False, top=style.TITLE + style.TOP, gap=0.6)
    for panel in panels:
        panel.x.label = "time, s"
    time = STEP * np.arange(round(BANK_TIMES / loop.bandwidth / STEP) + 1)
    bank = np.degrees(after_step(bank_system(loop), BANK_STEP, time)[BANK])
    panels[0].line(time, bank, colour=style.BLUE)
    panels[0].rule(y=math.degrees(BANK_STEP), colour=style.GREY)
    panels[0].y.label = "bank, deg"
    panels[0].title = "bank after a step of its command by 1 deg"
    time = STEP * np.arange(round(LINE_TIMES / law.frequency / STEP) + 1)
    outputs = after_step(closed_system(loop, law), LINE_STEP, time)
    panels[1].line(time, outputs[CROSS_TRACK], colour=style.BLUE)
    panels[1].rule(y=LINE_STEP, colour=style.GREY)
    panels[1].y.label, panels[1].title = "cross-track, m", f"the aircraft after a step of its line by {LINE_STEP:.0f} m"
    panels[2].line(time, np.degrees(outputs[BANK]), colour=style.BLUE)
    panels[2].y.label = "bank, deg"
    return figure
