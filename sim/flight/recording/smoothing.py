"""Places of a recorded track without their jitter: the smoothed motion of an aircraft under white jerk.

The errors of a recorded place are not the same in all directions: a stamp that is off by 0.2 s displaces it by 15 m and
more along the track, and by nothing across it. Both accuracies are read off the record itself, by how well each place
is foretold by its four neighbours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from sim.flight.recording.places import Rows
from tracking.gaussian import Gaussian
from tracking.measurement import LinearMeasurement
from tracking.motion import Transition
from tracking.smoothing import smooth
from tracking.track import Measurements, track
from tracking.trackers.kalman import Kalman

JERK = 0.3  # m2/s5, density of the white jerk on the ground plane: 0.5 m/s3, a bank of 3 deg/s, for a second or two
JERK_UP = 0.03  # m2/s5, of the vertical: transports change their sink gently, and heights come in steps
LEAST_SIGMA, LEAST_HEIGHT_SIGMA = 0.1, 0.5  # m; no record is better than its digits: 1e-6 deg is 0.11 m
NORMAL = 1.4826  # standard deviation of a normal variable over the median of its size
WILD = 8.0  # standard deviations from what the neighbours say, and
WILD_LEAST = 60.0  # m, beyond which a row is no measurement of this flight
ROUNDS = 5  # in which wild rows are looked for: one spoils the forecast of its neighbours
STATE = tuple(f"{axis}{order}" for axis in ("north", "east", "height") for order in ("", "_rate", "_acceleration"))


class Path(NamedTuple):
    """A smooth motion at k instants."""

    time: np.ndarray  # (k,) s
    position: np.ndarray  # (3, k) m, north, east, height
    velocity: np.ndarray  # (3, k) m/s
    acceleration: np.ndarray  # (3, k) m/s2


class Accuracy(NamedTuple):
    """Standard deviations of recorded places, m."""

    along: float
    across: float
    height: float


@dataclass(frozen=True)
class WhiteJerk:
    """Constant acceleration on three axes, driven by white jerk of one density on the ground plane, another upwards."""

    density: float = JERK  # m2/s5
    density_up: float = JERK_UP
    channels = STATE
    depends_on_state = False

    def transition(self, dt: float, mean: Any) -> Transition:
        """F and Q over dt (s), by the integrals of the powers of dt."""
        F, Q = np.zeros((9, 9)), np.zeros((9, 9))
        own = np.array(((1.0, dt, 0.5 * dt * dt), (0.0, 1.0, dt), (0.0, 0.0, 1.0)))
        noise = np.array(
            (
                (dt**5 / 20.0, dt**4 / 8.0, dt**3 / 6.0),
                (dt**4 / 8.0, dt**3 / 3.0, dt**2 / 2.0),
                (dt**3 / 6.0, dt**2 / 2.0, dt),
            )
        )
        for axis, density in enumerate((self.density, self.density, self.density_up)):
            block = slice(3 * axis, 3 * axis + 3)
            F[block, block], Q[block, block] = own, density * noise
        return Transition(F, Q)


PLACE = tuple(tuple(float(column == 3 * axis) for column in range(9)) for axis in range(3))  # H of a place


def smoothed(rows: Rows) -> tuple[Path, Accuracy]:
    """The motion at the stamps of the rows, counted from the first, and the accuracy that was found.

    Rauch, Tung and Striebel's smoother over a filter of `WhiteJerk` motion, with errors along and across the track of
    the accuracies that `accuracy_of` finds.
    """
    accuracy = accuracy_of(rows)
    along = _direction(rows)
    right = np.array((-along[1], along[0]))
    R = np.zeros((len(rows.time), 3, 3))
    for axis, sigma in ((along, accuracy.along), (right, accuracy.across)):
        R[:, :2, :2] += sigma**2 * np.einsum("ik,jk->kij", axis, axis)
    R[:, 2, 2] = accuracy.height**2
    z = np.column_stack((rows.north, rows.east, rows.height))
    time = rows.time - rows.time[0]
    channels = ("record.north", "record.east", "record.height")
    motion = WhiteJerk()
    found = track(
        Kalman(LinearMeasurement(PLACE), motion), Measurements(channels, time, time, z, R), _prior(rows), start=0.0
    )
    mean = smooth(found, motion).mean.reshape(len(time), 3, 3)
    return Path(time, *np.moveaxis(mean, (2, 1), (0, 1))), accuracy


def _prior(rows: Rows) -> Gaussian:
    """Hardly more than that it is an aircraft: 1 km, 100 m/s and 5 m/s2 about the first place, at no speed."""
    first = rows.height[np.isfinite(rows.height)][0]
    mean = np.array((rows.north[0], 0.0, 0.0, rows.east[0], 0.0, 0.0, first, 0.0, 0.0))
    return Gaussian(mean, np.diag((1e6, 1e4, 25.0) * 3))


def accuracy_of(rows: Rows) -> Accuracy:
    """How accurate places are along and across the track, by the median of what their neighbours foretell wrongly.

    A height is known to the steps in which it is told: a uniform error.
    """
    residual, scale = _foretold(rows)
    along = _direction(rows)
    turned = (along[0] * residual[0] + along[1] * residual[1], along[0] * residual[1] - along[1] * residual[0])
    along_sigma, across_sigma = (max(NORMAL * float(np.median(np.abs(part) / scale)), LEAST_SIGMA) for part in turned)
    steps = np.diff(np.unique(rows.height[np.isfinite(rows.height)].round(3)))
    step = float(steps.min()) if steps.size else 0.0
    return Accuracy(along_sigma, across_sigma, max(step / math.sqrt(12.0), LEAST_HEIGHT_SIGMA))


def tamed(rows: Rows) -> tuple[Rows, list[str]]:
    """The rows without those that are far from what their neighbours say, and how many were left out.

    Of five rows in a row the middle one shows its error most. Which of the first three, or the last, is wild nobody can
    tell from them: all go.
    """
    count = len(rows.time)
    for _ in range(ROUNDS):
        residual, scale = _foretold(rows)
        off = (np.hypot(*residual) / scale)[2:-2]
        typical = NORMAL * float(np.median(off))
        nearby = np.lib.stride_tricks.sliding_window_view(np.pad(off, 2), 5).max(axis=1)
        wild = np.pad((off > max(WILD * typical, WILD_LEAST)) & (off == nearby), 2, mode="edge")
        if not wild.any() or len(rows.time) - wild.sum() < 5:
            break
        rows = rows.some(~wild)
    out = count - len(rows.time)
    return rows, [f"{out} of {count} rows lie far off the line of their neighbours and are left out"] if out else []


def _foretold(rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """(2, k) m, places less those of the cubic through the two rows before and after, and by what a unit error shows.

    At both ends the row is judged by the four nearest.
    """
    count = len(rows.time)
    middle = np.clip(np.arange(count), 2, count - 3)
    neighbours = middle + np.array((-2, -1, 0, 1, 2))[:, None]  # the row itself is one of them
    time, own = rows.time[neighbours], rows.time
    itself = neighbours == np.arange(count)
    weights = np.ones((5, count))
    for i in range(5):
        for j in range(5):
            if i != j:
                share = (own - time[j]) / (time[i] - time[j])
                weights[i] *= np.where(itself[j] | itself[i], 1.0, share)
    weights[itself] = 0.0
    foretold = [np.sum(weights * column[neighbours], axis=0) for column in (rows.north, rows.east)]
    return np.array((rows.north, rows.east)) - foretold, np.sqrt(1.0 + np.sum(weights**2, axis=0))


def _direction(rows: Rows) -> np.ndarray:
    """(2, k) unit vectors along the track, from two rows before to two rows after."""
    after = np.minimum(np.arange(len(rows.time)) + 2, len(rows.time) - 1)
    before = np.maximum(np.arange(len(rows.time)) - 2, 0)
    way = np.array([column[after] - column[before] for column in (rows.north, rows.east)])
    return np.asarray(way / np.maximum(np.hypot(*way), 1e-9))


def resampled(path: Path, time: np.ndarray) -> Path:
    """The motion between the instants: the polynomial of fifth degree through place, velocity and acceleration.

    Given both ends that is the expected motion under white jerk, so no accuracy is lost by it.
    """
    after = np.clip(np.searchsorted(path.time, time, side="right"), 1, len(path.time) - 1)
    before = after - 1
    span = path.time[after] - path.time[before]
    s = (time - path.time[before]) / span
    p0, v0, a0 = (part[:, before] for part in path[1:])
    p1, v1, a1 = (part[:, after] for part in path[1:])
    v0, v1, a0, a1 = v0 * span, v1 * span, a0 * span**2, a1 * span**2
    way = p1 - p0 - v0 - 0.5 * a0  # what jerk and its derivatives have to bring: place, slope and bend at the end
    slope, bend = v1 - v0 - a0, a1 - a0
    c3 = 10.0 * way - 4.0 * slope + 0.5 * bend
    c4 = -15.0 * way + 7.0 * slope - bend
    c5 = 6.0 * way - 3.0 * slope + 0.5 * bend
    position = p0 + s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))))
    velocity = v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))
    acceleration = a0 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))
    return Path(time, position, velocity / span, acceleration / span**2)
