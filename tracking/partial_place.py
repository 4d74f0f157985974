"""Measurements that are a place only together: one azimuth, or one slant range, linearised at the prediction.

A localiser gives a direction and a distance-measuring equipment a range; neither is a place, and a plot of the two
would need them at one moment. The extended Kalman filter needs neither: each is a row of its own, when it comes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from tracking.height_profile import Charted, charted
from tracking.measurement import Linear, MeasurementModel, wrap
from tracking.motion import CARTESIAN

Array = Any
NEAREST = 50.0  # m from an antenna, within which neither direction nor slope of a range is known by the prediction


@dataclass(frozen=True)
class Azimuth:
    """One azimuth: the residual is wrapped, the slope is that at the predicted place."""

    position: Annotated[tuple[float, float], "given"]  # m, (north, east) of the antenna
    course: Annotated[float, "given"] = 0.0  # rad, where its azimuth is zero
    channels: Annotated[tuple[str, ...], "given"] = CARTESIAN
    rows: ClassVar[int] = 1
    equations: ClassVar[int] = 1

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        i, j = self.channels.index("north"), self.channels.index("east")
        north, east = mean[i] - self.position[0], mean[j] - self.position[1]
        square = np.maximum(north**2 + east**2, 1e-9)
        H = np.zeros((1, len(self.channels), *np.shape(square)))
        H[0, i], H[0, j] = -east / square, north / square
        residual = wrap(z - (np.arctan2(east, north) - self.course)[None])
        effective = residual + np.einsum("ij...,j...->i...", H, mean)
        return Linear(np.where(square > NEAREST**2, effective, np.nan), H, R)


@dataclass(frozen=True)
class SlantRange:
    """One slant range; the height of the target is the chart's at the predicted place, with its variance in R.

    A height that is wrong by h costs h times the sine of the elevation in range: 1 m for 20 m on a glide path. The
    slope leaves out how the assumed height itself changes with the place, which is as small.
    """

    position: Annotated[tuple[float, float, float], "given"]  # m, (north, east, height) of the antenna
    chart: Annotated[Charted, "given"]
    channels: Annotated[tuple[str, ...], "given"] = CARTESIAN
    rows: ClassVar[int] = 1
    equations: ClassVar[int] = 1

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        i, j = self.channels.index("north"), self.channels.index("east")
        north, east = mean[i] - self.position[0], mean[j] - self.position[1]
        height, variance = charted(self.chart, mean, self.channels)
        up = height - self.position[2]
        ground, slant = np.hypot(north, east), np.sqrt(np.maximum(north**2 + east**2 + up**2, 1e-9))
        H = np.zeros((1, len(self.channels), *np.shape(slant)))
        H[0, i], H[0, j] = north / slant, east / slant
        effective = z - slant + np.einsum("ij...,j...->i...", H, mean)
        return Linear(np.where(ground > NEAREST, effective, np.nan), H, R + (up / slant) ** 2 * variance)


@dataclass(frozen=True)
class Chosen:
    """A model that reads some rows of a sensor's z, whatever else the sensor measures."""

    model: Annotated[MeasurementModel, "given"]
    chosen: Annotated[tuple[int, ...], "given"]  # rows for the model, in its order
    rows: Annotated[int, "given"]  # of z

    @property
    def equations(self) -> int:
        return self.model.equations

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        rows = list(self.chosen)
        return self.model.linearise(z[rows], R[np.ix_(rows, rows)], mean)
