"""Measurement models: from what a sensor reports to ``z = H x + v`` at the prediction.

Azimuth is atan2(east, north) of target minus sensor, minus the sensor's course. A range is slant. Either the
elevation is measured too, or the target's height above the antenna is known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol

import numpy as np

from tracking.gaussian import lift
from tracking.motion import CARTESIAN

Array = Any


class Linear(NamedTuple):
    """One measurement as ``z = H x + v``, v ~ N(0, R); rows that may not be used are NaN in z."""

    z: Array  # (m, *B)
    H: Array  # (m, n, *C)
    R: Array  # (m, m, *C)


class MeasurementModel(Protocol):
    """What a tracker is given to read its sensors."""

    @property
    def rows(self) -> int:
        """Number of rows of the sensor's z."""
        ...

    @property
    def equations(self) -> int:
        """Number of rows of the linear form, whatever was measured."""
        ...

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        """Linear form of z (rows, *B) with covariance R (rows, rows, *C) at the predicted mean (n, *B)."""
        ...


def wrap(angle: Array) -> Array:
    """Angle in [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def longest_range(range_sigma: float, azimuth_sigma: float) -> float:
    """Range (m) up to which a polar measurement may be converted linearly [Volovyk 2022, eqs. (13)-(14)].

    Beyond it the bend of the arc, ``r sigma_azimuth^2``, exceeds 0.4 of the range error. Zero where the azimuth error
    itself exceeds 0.4 rad.

    Erratum: (13) printed sigma_0 and (9) the variance of "elevation", used the azimuth error in radians, because the
    conversion turns with the azimuth.
    """
    if azimuth_sigma >= 0.4:
        return 0.0
    return 0.4 * range_sigma / azimuth_sigma**2 if azimuth_sigma > 0.0 else math.inf


class GroundPolar(NamedTuple):
    """A polar measurement on the ground plane with its covariance and where it is usable."""

    distance: Array  # m, horizontal
    azimuth: Array  # rad
    distance_variance: Array
    covariance: Array  # of distance and azimuth
    azimuth_variance: Array
    usable: Array  # False over the antenna or without a direction


def to_ground(z: Array, R: Array, height: float | None) -> GroundPolar:
    """Slant (range, azimuth, elevation), or (range, azimuth) at a known height, on the ground plane.

    Over the antenna - horizontal distance below three of its own standard deviations, or a slant range shorter than
    the height - the direction is not defined and the measurement is not usable. Nor is it where the azimuth is not
    known to one radian.
    """
    slant, azimuth = z[0], z[1]
    if height is None:
        elevation = z[2]
        along, across = np.cos(elevation), np.sin(elevation)
        distance = slant * along
        lever = -slant * across  # d distance / d elevation
        variance = along**2 * R[0, 0] + 2.0 * along * lever * R[0, 2] + lever**2 * R[2, 2]
        covariance = along * R[0, 1] + lever * R[1, 2]
    else:
        square = slant**2 - height**2
        distance = np.sqrt(np.maximum(square, 0.0))
        slope = slant / np.where(distance > 0.0, distance, 1.0)  # d distance / d slant range
        variance, covariance = slope**2 * R[0, 0], slope * R[0, 1]
    usable = (distance**2 > 9.0 * variance) & (R[1, 1] < 1.0)
    return GroundPolar(distance, azimuth, variance, covariance, R[1, 1], usable)


class Polar(Protocol):
    """A measurement model of a radar."""

    @property
    def height(self) -> float | None:
        """m of the target above the antenna; None: elevation is measured."""
        ...


def polar_rows(model: Polar) -> int:
    """Range and azimuth, and elevation where the height is not known."""
    return 3 if model.height is None else 2


@dataclass(frozen=True)
class LinearMeasurement:
    """Channels that are linear in the state as they stand: H (m, n) as nested tuples."""

    H: Annotated[tuple[tuple[float, ...], ...], "given"]

    def __post_init__(self) -> None:
        if len({len(row) for row in self.H}) != 1:
            raise ValueError("the rows of H must all be as long as the state")

    @property
    def rows(self) -> int:
        return len(self.H)

    @property
    def equations(self) -> int:
        return len(self.H)

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        return Linear(z, _matrix(self.H), R)


@dataclass(frozen=True)
class ConvertedPolar:
    """Cartesian conversion with the covariance at the measurement [Volovyk 2022, eqs. (8)-(14)].

    A plot beyond the validity bound, or over the antenna, is not used: its rows are NaN.

    Erratum: (8) printed H x, used the polar functions of the position, because range and azimuth are not linear in it.
    """

    position: Annotated[tuple[float, float], "given"] = (0.0, 0.0)  # m, (north, east) of the antenna
    course: Annotated[float, "given"] = 0.0  # rad, where its azimuth is zero
    height: Annotated[float | None, "given"] = None  # m of the target above the antenna; None: elevation is measured
    channels: Annotated[tuple[str, ...], "given"] = CARTESIAN

    rows = cached_property(polar_rows)
    equations: ClassVar[int] = 2

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        plot = to_ground(z, R, self.height)
        limit = 0.4 * np.sqrt(plot.distance_variance)
        valid = (plot.distance * plot.azimuth_variance < limit) & (plot.azimuth_variance < 0.16) & plot.usable
        bearing = plot.azimuth + self.course
        c, s = np.cos(bearing), np.sin(bearing)
        cartesian = np.array([self.position[0] + plot.distance * c, self.position[1] + plot.distance * s])
        across = plot.distance**2 * plot.azimuth_variance
        R = _rotated(plot.distance_variance, plot.distance * plot.covariance, across, c, s)
        return Linear(np.where(valid, cartesian, np.nan), positions(self.channels), R)


@dataclass(frozen=True)
class DebiasedPolar:
    """Cartesian conversion without bias, with its exact covariance at the predicted direction and distance.

    The mean of ``cos(azimuth + error)`` is ``exp(-sigma^2/2) cos(azimuth)``; dividing by the factor removes the bias,
    and the second moments give the covariance in closed form. At the prediction the covariance does not correlate
    with the error of this plot. Valid at any range; over the antenna the rows are NaN.
    """

    position: Annotated[tuple[float, float], "given"] = (0.0, 0.0)
    course: Annotated[float, "given"] = 0.0
    height: Annotated[float | None, "given"] = None
    channels: Annotated[tuple[str, ...], "given"] = CARTESIAN

    rows = cached_property(polar_rows)
    equations: ClassVar[int] = 2

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        plot = to_ground(z, R, self.height)
        bearing = plot.azimuth + self.course
        bend = np.minimum(plot.azimuth_variance, 1.0)
        distance = plot.distance * np.exp(0.5 * bend)
        cartesian = np.array(
            [self.position[0] + distance * np.cos(bearing), self.position[1] + distance * np.sin(bearing)]
        )
        north, east, predicted = _relative(mean, self.channels, self.position)
        safe = np.maximum(predicted, 1e-9)
        variance = plot.distance_variance
        along = predicted**2 * 2.0 * np.sinh(0.5 * bend) ** 2 + variance * np.cosh(bend)
        across = (predicted**2 + variance) * np.sinh(bend)
        R = _rotated(along, predicted * plot.covariance, across, north / safe, east / safe)
        usable = plot.usable & (predicted**2 > 9.0 * variance)
        return Linear(np.where(usable, cartesian, np.nan), positions(self.channels), R)


@dataclass(frozen=True)
class ExtendedPolar:
    """Distance and azimuth linearised at the prediction: the extended Kalman filter.

    The azimuth residual is wrapped. Where the prediction is over the antenna the rows are NaN.
    """

    position: Annotated[tuple[float, float], "given"] = (0.0, 0.0)
    course: Annotated[float, "given"] = 0.0
    height: Annotated[float | None, "given"] = None
    channels: Annotated[tuple[str, ...], "given"] = CARTESIAN

    rows = cached_property(polar_rows)
    equations: ClassVar[int] = 2

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        plot = to_ground(z, R, self.height)
        north, east, distance = _relative(mean, self.channels, self.position)
        safe = np.maximum(distance, 1e-9)
        c, s = north / safe, east / safe
        H = np.zeros((2, len(self.channels), *np.shape(distance)))
        i, j = self.channels.index("north"), self.channels.index("east")
        H[0, i], H[0, j], H[1, i], H[1, j] = c, s, -s / safe, c / safe
        azimuth = np.arctan2(east, north) - self.course
        residual = np.array([plot.distance - distance, wrap(plot.azimuth - azimuth)])
        usable = plot.usable & (distance**2 > 9.0 * plot.distance_variance)
        effective = residual + np.einsum("ij...,j...->i...", H, mean)
        R = np.array(
            np.broadcast_arrays(plot.distance_variance, plot.covariance, plot.covariance, plot.azimuth_variance)
        )
        return Linear(np.where(usable, effective, np.nan), H, R.reshape(2, 2, *R.shape[1:]))


@dataclass(frozen=True)
class Stacked:
    """Several sensors read at one epoch: their rows one below the other, in the order declared."""

    models: Annotated[tuple[MeasurementModel, ...], "given"]

    @property
    def rows(self) -> int:
        return sum(model.rows for model in self.models)

    @property
    def equations(self) -> int:
        return sum(model.equations for model in self.models)

    def linearise(self, z: Array, R: Array, mean: Array) -> Linear:
        parts, first = [], 0
        absent = np.isnan(z).reshape(len(z), -1).all(axis=1).tolist()
        for model in self.models:
            rows = slice(first, first + model.rows)
            if all(absent[rows]):  # the usual case: sensors rarely look at the same moment
                parts.append(Linear(np.full((model.equations, *z.shape[1:]), np.nan), *_nothing(model)))
            else:
                parts.append(model.linearise(z[rows], R[rows, rows], mean))
            first = rows.stop
        total = sum(len(part.H) for part in parts)
        H, R = _joint([part.H for part in parts]), [part.R for part in parts]
        batch = max(part.ndim - 2 for part in R)
        joint = np.zeros((total, total, *np.broadcast_shapes(*(lift(part, 2, batch).shape[2:] for part in R))))
        first = 0
        for part in parts:
            last = first + len(part.H)
            joint[first:last, first:last] = lift(part.R, 2, batch)
            first = last
        return Linear(np.concatenate([part.z for part in parts]), H, joint)


def _joint(matrices: list[Array]) -> Array:
    """Matrices (m, n, *C) one below the other."""
    batch = max(matrix.ndim - 2 for matrix in matrices)
    if not batch:
        return np.concatenate(matrices)
    lifted = [lift(matrix, 2, batch) for matrix in matrices]
    shape = np.broadcast_shapes(*(matrix.shape[2:] for matrix in lifted))
    return np.concatenate([np.broadcast_to(matrix, (*matrix.shape[:2], *shape)) for matrix in lifted])


def _nothing(model: MeasurementModel) -> tuple[Array, Array]:
    """H and R of a sensor that is silent for all runs."""
    H = _matrix(model.H) if isinstance(model, LinearMeasurement) else positions(getattr(model, "channels", CARTESIAN))
    if model.equations != len(H):
        H = np.resize(H, (model.equations, H.shape[1]))  # any will do
    return H, np.eye(len(H))


def positions(channels: tuple[str, ...]) -> Array:
    """H (2, n) that picks (north, east) out of a state with these channels."""
    rows = tuple(tuple(float(channel == name) for channel in channels) for name in ("north", "east"))
    return _matrix(rows)


def _matrix(rows: tuple[tuple[float, ...], ...]) -> Array:
    matrix = _MATRICES.get(rows)
    if matrix is None:
        matrix = _MATRICES.setdefault(rows, np.array(rows, dtype=float))
        matrix.flags.writeable = False
    return matrix


_MATRICES: dict[tuple[tuple[float, ...], ...], Array] = {}


def _relative(mean: Array, channels: tuple[str, ...], position: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Predicted (north, east) from the antenna and the horizontal distance."""
    north = mean[channels.index("north")] - position[0]
    east = mean[channels.index("east")] - position[1]
    return north, east, np.hypot(north, east)


def _rotated(along: Array, mixed: Array, across: Array, c: Array, s: Array) -> Array:
    """Covariance (2, 2, *B) in (north, east) of errors along and across a direction (c, s) [Volovyk 2022, eq. (12)]."""
    north = c * c * along - 2.0 * c * s * mixed + s * s * across
    east = s * s * along + 2.0 * c * s * mixed + c * c * across
    off = c * s * (along - across) + (c * c - s * s) * mixed
    return np.array([[north, off], [off, east]])
