"""Axes that are linear, logarithmic, or linear about zero and logarithmic beyond; the values that are named on them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
WIDE = 500.0  # ratio of the ends of a logarithmic axis, beyond which only powers of ten are named
LEAST = 2  # ticks of a linear axis, which may then be closer than asked
LARGE, SMALL = 6, 4  # digits before and after the point, beyond which a number is written with an exponent


class Scale(NamedTuple):
    """How values become lengths along an axis."""

    kind: str = "linear"  # or "log", "symmetric"
    linear_to: float = 1.0  # symmetric: linear from minus this to this, logarithmic beyond
    decades: float = 1.0  # symmetric: length of half the linear part, in decades

    def forward(self, values: np.ndarray) -> np.ndarray:
        """Lengths of values; a logarithm that does not exist is NaN."""
        if self.kind == "linear":
            return np.asarray(values, float)
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.kind == "log":
                return np.where(np.asarray(values) > 0.0, np.log10(values), np.nan)
            size = np.abs(values) / self.linear_to
            beyond = self.decades + np.log10(np.maximum(size, 1.0))
            return np.asarray(np.sign(values) * np.where(size > 1.0, beyond, self.decades * size))

    def ticks(self, low: float, high: float, most: int) -> list[float]:
        """Round values between the ends, about ``most`` at most."""
        low, high = min(low, high), max(low, high)
        if self.kind == "log":
            return _powers(low, high, most)
        return _even(low, high, most)


LINEAR, LOGARITHMIC = Scale(), Scale("log")


def _even(low: float, high: float, most: int) -> list[float]:
    span = high - low
    if not span > 0.0 or not math.isfinite(span):
        return [low]
    power = 10.0 ** math.floor(math.log10(span / max(most, 1)))
    sizes = [size * power for size in (*STEPS, 20.0, 25.0, 50.0)]
    fitting = next(place for place, step in enumerate(sizes) if span / step <= max(most, 1) + 1e-9)
    found: list[float] = []
    for step in (*sizes[fitting::-1], 0.5 * power):
        first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
        found = [number * step for number in range(first, last + 1)]
        if len(found) >= LEAST:
            break
    return found


def _powers(low: float, high: float, most: int) -> list[float]:
    within = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    sizes = (1.0,) if high / low > WIDE else (1.0, 2.0, 5.0)
    found = [size * 10.0**power for power in within for size in sizes]
    found = [value for value in found if low * (1 - 1e-9) <= value <= high * (1 + 1e-9)]
    return found if len(found) >= LEAST else _even(low, high, most)  # so short an axis is nearly linear


def named(ticks: list[float], scale: Scale = LINEAR) -> list[str]:
    """The ticks as they are written: on a linear axis with as many decimals as the step needs."""
    if scale.kind != "linear" or len(ticks) < 2:
        return [written(value) for value in ticks]
    step = ticks[1] - ticks[0]
    if max(map(abs, ticks)) >= 10**LARGE or step < 10.0**-SMALL:
        return [written(value) for value in ticks]
    decimals = next(n for n in range(SMALL + 3) if abs(round(step, n) - step) < 1e-6 * step)
    return [signed(f"{value:.{decimals}f}") for value in ticks]


def written(value: float) -> str:
    """A number in its shortest form."""
    return signed(f"{value:g}")


def signed(text: str) -> str:
    """With a minus sign that is as wide as a plus; nothing is minus zero."""
    return text.replace("-", "\N{MINUS SIGN}") if float(text) else text.removeprefix("-")
