"""Limit cycles of the route loop: oscillations that the bank limit and the roll-rate limit sustain.

Harmonic balance: an oscillation sustains itself where the gain of both limits times that of the linear loop behind
them is one. Above the frequency at which the linear loop is unstable the bank limit bounds what grows; below it the
roll-rate limit can sustain what is large enough, although everything small fades away.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from autopilot.cycle_waves import ORDERS, CommandWave, wave_of_cycle
from autopilot.describing_functions import (
    SAMPLES,
    harmonics,
    limited_wave,
    limits_describing_function,
    saturation_describing_function,
)
from autopilot.design import law_of_frequency
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import (
    AILERON,
    BANK,
    CROSS_TRACK,
    CROSS_TRACK_RATE,
    SLOWEST,
    STEP,
    RouteLoop,
    linear_onset,
    response,
)

AMPLITUDES = np.geomspace(0.01, 300.0, 200)  # of what the law asks for, over the bank limit
FREQUENCIES = 240
LOWEST, HIGHEST = 0.004, 3.0  # of the bandwidth of the bank loop


class LimitCycle(NamedTuple):
    """An oscillation that sustains itself; amplitudes are half the way from peak to peak."""

    period: float  # s
    bank: float  # rad
    cross_track: float  # m
    demand: float  # rad, amplitude of the bank that the law asks for
    aileron: float  # share of full that is asked for at most; above 1 the aileron is at its stop and limits too
    is_stable: bool  # whether what is near comes to it; an unstable one divides what fades from what stays


class LimitedLoop(NamedTuple):
    """A route loop with its limits on a grid of amplitudes and frequencies; good for every law."""

    loop: RouteLoop
    bank_limit: float  # rad
    rate_limit: float  # rad/s
    amplitude: Any  # (m,) of what the law asks for, over the bank limit
    frequency: Any  # (k,) rad/s
    response: Any  # (4, k) of the loop
    gain: Any  # (m, k) of the limits


def limited_loop(
    loop: RouteLoop, bank_limit: float, rate_limit: float, amplitude: Any = AMPLITUDES, frequencies: int = FREQUENCIES
) -> LimitedLoop:
    """The loop with a bank limit (rad) and a roll-rate limit of the command (rad/s)."""
    highest = min(HIGHEST * loop.bandwidth, 0.9 * math.pi / STEP)
    frequency = np.geomspace(LOWEST * loop.bandwidth, highest, frequencies)
    gain = limits_describing_function(amplitude[:, None] * bank_limit, frequency, bank_limit, rate_limit)
    return LimitedLoop(loop, bank_limit, rate_limit, amplitude, frequency, response(loop, frequency), gain)


def limit_cycles(limited: LimitedLoop, law: LateralNavigation) -> tuple[LimitCycle, ...]:
    """All limit cycles of a law, by rising demand.

    For each amplitude the oscillation has the frequency at which the loop with its limits turns the phase round; where
    its gain there passes through one is a limit cycle, which is stable if the gain falls as the amplitude grows. The
    law's own limits of deviation and rate act by their gains too. A stable cycle is then followed to the wave that
    balances in all harmonics; an unstable one, which only divides what fades from what stays, is left as a sine.
    """
    balances, _ = sine_balances(limited, law)
    return tuple(_described(limited, law, balance) for balance in balances)


class Balance(NamedTuple):
    """A demand and a frequency that sustain themselves."""

    demand: float  # rad
    frequency: float  # rad/s
    is_stable: bool


def sine_balances(limited: LimitedLoop, law: LateralNavigation) -> tuple[list[Balance], bool]:
    """Balances by rising demand, between the points of the grid, and whether the smallest oscillation grows."""
    (frequency, gain), amplitude = _round_the_loop(limited, law), limited.amplitude
    found = []
    for i in range(len(gain) - 1):
        if (gain[i] > 1.0) != (gain[i + 1] > 1.0) and np.isfinite(gain[i] + gain[i + 1]):
            share = math.log(gain[i]) / math.log(gain[i] / gain[i + 1])
            demand = limited.bank_limit * amplitude[i] * (amplitude[i + 1] / amplitude[i]) ** share
            at = frequency[i] * (frequency[i + 1] / frequency[i]) ** share
            found.append(Balance(float(demand), float(at), bool(gain[i] > 1.0)))
    return found, bool(gain[0] > 1.0)


def largest_gain(limited: LimitedLoop, law: LateralNavigation) -> float:
    """The gain of the whole loop, where its phase is turned round, at the amplitude at which it is largest.

    Below 1 every oscillation fades, whatever it began with; its inverse is the gain margin over all amplitudes.
    """
    _, gain = _round_the_loop(limited, law)
    return float(np.nan_to_num(gain).max())


def _round_the_loop(limited: LimitedLoop, law: LateralNavigation) -> tuple[Any, Any]:
    """Frequency and gain, for each amplitude, at which the loop with all its limits turns the phase round."""
    moved = np.abs(limited.gain) * limited.amplitude[:, None] * limited.bank_limit  # amplitude of the limited command
    asked = np.zeros(limited.gain.shape, complex)
    for factor, limit, seen in (
        (law.k1, law.cross_track_limit, limited.response[CROSS_TRACK]),
        (law.k2, law.cross_track_rate_limit, limited.response[CROSS_TRACK_RATE]),
    ):
        asked -= factor * saturation_describing_function(moved * np.abs(seen), limit) * seen
    return _turned(limited.frequency, limited.gain * asked)


def _turned(frequency: Any, around: Any) -> tuple[Any, Any]:
    """Frequency and gain, for each amplitude (rows), at which the phase first falls through zero; nan where never."""
    falls = (around.imag[:, :-1] > 0.0) & (around.imag[:, 1:] <= 0.0) & (around.real[:, 1:] > 0.0)
    at = np.argmax(falls, axis=1)
    rows = np.arange(len(around))
    before, after = around[rows, at], around[rows, at + 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = before.imag / (before.imag - after.imag)
    gain = before.real + share * (after.real - before.real)
    turned = frequency[at] * (frequency[at + 1] / frequency[at]) ** share
    never = ~falls.any(axis=1)
    return np.where(never, np.nan, turned), np.where(never, np.nan, gain)


def _described(limited: LimitedLoop, law: LateralNavigation, balance: Balance) -> LimitCycle:
    """What swings, from the harmonics of the limited command: of the settled wave, or of a limited sine."""
    wave = None
    if balance.is_stable:
        wave = wave_of_cycle(limited.loop, law, limited.rate_limit, math.tau / balance.frequency)
    if wave is None:
        sine = limited_wave(balance.demand, balance.frequency, limited.bank_limit, limited.rate_limit)
        wave = CommandWave(balance.frequency, harmonics(sine, len(ORDERS)), balance.demand)
    orders = ORDERS[ORDERS * wave.frequency < 0.9 * math.pi / STEP]
    outputs = wave.harmonics[: len(orders)] * response(limited.loop, orders * wave.frequency)
    angle = math.tau * np.arange(SAMPLES) / SAMPLES
    waves = (outputs[:, :, None] * np.exp(1j * orders[:, None] * angle)).imag.sum(axis=1)
    height = 0.5 * np.ptp(waves, axis=1)
    period, bank, cross_track = math.tau / wave.frequency, float(height[BANK]), float(height[CROSS_TRACK])
    return LimitCycle(period, bank, cross_track, wave.demand, float(height[AILERON]), balance.is_stable)


def least_offset(limited: LimitedLoop, law: LateralNavigation) -> float:
    """Cross-track offset, m, from which an aircraft at rest beside the line is caught by an oscillation.

    At rest beside the line the law asks at once for k1 z, and no more: a peak of its demand. What is above the demand
    of an unstable limit cycle stays; zero where everything does, infinite where all fades away. A flight begins without
    the bank that the cycle has at that peak, which holds it back once more, so it is caught from somewhat nearer.
    """
    balances, grows = sine_balances(limited, law)
    if grows:
        return 0.0
    offset = min((one.demand for one in balances if not one.is_stable), default=math.inf) / float(law.k1)
    return offset if offset <= law.cross_track_limit else math.inf


def caught(limited: LimitedLoop, law: LateralNavigation, cross_track: float) -> LimitCycle | None:
    """The stable cycle to which an aircraft comes from rest beside the line (m); None where it fades, or never ends."""
    balances, grows = sine_balances(limited, law)
    into, asked = balances[0] if grows and balances else None, law.k1 * min(cross_track, law.cross_track_limit)
    for below, above in itertools.zip_longest(balances, balances[1:]):
        if not below.is_stable and below.demand <= asked:
            into = above
    return None if into is None else _described(limited, law, into)


def onset(limited: LimitedLoop, cross_track: float) -> float:
    """Smallest natural frequency of the law, rad/s, whose oscillation lasts when begun at rest beside the line (m)."""

    from scipy.optimize import bisect

    loop = limited.loop

    def lasts(frequency: float) -> float:
        law = law_of_frequency(frequency, loop.speed, limited.bank_limit)
        return 1.0 if least_offset(limited, law) <= cross_track else -1.0

    linear = linear_onset(loop, limited.bank_limit)
    highest = min(linear, loop.bandwidth)
    frequencies = np.geomspace(SLOWEST * loop.bandwidth, highest, 60)
    for low, high in itertools.pairwise(frequencies):
        if lasts(high) > 0.0:
            return float(bisect(lasts, low, high, xtol=1e-4 * high)) if lasts(low) < 0.0 else float(low)
    return linear
