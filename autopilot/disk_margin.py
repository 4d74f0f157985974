"""Disk margins of the inner loops: how much gain and phase all controls may lose or win at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from autopilot.design import OperatingPoint, lateral_gains, longitudinal_gains

FREQUENCIES = np.geomspace(0.01, 60.0, 1500)  # rad/s; the autopilot's half rate is 94
DELAY = 1.0 / 60.0 + 1.5 / 120.0  # s: half a period of the held controls, and that of a simulation at 120 Hz


class Margin(NamedTuple):
    """A disk margin and the gain and phase that it allows."""

    disk: float  # radius of the disk of perturbations, 0 to 2
    frequency: float  # rad/s, where it is smallest

    @property
    def gain(self) -> float:
        """Factor by which the gain may rise or fall; infinite for a disk of 2."""
        return (2.0 + self.disk) / (2.0 - self.disk) if self.disk < 2.0 else math.inf

    @property
    def phase(self) -> float:
        """rad, that may be lost."""
        return 2.0 * math.atan(self.disk / 2.0)


def longitudinal_margin(point: OperatingPoint, K: Any, lags: Sequence[float]) -> Margin:
    """Of the loop through throttle and elevator with the gains ``K`` (2, 7); ``lags`` are their bandwidths, rad/s."""
    A, B = point.longitudinal
    A7, B7 = np.zeros((7, 7)), np.zeros((7, 2))
    A7[:5, :5], B7[:5] = A, B
    A7[5, 0] = A7[6, 4] = 1.0
    return disk_margin(_loop(A7, B7, K, lags))


def lateral_margin(point: OperatingPoint, K: Any, lags: Sequence[float]) -> Margin:
    """Of the loop through aileron and rudder with the gains ``K`` (2, 5) on the errors of ``lateral_gains``."""
    A, B = point.lateral
    A5, B5, onto = np.zeros((5, 5)), np.zeros((5, 2)), np.eye(5)
    A5[:4, :4], B5[:4] = A, B
    A5[4, 3] = 1.0
    onto[2, 3] = -STANDARD_GRAVITY / point.airspeed
    return disk_margin(_loop(A5, B5, K @ onto, lags))


def disk_margin(loop: Any) -> Margin:
    """Smallest balanced disk margin of a loop transfer (w, m, m) at FREQUENCIES, all channels perturbed at once.

    With S = (I + L)^-1 the loop stays stable for every diagonal (1 + d/2) / (1 - d/2) with complex |d| below
    1 / max |S - I/2|, by the small gain theorem. The largest singular value bounds this from below for several
    channels; for one it is exact.
    """
    size = loop.shape[-1]
    S = np.linalg.inv(np.eye(size) + loop)
    worst = np.linalg.svd(S - 0.5 * np.eye(size), compute_uv=False)[:, 0]
    at = int(np.argmax(worst))
    return Margin(float(1.0 / worst[at]), float(FREQUENCIES[at]))


def designed_gains(point: OperatingPoint) -> tuple[Any, Any]:
    """(longitudinal, lateral) gains of the recipe at an operating point."""
    return longitudinal_gains(point), lateral_gains(point)


def _loop(A: Any, B: Any, K: Any, lags: Sequence[float]) -> Any:
    """K (jw - A)^-1 B behind actuators and delay, (w, m, m)."""
    s = 1j * FREQUENCIES[:, None, None]
    late = np.exp(-s * DELAY) / (1.0 + s / np.asarray(lags, float))
    return K @ np.linalg.solve(s * np.eye(len(A)) - A, B.astype(complex)) * late
