"""Linear model of a trimmed aircraft by central differences, with named states and inputs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from aircraft.airframe import Airframe, InitialCondition
from aircraft.trim import Trim

LONGITUDINAL = ("airspeed", "angle_of_attack", "pitch_rate", "pitch", "height")
LATERAL = ("sideslip", "roll_rate", "yaw_rate", "bank", "heading")
STATES = LONGITUDINAL + LATERAL
INPUTS = ("throttle", "elevator", "aileron", "rudder")
STEPS = {"airspeed": 0.1, "height": 1.0} | {name: 1e-3 for name in STATES if name not in ("airspeed", "height")}
INPUT_STEP = 5e-3  # share of full control


@dataclass(frozen=True)
class LinearModel:
    """x' = A x + B u about a trim; SI, radians, controls -1..1 and 0..1.

    Surfaces and power follow their commands at once here: actuator and engine lags are those of the airframe.
    """

    A: Any  # (10, 10)
    B: Any  # (10, 4)
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    trim: Trim

    def part(self, states: tuple[str, ...], inputs: tuple[str, ...]) -> tuple[Any, Any]:
        """(A, B) of some states and inputs, in the wanted order."""
        rows = [self.states.index(name) for name in states]
        columns = [self.inputs.index(name) for name in inputs]
        return self.A[np.ix_(rows, rows)], self.B[np.ix_(rows, columns)]


def linearise(airframe: Airframe, trim: Trim) -> LinearModel:
    """Central differences of the airframe's own equations about ``trim``.

    ``airframe`` must not have flown. Heading and height are kinematic states; the density gradient is in the column of
    height.
    """
    values = _values(trim.initial)

    def rates(states: dict[str, float], controls: Any) -> np.ndarray:
        return _rates(airframe, _condition(trim.initial, states, controls))

    columns = []
    for name in STATES:
        step = STEPS[name]
        above = rates(values | {name: values[name] + step}, trim.controls)
        below = rates(values | {name: values[name] - step}, trim.controls)
        columns.append((above - below) / (2.0 * step))
    inputs = []
    for name in INPUTS:
        value = getattr(trim.controls, name)
        above = rates(values, trim.controls._replace(**{name: value + INPUT_STEP}))
        below = rates(values, trim.controls._replace(**{name: value - INPUT_STEP}))
        inputs.append((above - below) / (2.0 * INPUT_STEP))
    airframe.begin(trim.initial)
    return LinearModel(np.column_stack(columns), np.column_stack(inputs), STATES, INPUTS, trim)


def _values(initial: InitialCondition) -> dict[str, float]:
    return {name: getattr(initial, name) for name in STATES}


def _condition(initial: InitialCondition, states: dict[str, float], controls: Any) -> InitialCondition:
    return initial._replace(controls=controls, **states)


def _rates(airframe: Airframe, condition: InitialCondition) -> np.ndarray:
    """Rates of STATES: the six accelerations of the airframe turned into air-path rates, and the kinematics."""
    state = airframe.begin(condition)
    du, dv, dw, roll, pitch, yaw = airframe.accelerations()
    cos_alpha, sin_alpha = math.cos(state.angle_of_attack), math.sin(state.angle_of_attack)
    cos_beta, sin_beta = math.cos(state.sideslip), math.sin(state.sideslip)
    along = cos_beta * (du * cos_alpha + dw * sin_alpha) + dv * sin_beta
    alpha = (dw * cos_alpha - du * sin_alpha) / (state.airspeed * cos_beta)
    beta = (dv - along * sin_beta) / (state.airspeed * cos_beta)
    turning = state.pitch_rate * math.sin(state.bank) + state.yaw_rate * math.cos(state.bank)
    heading = turning / math.cos(state.pitch)
    bank = state.roll_rate + math.tan(state.pitch) * turning
    attitude = state.pitch_rate * math.cos(state.bank) - state.yaw_rate * math.sin(state.bank)
    return np.array(
        [along, alpha, pitch, attitude, state.velocity_up, beta, roll, yaw, bank, heading],
    )
