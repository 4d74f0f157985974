"""A route law flown on an estimate whose cross-track rate is late: how late it may be, and a law that tolerates more.

A tracker that does not know the law sees a turn only when the aircraft has moved: its position is late by little, its
rate by seconds, and it is the rate that damps the law. With z and z' the deviation and its rate, and the rate late by
tau, the loop opened at the bank is ``g (k1 + k2 s exp(-s tau)) / s^2``. Without a lag of the bank it tolerates
``tau = pi/2 / (wn (zeta + sqrt(zeta^2 + 1)))``: at ``w tau = pi/2`` the late rate no longer damps. Beyond, the aircraft
swings about its line until the bank limit takes so much of the gain that the swing grows no more.
"""

from __future__ import annotations

import cmath
import math

from aircraft.state import STANDARD_GRAVITY
from autopilot.design import LAW_DAMPING, Designed, law_of_frequency

SAMPLING = 0.1  # s, of actuators and of commands that are held between records
SLOWEST = 1e-3  # of the frequency of the law: slower ones are not looked at
RESERVE = 2.0  # of the lag that a law is designed to tolerate over the lag that is expected


def bank_lag(designed: Designed) -> float:
    """How late the bank follows its command at low frequency, s: the critically damped reference and the sampling."""
    return 2.0 / designed.reference_frequency + SAMPLING


def tolerated_lag(k1: float, k2: float, bank_lag: float) -> float:
    """The longest lag of the rate, s, that the law inside its limits tolerates when the bank itself is late by a lag.

    On the verge the open loop is -1: ``g (k1 + j w k2 exp(-j w tau)) = w^2 exp(j w bank_lag)``. Its absolute value
    without the part of k1 holds w alone, and the phase then tells tau. A law that cycles without any lag tolerates 0.

    Parameters
    ----------
    k1, k2 : rad/m and rad/(m/s), of the law        bank_lag : s
    """

    from scipy.optimize import brentq

    stiffness, damping = STANDARD_GRAVITY * k1, STANDARD_GRAVITY * k2

    def excess(frequency: float) -> float:
        return abs(frequency**2 * cmath.exp(1j * frequency * bank_lag) - stiffness) - damping * frequency

    natural = math.sqrt(stiffness)
    fastest = 0.5 * (damping + math.sqrt(damping**2 + 4.0 * stiffness))  # what it is without a lag of the bank
    if excess(natural) >= 0.0:
        return 0.0
    frequency = float(brentq(excess, natural, fastest * (1.0 + 1e-9)))
    late = frequency**2 * cmath.exp(1j * frequency * bank_lag) - stiffness
    return max(0.0, -cmath.phase(late / (1j * damping * frequency)) / frequency)


def softened(designed: Designed, speed: float, lag: float) -> Designed:
    """The design with a law that is slow enough to tolerate twice the lag of the estimate that it is flown on.

    The recipe of the law stays: its damping, its intercept, its limits; only the natural frequency comes down. A law
    that tolerates the lag as it is stays as it is.

    Parameters
    ----------
    speed : m/s, at which the route is intercepted        lag : s, of the estimated rate
    """

    from scipy.optimize import brentq

    late, wanted = bank_lag(designed), RESERVE * lag
    if tolerated_lag(designed.k1, designed.k2, late) >= wanted:
        return designed

    def reserve(frequency: float) -> float:
        k1, k2 = frequency**2 / STANDARD_GRAVITY, 2.0 * LAW_DAMPING * frequency / STANDARD_GRAVITY
        return tolerated_lag(k1, k2, late) - wanted

    natural = math.sqrt(STANDARD_GRAVITY * designed.k1)
    frequency = float(brentq(reserve, SLOWEST * natural, natural))
    return designed.with_law(law_of_frequency(frequency, speed, designed.bank_limit))
