"""The height that a chart gives at a place, and slant ranges brought to the ground with it or with a measured one.

A range that is read with a height h off by e is wrong by e h / d on the ground, d being the horizontal distance: little
far away, much near the antenna. So a height comes with a variance, and that goes into R.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol

import numpy as np

from tracking.gaussian import lift
from tracking.measurement import Linear, MeasurementModel
from tracking.motion import CARTESIAN

Array = Any

# An aircraft counts as maintaining its level within 300 ft of it [ICAO Doc 4444, 8.5.5.2, from memory]: read as three
# standard deviations.
LEVEL_SIGMA = 0.3048 * 300.0 / 3.0  # m

# How far a change of height may lie before or behind its place in the plan, all places alike, and how far beside its
# leg an aircraft may be: a turn is begun some seconds early or late and cuts the corner, and speed, wind and slope
# differ from the plan by some per cent.
DISPLACED = 1000.0  # m
PLACES = 9  # in the mean over them


class ChartHeight(NamedTuple):
    """What is known of the height at a place without measuring it."""

    height: Array  # m above the threshold
    variance: Array  # m2


class Charted(Protocol):
    """Any chart of heights."""

    def at(self, north: Array, east: Array, north_rate: Array = 0.0, east_rate: Array = 0.0) -> ChartHeight:
        """The height at places (*B), m, for an aircraft that moves so, m/s; at rest, in any direction."""
        ...


@dataclass(frozen=True)
class HeightProfile:
    """The heights planned along the legs of a route, in tuples: a value that compares.

    At a place the leg is the one that is nearest, where a course that is off by an angle counts as far as the chord of
    the turn onto the leg, so that of two legs that cross it is the one in whose direction the aircraft moves. Legs that
    are nearly as near count with the weight of a normal density of `DISPLACED`: of two that lie on each other the
    height is the mean and what they differ by is in the variance. Which leg is truly flown is not asked; off the route
    the height is that of the nearest legs.

    The variance on a leg is that of a level that is kept, plus the mean square of what the height would differ by if
    the plan lay up to `DISPLACED` earlier or later. On the glide path, which is tied to the ground, it is the first
    alone.
    An error of the height is taken as independent from look to look, which one of the chart is not: where it lasts,
    a tracker is as wrong as it says in a single look, and not as sure as it says after many.
    """

    legs: tuple[tuple[float, float, float, float], ...]  # m, (north, east) of the start and of the end of each
    along: tuple[float, ...]  # m along the legs, increasing
    height: tuple[float, ...]  # m above the threshold, linear between
    glide_path_from: float = math.inf  # m along the legs
    turn_radius: float = 2000.0  # m, of the turns between legs

    @cached_property
    def _lines(self) -> tuple[Array, ...]:
        """Start, direction, length and distance along the route at the start, each (legs,)."""
        legs = np.array(self.legs)
        step = legs[:, 2:] - legs[:, :2]
        length = np.hypot(step[:, 0], step[:, 1])
        before = np.concatenate(([0.0], np.cumsum(length)[:-1]))
        return (*legs[:, :2].T, *(step / length[:, None]).T, length, before)

    @cached_property
    def _planned(self) -> tuple[Array, Array, Array]:
        """(along, height, variance), denser than given: the variance bends where a displaced plan does."""
        along, height = np.array(self.along), np.array(self.height)
        offsets = DISPLACED * ((2.0 * np.arange(PLACES) + 1.0) / PLACES - 1.0)  # the middles of equal parts
        changes = np.diff(height, prepend=height[0])[along <= self.glide_path_from].any()
        places = np.unique((along[:, None] + offsets).clip(along[0], along[-1])) if changes else along
        planned = np.interp(places, along, height)
        displaced = np.interp(np.minimum(places[:, None] + offsets, self.glide_path_from), along, height)
        variance = np.mean((displaced - planned[:, None]) ** 2, axis=1)
        return places, planned, LEVEL_SIGMA**2 + np.where(places < self.glide_path_from, variance, 0.0)

    def at(self, north: Array, east: Array, north_rate: Array = 0.0, east_rate: Array = 0.0) -> ChartHeight:
        """The height at places (*B) for an aircraft that moves so."""
        ones = (1,) * np.ndim(north)
        start_north, start_east, along_north, along_east, length, before = (v.reshape(-1, *ones) for v in self._lines)
        off_north, off_east = north - start_north, east - start_east
        way = np.clip(off_north * along_north + off_east * along_east, 0.0, length)
        places, planned, variances = self._planned
        along = way + before
        height, variance = np.interp(along, places, planned), np.interp(along, places, variances)
        if len(self.legs) == 1:
            return ChartHeight(height[0], variance[0])
        square = (off_north - way * along_north) ** 2 + (off_east - way * along_east) ** 2
        speed = np.maximum(np.hypot(north_rate, east_rate), 1e-9)
        cosine = (north_rate * along_north + east_rate * along_east) / speed
        square -= 2.0 * self.turn_radius**2 * cosine  # chord^2 = 2 R^2 (1 - cosine)
        weight = np.exp((square.min(axis=0) - square) / (2.0 * DISPLACED**2))
        weight /= weight.sum(axis=0)
        mean = (weight * height).sum(axis=0)
        return ChartHeight(mean, (weight * (variance + (height - mean) ** 2)).sum(axis=0))


def with_elevation(z: Array, R: Array, height: Array, variance: Array) -> tuple[Array, Array]:
    """Range, azimuth and elevation, with their covariance, of a slant range and azimuth at a height above the antenna.

    The elevation ``arcsin(h / r)`` goes with the range, ``d elevation / d r = -tan(elevation) / r``, so that on the
    ground plane its errors leave ``(r/d)^2 R_rr + (h/d)^2 variance``. A range that is shorter than the height gives the
    zenith, where no plot is used.
    """
    slant = z[0]
    sine = np.clip(height / slant, -1.0, 1.0)
    cosine = np.maximum(np.sqrt(1.0 - sine * sine), 1e-9)
    per_range, per_height = -sine / (slant * cosine), 1.0 / (slant * cosine)
    shape = np.broadcast_shapes(np.shape(sine), np.shape(z[1]))
    polar = np.empty((3, *shape))
    polar[0], polar[1], polar[2] = slant, z[1], np.arcsin(sine)
    covariance = np.empty((3, 3, *np.broadcast_shapes(shape, R.shape[2:])))
    covariance[:2, :2] = lift(R[:2, :2], 2, covariance.ndim - 2)
    covariance[0, 2] = covariance[2, 0] = per_range * R[0, 0]
    covariance[1, 2] = covariance[2, 1] = per_range * R[0, 1]
    covariance[2, 2] = per_range**2 * R[0, 0] + per_height**2 * variance
    return polar, covariance


@dataclass(frozen=True)
class MeasuredHeight:
    """Slant range, azimuth and height, read by a model of range, azimuth and elevation."""

    model: Annotated[MeasurementModel, "given"]
    antenna_height: Annotated[float, "given"] = 0.0  # m
    rows: ClassVar[int] = 3

    @property
    def equations(self) -> int:
        return self.model.equations

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        return self.model.linearise(*with_elevation(z, R, z[2] - self.antenna_height, R[2, 2]), mean)


@dataclass(frozen=True)
class ChartedHeight:
    """Slant range and azimuth, read by a model of range, azimuth and elevation at the chart's height.

    The height is that of the predicted place and course: what the tracker believes, never the true one.
    """

    model: Annotated[MeasurementModel, "given"]
    chart: Annotated[Charted, "given"]
    antenna_height: Annotated[float, "given"] = 0.0  # m
    channels: Annotated[tuple[str, ...], "given"] = CARTESIAN
    rows: ClassVar[int] = 2

    @property
    def equations(self) -> int:
        return self.model.equations

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        height, variance = charted(self.chart, mean, self.channels)
        return self.model.linearise(*with_elevation(z, R, height - self.antenna_height, variance), mean)


def charted(chart: Charted, mean: Array, channels: tuple[str, ...]) -> ChartHeight:
    """The chart's height at an estimate (n, *B) with these channels."""
    north, north_rate, east, east_rate = (
        mean[channels.index(name)] for name in ("north", "north_rate", "east", "east_rate")
    )
    return chart.at(north, east, north_rate, east_rate)
