"""The route loop as it is flown: the linear aircraft behind sampled inner loops, held controls and their delays.

Inside its limits the loop is a linear sampled-data system, so its stability is that of one matrix. Nothing here is
fitted to a flight: the airframe is its linear model, the gains are those of the design, the delays are facts of the
autopilot's clock, of the actuators and of the simulation.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from autopilot.design import Designed, OperatingPoint, law_of_frequency
from autopilot.inner_loops import InnerLoops
from autopilot.modes.lateral_navigation import LateralNavigation

STEP = 1.0 / 30.0  # s, of the autopilot above 60 m
DELAY = 1.5  # steps of the simulation: a control acts one step late on the rates, half a step later on the angles
AT_ONCE = 1000.0  # rad/s; stands for an actuator without lag
SLOWEST, QUICKEST = 0.01, 20.0  # of the bandwidth of the bank loop: natural frequencies of laws that are looked at
CROSSINGS = 4000  # frequencies between which margins are looked for

BANK, CROSS_TRACK, CROSS_TRACK_RATE, AILERON = range(4)  # outputs of the loop


class RouteLoop(NamedTuple):
    """From the bank command to what the law sees, sampled: x+ = A x + B command, y = C x + D command.

    Outputs are bank (rad), cross-track (m), its rate (m/s) and the aileron that is asked for (share of full).
    """

    A: Any  # (n, n)
    B: Any  # (n,)
    C: Any  # (4, n)
    D: Any  # (4,)
    speed: float  # m/s
    bandwidth: float  # rad/s, of the bank loop


def route_loop(point: OperatingPoint, designed: Designed, actuators: tuple[float, float], rate: float) -> RouteLoop:
    """The loop that a design closes around an aircraft in level flight, opened at the bank command.

    Parameters
    ----------
    point : where the leg is flown
    designed : its gains, as the inner loops look them up there
    actuators : rad/s, bandwidths of aileron and rudder; infinite where there is no lag
    rate : Hz, of the simulation
    """
    F, G = _airframe(point, actuators)
    held, moved, late = _sampled(F, G, DELAY / rate)
    plant = len(F)
    size = plant + 2 + 4  # airframe, controls of the step before, reference and its rate, two sums
    A, B = np.zeros((size, size)), np.zeros(size)
    unit = np.eye(size)

    frequency = designed.reference_frequency
    reference, turning, sums = plant + 2, plant + 3, slice(plant + 4, size)
    rate_row = unit[turning] * (1.0 - 2.0 * frequency * STEP) - unit[reference] * frequency**2 * STEP
    rate_command = frequency**2 * STEP
    reference_row, reference_command = unit[reference] + STEP * rate_row, STEP * rate_command

    turn = STANDARD_GRAVITY / point.airspeed
    errors = np.stack([unit[0], unit[1] - rate_row, unit[2] - turn * unit[3], unit[3] - reference_row])
    from_command = np.array([0.0, -rate_command, 0.0, -reference_command])
    gains = InnerLoops(designed).lookup(point.equivalent_airspeed**-2.0, point.flaps).lateral
    K, sum_gains = np.array([gains[0:4], gains[5:9]]), np.array([gains[4], gains[9]])
    control, control_command = unit[sums] - K @ errors, -K @ from_command

    A[:plant, :plant], A[:plant, plant : plant + 2] = held, late
    A[:plant] += moved @ control
    B[:plant] = moved @ control_command
    A[plant : plant + 2], B[plant : plant + 2] = control, control_command
    A[reference], B[reference] = reference_row, reference_command
    A[turning], B[turning] = rate_row, rate_command
    A[sums] = unit[sums] - STEP * np.outer(sum_gains, errors[3])
    B[sums] = -STEP * sum_gains * from_command[3]

    C = np.zeros((4, size))
    C[BANK, 3], C[CROSS_TRACK, 5], C[CROSS_TRACK_RATE, :plant] = 1.0, 1.0, F[5]
    C[AILERON] = control[0]
    D = np.array([0.0, 0.0, 0.0, control_command[0]])
    return RouteLoop(A, B, C, D, point.airspeed, designed.bank_bandwidth)


def lag_loop(lag: float, speed: float) -> RouteLoop:
    """The loop of a point that banks with one lag (s) behind its command and moves across by g times the bank."""

    from scipy.linalg import expm

    A = np.array([[-1.0 / lag, 0.0, 0.0], [0.0, 0.0, 1.0], [STANDARD_GRAVITY, 0.0, 0.0]])
    both = expm(STEP * np.block([[A, np.array([[1.0 / lag], [0.0], [0.0]])], [np.zeros((1, 4))]]))
    return RouteLoop(both[:3, :3], both[:3, 3], np.eye(4, 3), np.zeros(4), speed, 1.0 / lag)


def _airframe(point: OperatingPoint, actuators: tuple[float, float]) -> tuple[Any, Any]:
    """x' = F x + G u: sideslip, roll rate, yaw rate, bank, heading, cross-track, aileron and rudder behind their lags.

    The path turns with the heading and slides with the sideslip; a bank tilts the incidence out of the vertical plane.
    """
    A, B = point.lateral
    F, G = np.zeros((8, 8)), np.zeros((8, 2))
    F[:4, :4], F[:4, 6:] = A, B
    F[4, 2] = 1.0 / math.cos(point.angle_of_attack)
    F[5, [4, 0, 3]] = point.airspeed * np.array([1.0, 1.0, -math.sin(point.angle_of_attack)])
    for row, bandwidth in zip((6, 7), actuators, strict=True):
        lag = min(bandwidth, AT_ONCE)
        F[row, row], G[row, row - 6] = -lag, lag
    return F, G


def _sampled(F: Any, G: Any, delay: float) -> tuple[Any, Any, Any]:
    """x+ from x, from the controls set now and from those of the step before, which act until ``delay`` (s) is over."""

    from scipy.linalg import expm

    def held(time: float) -> tuple[Any, Any]:
        both = expm(np.block([[F, G], [np.zeros((G.shape[1], len(F) + G.shape[1]))]]) * time)
        return both[: len(F), : len(F)], both[: len(F), len(F) :]

    after, moved = held(STEP - delay)
    before, late = held(delay)
    return after @ before, moved, after @ late


def law_row(loop: RouteLoop, law: LateralNavigation) -> Any:
    """What the law asks for inside its limits, rad, as a row on the state."""
    return -(law.k1 * loop.C[CROSS_TRACK] + law.k2 * loop.C[CROSS_TRACK_RATE])


def growth(loop: RouteLoop, law: LateralNavigation) -> float:
    """Factor by which the slowest motion inside the limits changes in one step: above 1 the loop is unstable."""
    return float(np.abs(np.linalg.eigvals(loop.A + np.outer(loop.B, law_row(loop, law)))).max())


def linear_onset(loop: RouteLoop, bank_limit: float) -> float:
    """Natural frequency of the law, rad/s, at which the loop loses its stability inside the limits."""

    from scipy.optimize import brentq

    def unstable(frequency: float) -> float:
        return growth(loop, law_of_frequency(frequency, loop.speed, bank_limit)) - 1.0 - 1e-9

    frequencies = loop.bandwidth * np.geomspace(SLOWEST, QUICKEST, 100)
    for low, high in itertools.pairwise(frequencies):
        if unstable(low) < 0.0 <= unstable(high):
            return float(brentq(unstable, low, high, rtol=1e-6))
    return math.inf


def response(loop: RouteLoop, frequency: Any) -> Any:
    """(4, k) outputs for a unit sine of the bank command at each frequency, rad/s."""
    z = np.exp(1j * STEP * np.atleast_1d(frequency))[:, None, None]
    x = np.linalg.solve(
        z * np.eye(len(loop.A)) - loop.A, np.broadcast_to(loop.B[:, None], (*z.shape[:1], *loop.B.shape, 1))
    )
    return (loop.C @ x[..., 0].T) + loop.D[:, None]


def turning(loop: RouteLoop) -> float:
    """Share of g times the bank that turns the path in a steady bank: a little is lost to the sideslip that stays."""
    slow = 0.003 * loop.bandwidth
    y = np.abs(response(loop, slow)[:, 0])
    return float(slow**2 * y[CROSS_TRACK] / (STANDARD_GRAVITY * y[BANK]))


def law_response(loop: RouteLoop, law: LateralNavigation, frequency: Any) -> Any:
    """(k,) what the law asks for, rad, for a unit sine of the bank command: 1 where an oscillation sustains itself."""
    y = response(loop, frequency)
    return -(law.k1 * y[CROSS_TRACK] + law.k2 * y[CROSS_TRACK_RATE])


def open_loop(loop: RouteLoop, law: LateralNavigation) -> Any:
    """The loop opened at the bank command, with the sign of negative feedback, as a python-control system."""
    import control

    return control.ss(loop.A, loop.B[:, None], -law_row(loop, law)[None, :], 0.0, STEP)


class Margins(NamedTuple):
    """Stability margins of the route loop."""

    gain: float  # factor
    phase: float  # rad
    phase_crossover: float  # rad/s, where the gain margin is
    gain_crossover: float  # rad/s, where the phase margin is


def margins(loop: RouteLoop, law: LateralNavigation) -> Margins:
    """Gain and phase margin of the route loop inside the limits of the law."""

    from scipy.optimize import brentq

    natural = math.sqrt(STANDARD_GRAVITY * law.k1)
    frequency = np.geomspace(0.05 * min(natural, loop.bandwidth), 0.99 * math.pi / STEP, CROSSINGS)
    values = -law_response(loop, law, frequency)

    def at(w: float) -> complex:
        return -complex(law_response(loop, law, w)[0])

    def crossing(signs: Any, of: Any) -> float:
        k = int(np.nonzero((signs[:-1] > 0.0) & (signs[1:] <= 0.0))[0][0])
        return float(brentq(lambda w: float(of(at(w))), frequency[k], frequency[k + 1]))

    # the loop comes from -180 deg (a double integrator), leads, and falls through -180 deg again
    turned = crossing(np.where(values.real < 0.0, -values.imag, 1.0), lambda value: -value.imag)
    level = crossing(np.abs(values) - 1.0, lambda value: abs(value) - 1.0)
    return Margins(1.0 / abs(at(turned)), math.remainder(math.pi + np.angle(at(level)), math.tau), turned, level)
