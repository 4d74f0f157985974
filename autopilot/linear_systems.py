"""The linear loops as python-control systems whose states, inputs and outputs have names with their units."""

from __future__ import annotations

from typing import Any

import numpy as np

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import STEP, RouteLoop, law_row

UNITS = {  # of the aircraft's states, behind their names; its inputs are shares of full travel
    "airspeed": "mps",
    "angle_of_attack": "rad",
    "pitch_rate": "radps",
    "pitch": "rad",
    "height": "m",
    "sideslip": "rad",
    "roll_rate": "radps",
    "yaw_rate": "radps",
    "bank": "rad",
    "heading": "rad",
}
LOOP_STATES = (  # of the sampled loop, in the order of ``autopilot.route_loop``
    *("sideslip_rad", "roll_rate_radps", "yaw_rate_radps", "bank_rad", "heading_rad", "cross_track_m"),
    *("aileron", "rudder", "aileron_before", "rudder_before", "bank_reference_rad", "bank_reference_rate_radps"),
    *("aileron_sum", "rudder_sum"),
)
LOOP_OUTPUTS = ["bank_rad", "cross_track_m", "cross_track_rate_mps", "aileron_command"]


def aircraft_system(A: Any, B: Any, states: tuple[str, ...], inputs: tuple[str, ...]) -> Any:
    """x' = A x + B u of an aircraft about its trim as a ``control.StateSpace`` that shows every state."""
    import control

    names = [f"{name}_{UNITS[name]}" for name in states]
    size = len(names)
    return control.ss(
        A,
        B,
        np.eye(size),
        np.zeros((size, len(inputs))),
        states=names,
        inputs=list(inputs),
        outputs=names,
        name="aircraft",
    )


def bank_system(loop: RouteLoop) -> Any:
    """From the bank command to bank, cross-track, its rate and the aileron, sampled at the autopilot's 30 Hz."""
    import control

    return control.ss(
        loop.A,
        loop.B[:, None],
        loop.C,
        loop.D[:, None],
        STEP,
        states=list(LOOP_STATES),
        inputs=["bank_command_rad"],
        outputs=LOOP_OUTPUTS,
        name="bank_loop",
    )


def opened_system(loop: RouteLoop, law: LateralNavigation) -> Any:
    """The route loop opened at the bank command, with the sign of negative feedback: 1 + L = 0 is its stability."""
    import control

    return control.ss(
        loop.A,
        loop.B[:, None],
        -law_row(loop, law)[None, :],
        0.0,
        STEP,
        states=list(LOOP_STATES),
        inputs=["bank_command_rad"],
        outputs=["minus_law_rad"],
        name="opened_route_loop",
    )


def closed_system(loop: RouteLoop, law: LateralNavigation) -> Any:
    """The route loop closed inside the limits of the law; its input is the line that is flown, m right of the leg.

    The bank command is k1 (line - z) - k2 z', so that the line is where the aircraft settles.
    """
    import control

    row = law_row(loop, law)
    return control.ss(
        loop.A + np.outer(loop.B, row),
        law.k1 * loop.B[:, None],
        loop.C + np.outer(loop.D, row),
        law.k1 * loop.D[:, None],
        STEP,
        states=list(LOOP_STATES),
        inputs=["line_m"],
        outputs=LOOP_OUTPUTS,
        name="route_loop",
    )


def after_step(system: Any, size: float, time: Any) -> Any:
    """(outputs, k) of a system of one input at the instants ``time`` (k,) after a step of its input from rest."""
    import control

    return size * control.step_response(system, time).outputs[:, 0]
