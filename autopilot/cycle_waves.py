"""The wave of a limit cycle: the balance of all its harmonics, for which one harmonic gives the place to look.

A cycle near the onset is nearly a sine, and its describing function says its period within a few per cent. A slow one
swings beyond the law's own limits of deviation and rate: what the law then asks for changes sign at times that no sine
of the deviation tells, and one harmonic gives 40 s where 55 to 80 s are flown. Its bank, though, is held at its limit
for most of the time, so the wave of the limited command hardly depends on what was assumed: two or three rounds through
the loop settle it at any period, and the period is that at which a round does not shift it.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import CROSS_TRACK, CROSS_TRACK_RATE, STEP, RouteLoop, response
from autopilot.saturation import saturate

HALF = 512  # samples of half a period; the other half is the same upside down
ORDERS = np.arange(1, 40, 2)
ANGLE = math.pi * np.arange(HALF) / HALF
ORDERS_AT = np.exp(1j * ORDERS[:, None] * ANGLE)  # (orders, HALF)
ROUNDS, SETTLED = 40, 1e-4  # through the loop; of the wave, between two of them
STRIDE, WIDEST = 1.06, 6.0  # of the period: between two looks for the one that does not shift, and how far they go
PRECISE = 1e-3  # of the period
PASSES, CLOSED = 60, 1e-9  # over half a wave; rad, between its end and its beginning


class CommandWave(NamedTuple):
    """The limited bank command of a limit cycle."""

    frequency: float  # rad/s
    harmonics: Any  # (orders,) rad, complex amplitudes over a sine
    demand: float  # rad, amplitude of what the law asks for


class _Round(NamedTuple):
    """What one period becomes on its way through the loop."""

    harmonics: Any  # (orders,) rad, of the limited command, turned so that the first one is a sine
    shift: float  # rad, by which they were turned
    demand: float  # rad


def wave_of_cycle(loop: RouteLoop, law: LateralNavigation, roll_rate_limit: float, near: float) -> CommandWave | None:
    """The stable cycle whose period is next to one that is nearly right; None where there is none.

    Parameters
    ----------
    roll_rate_limit : rad/s, of the command
    near : s, the period that one harmonic gives
    """
    latest = np.zeros(len(ORDERS), complex)
    latest[0] = law.bank_limit

    def around(period: float) -> _Round:
        nonlocal latest  # waves of neighbouring periods are alike
        turned = _settled(loop, law, roll_rate_limit, math.tau / period, latest)
        latest = turned.harmonics
        return turned

    # a command that comes back late (below zero) makes the period longer
    late = around(near).shift < 0.0
    before, after = near, near
    while (around(after).shift < 0.0) is late:
        before, after = after, after * (STRIDE if late else 1.0 / STRIDE)
        if not 1.0 / WIDEST < after / near < WIDEST:
            return None
    while abs(after / before - 1.0) > PRECISE:
        middle = math.sqrt(before * after)
        before, after = (middle, after) if (around(middle).shift < 0.0) is late else (before, middle)
    turned = around(after)
    return CommandWave(math.tau / after, turned.harmonics, turned.demand)


def _settled(loop: RouteLoop, law: LateralNavigation, roll_rate_limit: float, frequency: float, wave: Any) -> _Round:
    """Round after round at one frequency, rad/s, until the wave is the same but for its shift."""
    at = frequency * ORDERS
    seen = np.where(at < 0.9 * math.pi / STEP, response(loop, at), 0.0)
    for _ in range(ROUNDS):
        turned = _round(law, seen, roll_rate_limit * math.pi / HALF / frequency, wave)
        if np.abs(turned.harmonics - wave).max() < SETTLED * law.bank_limit:
            break
        wave = turned.harmonics
    return turned


def _round(law: LateralNavigation, seen: Any, most: float, wave: Any) -> _Round:
    """Command -> what the law sees -> what it asks for -> command; ``most`` is the rate limit over one sample, rad."""
    z, rate = ((wave * seen[row]) @ ORDERS_AT for row in (CROSS_TRACK, CROSS_TRACK_RATE))
    asked = -law.k1 * saturate(z.imag, law.cross_track_limit) - law.k2 * saturate(rate.imag, law.cross_track_rate_limit)
    command = _rate_limited(saturate(asked, law.bank_limit), most)
    harmonics = 2j / HALF * (ORDERS_AT.conj() @ command)
    shift = float(np.angle(harmonics[0]))
    return _Round(harmonics * np.exp(-1j * ORDERS * shift), shift, float(np.abs(asked).max()))


def _rate_limited(half_wave: Any, most: float) -> Any:
    """Half a period behind a limit of its change from sample to sample, as it is once it repeats itself.

    Where the limited signal meets its demand, what was before is forgotten and the next half begins right. Where it
    never does, a wrong beginning returns with the other sign, and the mean of two is right.
    """
    wanted, begin = half_wave.tolist(), -float(half_wave[-1])
    for attempt in range(PASSES):
        value, limited = begin, []
        for one in wanted:  # `rate_limit` in line: a map of cycles passes here ten million times
            change = one - value
            value = value + most if change > most else value - most if change < -most else one
            limited.append(value)
        if abs(begin + value) <= CLOSED:
            break
        begin = -value if attempt % 2 == 0 else 0.5 * (begin - value)
    return np.array(limited)
