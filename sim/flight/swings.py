"""What theory says of the swings of a route law, in words: for pages, for remarks and for the reason of an outcome."""

from __future__ import annotations

import math

from autopilot.design import Designed, lateral_law
from autopilot.limit_cycles import LimitedLoop, caught, least_offset, limited_loop, sine_balances
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import RouteLoop
from autopilot.swing_margin import GAIN_MARGIN, first_that_swings, may_swing


def in_words(limited: LimitedLoop, law: LateralNavigation) -> str:
    """From which start on the limits sustain an oscillation, and which; "" where every oscillation fades."""
    offset = least_offset(limited, law)
    if math.isinf(offset):
        unstable = [one.demand for one in sine_balances(limited, law)[0] if not one.is_stable]
        if not unstable:
            return ""
        asked = math.degrees(min(unstable))
        return f"caught where the law asks for {asked:.0f} deg of bank or more, which it does on no leg at rest"
    begun = f"caught from {offset:.1f} m beside the leg at rest" if offset else "whatever the start"
    cycle = caught(limited, law, offset)
    if cycle is None:
        return f"{begun}, without an amplitude of its own"
    bank = math.degrees(cycle.bank)
    stops = f"; slower than that: it asks for {cycle.aileron:.1f} of the full aileron" if cycle.aileron > 1.0 else ""
    return f"{begun}; bank {bank:.1f} deg, period {cycle.period:.1f} s, cross-track {cycle.cross_track:.1f} m{stops}"


def cause(loop: RouteLoop, law: LateralNavigation, roll_rate_limit: float) -> str:
    """What sustains the swings of a law that flies, by theory; "" where its oscillations fade."""
    if not may_swing(loop, law, roll_rate_limit):
        return ""
    words = in_words(limited_loop(loop, law.bank_limit, roll_rate_limit), law)
    return words and f"{_limits(law.bank_limit, roll_rate_limit)} sustain an oscillation, {words}"


def _limits(bank_limit: float, roll_rate_limit: float) -> str:
    return f"{math.degrees(bank_limit):.3g} deg of bank at {math.degrees(roll_rate_limit):.3g} deg/s of roll"


def slowness(loop: RouteLoop, designed: Designed, speed: float, roll_rate_limit: float) -> str:
    """Why a designed law is as slow as it is; "" where its limits did not slow it."""
    fastest = lateral_law(designed.bank_bandwidth, speed, designed.bank_limit, designed.turning).frequency
    if designed.law.frequency > (1.0 - 1e-9) * fastest:
        return ""
    border = first_that_swings(designed, loop, speed, roll_rate_limit)
    return (
        f"theory has slowed the law from {fastest:.3f} to {designed.law.frequency:.3f} rad/s, a gain margin of "
        f"{GAIN_MARGIN:.0f}, because from {border:.3f} rad/s on {_limits(designed.bank_limit, roll_rate_limit)} "
        "sustain an oscillation"
    )
