"""What limits make of a sine: gains of the bank limit and of the roll-rate limit behind it.

The bank limit alone has no memory and its gain depends on the amplitude. The roll-rate limit remembers, so that its
gain depends on two inputs, amplitude and frequency, and turns the phase back: that is what sustains large oscillations
of a loop which damps small ones.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

HALVINGS = 40  # of the interval in which the limited signal catches up with its demand
SAMPLES = 512  # of one period of a wave


def saturation_describing_function(amplitude: Any, limit: float) -> Any:
    """Gain of a saturation for a sine: 2/pi (asin r + r sqrt(1 - r^2)), r = limit/amplitude, 1 below the limit."""
    r = np.minimum(limit / np.asarray(amplitude, float), 1.0)
    return 2.0 / math.pi * (np.arcsin(r) + r * np.sqrt(1.0 - r * r))


class Ramp(NamedTuple):
    """The falling ramp of a limited sine, in radians of it; the rising one is half a period later, upside down."""

    begin: Any  # where the limited signal leaves its demand
    value: Any  # there, over the limit
    end: Any  # where it is back; ``begin`` where the rate limit never acts, half a period on where it always does


def ramp(amplitude: Any, rate: Any) -> Ramp:
    """Where a rate limit (per radian) holds back a sine that is saturated at 1.

    The demand leaves its plateau, or becomes too steep, at the begin of the ramp; a limited signal that would not be
    back half a period later is a triangle, whose peaks lie on the demand.
    """
    amplitude, rate = np.broadcast_arrays(np.asarray(amplitude, float), np.asarray(rate, float))
    plateau = np.arcsin(np.minimum(1.0 / amplitude, 1.0))  # of the rising demand; a peak where there is none
    steep = np.arccos(np.minimum(rate / amplitude, 1.0))
    begin = math.pi - np.minimum(plateau, steep)
    value = amplitude * np.sin(begin)

    low, high = math.pi + np.minimum(plateau, steep), begin + math.pi
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        ahead = value - rate * (middle - begin) > np.clip(amplitude * np.sin(middle), -1.0, 1.0)
        low, high = np.where(ahead, middle, low), np.where(ahead, high, middle)
    end = np.where(steep > 0.0, high, begin)

    height = 0.5 * math.pi * rate
    triangle = height < value
    peak = math.pi - np.arcsin(np.minimum(height / amplitude, 1.0))
    return Ramp(
        np.where(triangle, peak, begin),
        np.where(triangle, height, value),
        np.where(triangle, peak + math.pi, end),
    )


def limits_describing_function(amplitude: Any, frequency: Any, limit: float, rate: float) -> Any:
    """Complex gain, for a sine of amplitude and frequency, of a limit and a rate limit in series.

    The first harmonic over half a period in closed form: the ramp, then the demand on its slope and its plateau.
    """
    over = np.asarray(amplitude, float) / limit
    slope = rate / (np.asarray(frequency, float) * limit)
    over, slope = np.broadcast_arrays(over, slope)
    begin, value, end = ramp(over, slope)
    last = begin + math.pi

    def of_ramp(angle: Any) -> Any:
        return (1j * (value - slope * (angle - begin)) - slope) * np.exp(-1j * angle)

    def of_sine(angle: Any) -> Any:
        return -0.5j * angle - 0.25 * np.exp(-2j * angle)

    def of_plateau(angle: Any) -> Any:
        return -1j * np.exp(-1j * angle)

    def demand(low: Any, high: Any, of: Any) -> Any:
        low, high = np.clip(low, end, last), np.clip(high, end, last)
        return of(high) - of(low)

    plateau = np.arcsin(np.minimum(1.0 / over, 1.0))
    falling, rising = math.pi + plateau, 2.0 * math.pi - plateau
    total = of_ramp(end) - of_ramp(begin)
    total = total + over * demand(begin, falling, of_sine) + over * demand(rising, last, of_sine)
    total = total + demand(falling, rising, of_plateau)
    return 2j / math.pi * total / over


def limited_wave(amplitude: float, frequency: float, limit: float, rate: float) -> Any:
    """(SAMPLES,) one period of a sine behind a limit and a rate limit in series, from the zero of the sine."""
    begin, value, end = map(float, ramp(amplitude / limit, rate / (frequency * limit)))
    angle = math.tau * np.arange(SAMPLES) / SAMPLES
    since = np.mod(angle - begin, math.tau)
    sign = np.where(since < math.pi, 1.0, -1.0)
    since = np.mod(since, math.pi)
    on_ramp = value - rate / (frequency * limit) * since
    demand = np.clip(amplitude / limit * np.sin(begin + since), -1.0, 1.0)
    return limit * sign * np.where(since < end - begin, on_ramp, demand)


def harmonics(wave: Any, count: int) -> Any:
    """(count,) complex amplitudes of the harmonics 1, 3, 5, ... of a wave that is the same upside down, over a sine."""
    return 2j / len(wave) * np.fft.rfft(wave)[1 : 2 * count : 2]
