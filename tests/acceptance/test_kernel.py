"""Model sets on the kinematic landing pattern at full size: ten batches of 130 runs, intervals over batches.

The seeds were not used to choose any parameter of the sets.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

from tests.tracking.test_imm_landing import Judged, fly, judge, observe
from tracking.measurement import ConvertedPolar, DebiasedPolar
from tracking.trackers.imm import improved_set, published_set

pytestmark = pytest.mark.acceptance

BATCHES, RUNS = 10, 130


def measure(side: float, form: type, model_set: object, first_seed: int) -> list[Judged]:
    """One result per batch."""
    results = []
    for seed in range(first_seed, first_seed + BATCHES):
        pattern = fly(seed, side, RUNS)
        results.append(judge(pattern, *observe(pattern, seed + 5000), form, model_set))
    return results


def interval(values: list[float]) -> tuple[float, float, float]:
    """Mean and its 95 % Student interval over the batches."""
    mean, sd = float(np.mean(values)), float(np.std(values, ddof=1))
    half = float(stats.t.ppf(0.975, len(values) - 1)) * sd / len(values) ** 0.5
    return mean, mean - half, mean + half


def said(values: list[float]) -> str:
    mean, low, high = interval(values)
    return f"{mean:.2f} ({low:.2f}..{high:.2f}), n = {BATCHES} x {RUNS}"


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["left", "right"])
def test_improved_set(side: float, row: Callable[..., None]) -> None:
    results = measure(side, DebiasedPolar, improved_set(0.01, 0.05), 20_000)
    name = "left-hand" if side > 0.0 else "right-hand"
    for leg, asked in (("all", 4.2), ("glide", 2.9)):
        gains = [result.gain[leg] for result in results]
        _, low, _ = interval(gains)
        row(
            f"improved IMM set, {name} circuit, position gain, {leg}",
            f"lower end >= {asked}",
            said(gains),
            low >= asked,
        )
        assert low >= asked


def test_published_set(row: Callable[..., None]) -> None:
    results = measure(1.0, ConvertedPolar, published_set(0.01), 30_000)
    for what, values, printed, band in (
        ("position", [result.gain["glide"] for result in results], 1.27, 0.08),
        ("azimuth", [result.azimuth_gain["glide"] for result in results], 1.49, 0.09),
    ):
        mean, _, _ = interval(values)
        met = abs(mean - printed) <= band
        row(f"published IMM set, q 0.01, {what} gain on the glide path", f"{printed} +- {band}", said(values), met)
        assert met
    mirrored = [result.gain["all"] for result in measure(-1.0, ConvertedPolar, published_set(0.01), 31_000)]
    row("published IMM set, q 0.01, right-hand circuit, all legs", "< 1 (knows left turns only)", said(mirrored), True)
    assert interval(mirrored)[2] < 1.0


def test_published_set_with_more_noise(row: Callable[..., None]) -> None:
    results = measure(1.0, ConvertedPolar, published_set(0.3), 32_000)
    for leg, asked in (("all", 3.8), ("glide", 2.5)):
        gains = [result.gain[leg] for result in results]
        mean, _, _ = interval(gains)
        row(f"published IMM set, q 0.3, position gain, {leg}", f">= {asked}", said(gains), mean >= asked)
        assert mean >= asked
