"""A route law that swings from no offset: slow enough for the roll-rate limit behind it.

From one bank limit to the other the command takes 2 bank_limit / rate. A law that asks for the other bank faster than
that lags behind itself, by the more the larger the swing: what is small fades, and what is large stays. Turns, gusts
and winds that no plan knew begin large ones, so the law is made slow enough for harmonic balance to find no oscillation
of any amplitude, and with a margin, since one harmonic tells the border within a quarter only.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autopilot.design import Designed, law_of_frequency
from autopilot.limit_cycles import LimitedLoop, largest_gain, limited_loop
from autopilot.mode import RATE_MARGIN
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import RouteLoop, response

GAIN_MARGIN = 2.0  # 6 dB, asked of a loop inside its limits by MIL-F-9490D (from memory); here at every amplitude
AMPLITUDES = np.geomspace(0.3, 15.0, 30)  # over the bank limit; a designed law never asks for more than 10 of it
ALL_AMPLITUDES = np.geomspace(0.3, 300.0, 50)  # of laws that are not designed
FREQUENCIES = 140  # gains are then right within 1 or 2 %
DOUBTFUL = 0.9  # gain from which on such a grid does not decide
SLOWEST, HALVINGS = 0.02, 16  # of the natural frequency; of the ratio between a law that swings and one that does not
SHALLOWEST = math.radians(
    10.0
)  # intercept to which a slow law gives way for its turns; below it takes minutes to the leg


def steadied(designed: Designed, loops: Sequence[RouteLoop], speed: float, roll_rate_limit: float) -> Designed:
    """The design with a law whose oscillations all fade, in every loop and by a gain margin of 2 at every amplitude.

    The recipe of the law stays: its damping, its intercept, its limits; only the natural frequency comes down. A law
    that keeps the margin as it is stays as it is.

    Parameters
    ----------
    loops : those in which the law is flown, of one design
    speed : m/s, at which the route is intercepted        roll_rate_limit : rad/s, of the bank command
    """
    first = limited_loop(loops[0], designed.bank_limit, roll_rate_limit, AMPLITUDES, FREQUENCIES)
    others = (first._replace(loop=loop, response=response(loop, first.frequency)) for loop in loops[1:])
    limited = [first, *others]  # the limits are the same for all
    if not _swings(limited, designed.law, GAIN_MARGIN):
        return designed
    return designed.with_law(_slowed(limited, designed.law, speed, GAIN_MARGIN))


def may_swing(loop: RouteLoop, law: LateralNavigation, roll_rate_limit: float) -> bool:
    """Whether it is worth looking closer: False where every oscillation of a law fades in a loop."""
    limited = limited_loop(loop, law.bank_limit, roll_rate_limit, ALL_AMPLITUDES, FREQUENCIES)
    return largest_gain(limited, law) > DOUBTFUL


def first_that_swings(designed: Designed, loop: RouteLoop, speed: float, roll_rate_limit: float) -> float:
    """The natural frequency, rad/s, from which on a loop sustains an oscillation: where a slowed law has no margin."""
    limited = limited_loop(loop, designed.bank_limit, roll_rate_limit, AMPLITUDES, FREQUENCIES)
    return _slowed([limited], law_of_frequency(loop.bandwidth, speed, designed.bank_limit), speed, 1.0).frequency


def _swings(limited: Sequence[LimitedLoop], law: LateralNavigation, margin: float) -> bool:
    return any(margin * largest_gain(one, law) > 1.0 for one in limited)


def _slowed(limited: Sequence[LimitedLoop], law: LateralNavigation, speed: float, margin: float) -> LateralNavigation:
    """The fastest law below one that swings that keeps the margin, by bisection."""
    low, high = SLOWEST * law.frequency, law.frequency
    for _ in range(HALVINGS):
        middle = math.sqrt(low * high)
        trial = law_of_frequency(middle, speed, law.bank_limit)
        low, high = (low, middle) if _swings(limited, trial, margin) else (middle, high)
    return law_of_frequency(low, speed, law.bank_limit)


def shallower(designed: Designed, speed: float, ground_speed: float) -> Designed:
    """The design with intercepts that leave the whole bank to the turns: k1 z_max + bank_limit <= k2 ground speed.

    Where only intercepts below 10 degrees would do that, the law is too slow for these turns and stays as it is.

    Parameters
    ----------
    speed : m/s, at which the route is intercepted
    ground_speed : m/s, the least with which a leg is turned to
    """
    law = designed.law
    spare = ground_speed - law.bank_limit / law.k2
    if not speed * math.sin(SHALLOWEST) <= spare < law.intercept_speed:
        return designed
    position = law.k2 * spare
    rate_limit = RATE_MARGIN * (position + law.bank_limit) / law.k2
    return designed.with_law(LateralNavigation(law.k1, law.k2, law.bank_limit, position / law.k1, rate_limit))
