"""The path that an aircraft under a law follows, as a tracker knows it: one line, or the legs of a route.

Both answer the same questions, so that a law-aware tracker is written once. On a `Line` the state is the deviation
and its rate, as published, and the bank is an acceleration across the line. On `Legs` the state is cartesian, the law
is asked with the deviations from the leg that the estimate is on, and the bank turns the velocity through the air.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, Protocol

import numpy as np

from tracking.gaussian import Gaussian, Innovation, lift, predict, update
from tracking.measurement import MeasurementModel
from tracking.motion import (
    CARTESIAN,
    GRAVITY,
    constant_velocity,
    course_kinematics,
    double_integrator,
    turn_rate_of,
    turn_transition,
)

Array = Any

SPEED_TIME = 20.0  # s, in which an aircraft comes to the charted speed: 10 m/s at 0.5 m/s2
SLOWEST = 1.0  # m/s: a target at rest has no course
SHORTEST_SUB_STEP = 0.01  # s; a control that is held for less moves the same, and costs without end
SUB_STEP = 1.0  # s, for which the control is held unless told otherwise: RMSE within 2 % of that of 0.25 s
# of one step; the time beyond them is uniform motion. A law has long come to its path by then (loops take 10 to 100 s),
# while longer steps would make the control that is held unstable: they must be below 4 damping / natural frequency.
MOST_SUB_STEPS = 1000
JUMP = 1e-2  # rad of bank over a millimetre: ten radians per metre are no law's slope
CROSS_TRACK = ("cross_track", "cross_track_rate")


class Law(Protocol):
    """The control law that a tracker assumes for the autopilot; this package knows no law by name."""

    @property
    def bank_limit(self) -> Any:
        """rad."""
        ...

    def __call__(self, deviation: Any) -> Array:
        """Bank, rad, for a deviation from the path."""
        ...


class PathState(NamedTuple):
    """An estimate and its place on the path: the state of every law-aware tracker."""

    gaussian: Gaussian
    place: Any


class Steering(NamedTuple):
    """What a law says at an estimate, and how that changes across the path."""

    bank: Array  # (*B) rad
    per_cross_track: Array  # (*B) rad/m
    per_cross_track_rate: Array  # (*B) rad/(m/s)


class ReferencePath(Protocol):
    """Where the law's deviations are taken from. A place is what of the path is known besides the state."""

    @property
    def axes(self) -> int:
        """Number of position components."""
        ...

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the state components."""
        ...

    def begin(self, mean: Array) -> Any:
        """Place of the estimate (n, *B) on the path."""
        ...

    def deviation(self, place: Any, mean: Array) -> Any:
        """What the law is asked with."""
        ...

    def normal(self, place: Any) -> Array:
        """Unit vector to the right of the path (axes, *C)."""
        ...

    def steered(self, place: Any, mean: Array, bank: Array, dt: float) -> Array:
        """Mean (n, *B) after dt (s) of a constant bank (*B), rad."""
        ...

    def steered_with_slope(self, place: Any, mean: Array, control: Steering, dt: float) -> tuple[Array, Array]:
        """The same, and its transition (n, n, *B), which holds the slope of the law."""
        ...

    def advance(self, place: Any, mean: Array, dt: float) -> Any:
        """Place dt (s) later, when the estimate will be ``mean``."""
        ...


class LineDeviation(NamedTuple):
    """Deviation from one line; the angles are worked out only for a law that asks for them."""

    cross_track: Array  # m
    cross_track_rate: Array  # m/s
    distance_to_go: Array  # m
    ground_speed: float  # m/s

    @property
    def bearing_error(self) -> Array:
        """Bearing to the line's end minus its course, rad: negative to the right of the line."""
        return -np.arctan2(self.cross_track, self.distance_to_go)

    @property
    def track_error(self) -> Array:
        """Course over the ground minus the line's, rad."""
        return np.arcsin(np.clip(self.cross_track_rate / self.ground_speed, -1.0, 1.0))

    @property
    def heading_error(self) -> Array:
        """The same: the line knows no wind."""
        return self.track_error

    def of_hypotheses(self, which: slice, batch: int) -> LineDeviation:
        """That of some hypotheses, of an axis before ``batch`` axes of runs."""
        among = (..., which, *(slice(None),) * batch)
        return self._replace(cross_track=self.cross_track[among], cross_track_rate=self.cross_track_rate[among])


@dataclass(frozen=True)
class Line:
    """One line, flown at the chart's ground speed towards its end."""

    ground_speed: float  # m/s
    distance_to_go: float = math.inf  # m, at the beginning
    channels = CROSS_TRACK
    axes = 1

    def __post_init__(self) -> None:
        if not self.ground_speed > 0.0:
            raise ValueError(f"the ground speed along a line must be positive, not {self.ground_speed} m/s")

    def begin(self, mean: Array) -> float:
        return self.distance_to_go

    def deviation(self, place: Array, mean: Array) -> LineDeviation:
        return LineDeviation(mean[0], mean[1], place, self.ground_speed)

    def normal(self, place: Array) -> Array:
        return np.ones(1)

    def steered(self, place: Array, mean: Array, bank: Array, dt: float) -> Array:
        """An acceleration across the line, g times the bank [Vasylyev 2003, eq. (6)]."""
        return push(mean, GRAVITY * bank, dt)

    def steered_with_slope(self, place: Array, mean: Array, control: Steering, dt: float) -> tuple[Array, Array]:
        return self.steered(place, mean, control.bank, dt), folded(control, dt)

    def advance(self, place: Array, mean: Array, dt: float) -> Array:
        return place - dt * np.sqrt(np.maximum(self.ground_speed**2 - mean[1] ** 2, 0.0))


@dataclass(frozen=True)
class Legs:
    """The legs of a route; the place is the index of the leg that each estimate says is being flown."""

    route: Any
    bank_limit: float  # rad, of the turns between legs
    channels = CARTESIAN
    axes = 2

    @property
    def wind(self) -> tuple[float, float]:
        """The way the air moves, (north, east) in m/s, as far as the route knows it."""
        wind: tuple[float, float] = getattr(self.route, "wind", (0.0, 0.0))
        return wind

    @cached_property
    def _normals(self) -> Array:
        return np.array([(-leg.direction[1], leg.direction[0]) for leg in self.route.legs]).T

    def begin(self, mean: Array) -> Array:
        """The leg with the shortest way to fly: the distance to it, plus the arc of the turn onto its course."""
        speed = np.hypot(mean[1], mean[3])
        radius = speed**2 / (GRAVITY * math.tan(self.bank_limit))
        ways = []
        for index, leg in enumerate(self.route.legs):
            deviation = self.deviation(np.full(mean.shape[1:], index), mean)
            to_go = deviation.distance_to_go
            outside = np.maximum(to_go - leg.length, 0.0) + np.maximum(-to_go, 0.0)  # before its start, past its end
            ways.append(np.hypot(deviation.cross_track, outside) + radius * np.abs(deviation.track_error))
        return np.argmin(ways, axis=0)

    def deviation(self, place: Array, mean: Array) -> Any:
        north, east = self.wind
        heading = np.arctan2(mean[3] - east, mean[1] - north) if north or east else None
        return self.route.deviation(place, (mean[0], mean[2]), (mean[1], mean[3]), heading)

    def normal(self, place: Array) -> Array:
        return self._normals[:, place]

    def steered(self, place: Array, mean: Array, bank: Array, dt: float) -> Array:
        """A level turn of the velocity through the air, g tan(bank) at right angles to it, at the charted speed.

        For small course errors this is [Vasylyev 2003, eq. (6)]. The speed is a control like the bank: it comes to the
        charted one as the autopilot's does.
        """
        through_air, speed = self._at_charted_speed(place, mean, dt)[:2]
        turn = turn_transition(dt, turn_rate_of(bank, speed))
        return np.einsum("ij...,j...->i...", turn, through_air) + self._drift(mean, dt)

    def steered_with_slope(self, place: Array, mean: Array, control: Steering, dt: float) -> tuple[Array, Array]:
        """The slope is the one across the leg.

        Along it only the beacon law changes, by the ratio of cross-track to distance less.
        """
        through_air, speed, slope = self._at_charted_speed(place, mean, dt)
        moved, F = course_kinematics(through_air, control.bank, dt)
        F[:, 1::2] = np.einsum("ij...,jk...->ik...", F[:, 1::2], slope)
        normal = lift(self.normal(place), 1, mean.ndim - 1)
        gradient = np.empty(np.broadcast_shapes(mean.shape, (4, *control.per_cross_track.shape)))  # d bank / d state
        gradient[0::2] = normal * control.per_cross_track
        gradient[1::2] = normal * control.per_cross_track_rate
        # the bank acts at right angles to the air velocity: d acceleration / d bank = g / cos^2(bank)
        north_rate, east_rate = through_air[1], through_air[3]
        aside = GRAVITY / np.cos(control.bank) ** 2 / speed
        effect = dt * np.array([-east_rate * aside, north_rate * aside])[:, None] * gradient  # on the velocity
        F[1::2] += effect
        effect *= 0.5 * dt  # on the position
        F[0::2] += effect
        return moved + self._drift(mean, dt), F

    def along_at_charted_speed(self, place: Array, mean: Array, dt: float) -> tuple[Array, float]:
        """Change of the velocity (2, *B) as its part along the leg comes nearer to the charted speed for dt.

        Second is the share that is kept of a difference. It is the charted speed over the ground of an aircraft that
        holds the leg: to first order in the course error, whose cosine is one.
        """
        normal = lift(self.normal(place), 1, mean.ndim - 1)
        if self.route.chart is None:
            return np.zeros_like(mean[1::2]), 1.0
        along = np.array([normal[1], -normal[0]])
        wind = np.array(self.wind)
        airspeed = self.route.charted_speed(place, self.deviation(place, mean).distance_to_go)
        against = np.einsum("i,i...->...", wind, normal)  # the part of the airspeed that holds the leg
        charted = np.sqrt(airspeed**2 - against**2) + np.einsum("i,i...->...", wind, along)
        kept = math.exp(-dt / SPEED_TIME)
        return (1.0 - kept) * (charted - np.einsum("i...,i...->...", along, mean[1::2])) * along, kept

    def _at_charted_speed(self, place: Array, mean: Array, dt: float) -> tuple[Array, Array, Array]:
        """State in the air when its speed has come nearer to the charted one for dt, and that speed.

        Third is the change of that velocity by the one before (2, 2, *B).
        """
        moved = mean - self._drift(mean, 0.0)
        speed = np.maximum(np.hypot(moved[1], moved[3]), SLOWEST)
        if self.route.chart is None:
            return moved, speed, lift(np.eye(2), 2, speed.ndim)
        kept = math.exp(-dt / SPEED_TIME)
        charted = self.route.charted_speed(place, self.deviation(place, mean).distance_to_go)
        reached = charted + kept * (speed - charted)
        course, ratio = moved[1::2] / speed, reached / speed
        moved[1::2] *= ratio
        slope = (kept - ratio) * course[:, None] * course  # along the velocity what is kept of it, across it the ratio
        slope[0, 0] += ratio
        slope[1, 1] += ratio
        return moved, reached, slope

    def _drift(self, mean: Array, dt: float) -> Array:
        """What the air adds to the state over dt."""
        north, east = self.wind
        return lift(np.array([dt * north, north, dt * east, east]), 1, mean.ndim - 1)

    def advance(self, place: Array, mean: Array, dt: float) -> Array:
        if np.all(place == len(self.route.legs) - 1):
            return place
        return self.route.sequence(place, (mean[0], mean[2]), (mean[1], mean[3]), self.bank_limit)


def reference_path(route: Any, law: Law) -> ReferencePath:
    """The line itself, or the legs of a route whose turns are flown at the law's bank limit.

    An aircraft banks ``time_to_roll`` before the circle of its turn begins, because it has to roll first. A tracker has
    no roll: its turns begin where the circles do, or they would be early by that time.
    """
    if isinstance(route, Line):
        return route
    return Legs(replace(route, time_to_roll=0.0), float(np.max(law.bank_limit)))


class OnPath(Protocol):
    """A tracker of an aircraft under a law along a path: what the functions of the same body are asked with."""

    @property
    def law(self) -> Law:
        """As it is assumed to be."""
        ...

    @property
    def route(self) -> Any:
        """A `Line`, or a route."""
        ...

    @property
    def path(self) -> Any:
        """`reference_path` of the two, made once."""
        ...

    @property
    def measurement(self) -> MeasurementModel:
        """Of all its sensors."""
        ...

    @property
    def sub_step(self) -> float:
        """For so long, s, the control is held."""
        ...


def path_of(tracker: OnPath) -> ReferencePath:
    """The path of a tracker, for its ``path``."""
    return reference_path(tracker.route, tracker.law)


def channels_on_path(tracker: OnPath) -> tuple[str, ...]:
    """Those of its path."""
    channels: tuple[str, ...] = tracker.path.channels
    return channels


def begin_on_path(tracker: OnPath, prior: Gaussian) -> PathState:
    """The prior with its place on the path."""
    return PathState(prior, tracker.path.begin(prior.mean))


def estimate_on_path(tracker: OnPath, state: PathState) -> Gaussian:
    """The Gaussian of the state."""
    return state.gaussian


def ahead_in_sub_steps(
    forward: Callable[[Law, Any, PathState, float, Any], Gaussian],
    tracker: OnPath,
    state: PathState,
    dt: float,
    density: float,
) -> PathState:
    """The state dt later by ``forward``, an estimate after one sub-step; its place moves with it.

    ``density`` (m2/s3) is that of the acceleration.
    """
    count, step, rest = sub_steps(dt, tracker.sub_step)
    _, Q = uniform(tracker.path.axes, step, density)
    for _ in range(count):
        gaussian = forward(tracker.law, tracker.path, state, step, Q)
        state = PathState(gaussian, tracker.path.advance(state.place, gaussian.mean, step))
    return coasted(tracker.path, state, rest, density)


def coasted(path: ReferencePath, state: PathState, rest: float, density: float) -> PathState:
    """The state after the time (s) of a step over which no law is followed any more."""
    if not rest:
        return state
    gaussian = predict(state.gaussian, *uniform(path.axes, rest, density))
    return PathState(gaussian, path.advance(state.place, gaussian.mean, rest))


def corrected(tracker: OnPath, state: PathState, z: Any | None, R: Any | None) -> tuple[PathState, Innovation | None]:
    """The update: no law is in it, and the place is the prediction's."""
    if z is None:
        return state, None
    gaussian, innovation = update(state.gaussian, *tracker.measurement.linearise(z, R, state.gaussian.mean))
    return PathState(gaussian, state.place), innovation


def sub_steps(dt: float, longest: float) -> tuple[int, float, float]:
    """Number and length (s) of equal steps, none above ``longest``, that cover dt, and what they leave of it (s).

    They leave nothing of up to `MOST_SUB_STEPS` of the longest.
    """
    followed = min(dt, MOST_SUB_STEPS * longest)
    count = max(1, math.ceil(followed / longest - 1e-9))
    return count, followed / count, dt - followed


def steering(law: Law, path: ReferencePath, place: Any, mean: Array) -> Steering:
    """Bank and its slopes across the path at the estimate (n, *B), by one call of the law.

    The laws are linear between their limits, so that a one-sided difference is exact there. Where the bank jumps - a
    course error passes half a turn on a flight against the leg - there is no slope, and none is returned.
    """
    small = 1e-3  # m and m/s: far below any limit, far above rounding at 1e5 m
    normal = lift(path.normal(place), 1, mean.ndim - 1)
    steps = np.zeros((len(mean), 3, *normal.shape[1:]))
    steps[0::2, 1] = steps[1::2, 2] = small * normal
    banks = law(path.deviation(place, mean[:, None] + steps))
    changes = banks[1:] - banks[:1]
    changes = np.where(np.abs(changes) > JUMP, 0.0, changes)
    return Steering(banks[0], changes[0] / small, changes[1] / small)


def push(mean: Array, acceleration: Array, dt: float) -> Array:
    """Mean (2, *B) after dt of a constant acceleration (*B), m/s2, to the right of the line [Vasylyev 2003, eq. (9)].

    Erratum: (9) leaves B' as an integral, used g [T^2/2, T], which it is for the double integrator (6).
    """
    position, rate = mean
    return np.array([position + dt * rate + 0.5 * dt**2 * acceleration, rate + dt * acceleration])


def folded(control: Steering, dt: float) -> Array:
    """Transition (2, 2, *C) across the path over dt with the slopes of the law folded in, ``F + g B C``."""
    F, _, B = double_integrator(dt)
    feedback = GRAVITY * np.array([control.per_cross_track, control.per_cross_track_rate])
    batch = feedback.ndim - 1
    return lift(F, 2, batch) + lift(B[:, None], 2, batch) * feedback


def closed(control: Steering, dt: float, noise: Array) -> tuple[Array, Array]:
    """Transition and noise (2, 2, *C) across the path over dt with the slopes of the law acting all the while.

    ``noise`` (2, 2, *C) is that of free motion; the law has acted on it for half of dt on average.
    """
    half = _closed_loop(control, 0.5 * dt)
    halfway = np.einsum("ij...,jk->ik...", half, np.array([[1.0, -0.5 * dt], [0.0, 1.0]]))
    shaped = np.einsum("ij...,jk...,lk...->il...", halfway, noise, halfway)
    return np.einsum("ij...,jk...->ik...", half, half), 0.5 * (shaped + shaped.swapaxes(0, 1))


def _closed_loop(control: Steering, dt: float) -> Array:
    """``tracking.motion.closed_loop`` for gains that differ from run to run, all three dampings at once."""
    stiffness, rate = -GRAVITY * control.per_cross_track, -0.5 * GRAVITY * control.per_cross_track_rate
    square = (stiffness - rate**2) * dt**2
    root = np.sqrt(np.abs(square))
    some = np.maximum(root, 1e-4)  # below it the series is exact to rounding
    slow, fast = np.exp(some - rate * dt), np.exp(-some - rate * dt)
    decay = np.exp(-rate * dt)
    over = square < 0.0
    s = np.where(over, (slow - fast) / (2.0 * some), decay * np.sin(some) / some)
    c = np.where(over, 0.5 * (slow + fast), decay * np.cos(some))
    near = root < 1e-4
    s = dt * np.where(near, decay * (1.0 - square / 6.0), s)
    c = np.where(near, decay * (1.0 - square / 2.0), c)
    return np.array([[c + rate * s, s], [-stiffness * s, c - rate * s]])


def embed(normal: Array, across: Array, along: Array) -> Array:
    """Matrix (n, n, *C) that is ``across`` (2, 2, *C) along the normal and ``along`` (2, 2) at right angles to it."""
    if len(normal) == 1:
        return across
    batch = max(across.ndim - 2, normal.ndim - 1)
    normal, across, along = lift(normal, 1, batch), lift(across, 2, batch), lift(along, 2, batch)
    difference = across - along
    matrix = np.empty((len(normal), 2, len(normal), 2, *np.broadcast_shapes(normal.shape[1:], across.shape[2:])))
    for i in range(len(normal)):
        for j in range(len(normal)):
            np.multiply(normal[i] * normal[j], difference, out=matrix[i, :, j])
        matrix[i, :, i] += along
    return matrix.reshape(2 * len(normal), 2 * len(normal), *matrix.shape[4:])


def uniform(axes: int, dt: float, density: Array) -> tuple[Array, Array]:
    """(F, Q) of uniform motion along every axis, with white acceleration of a density (m2/s3), one or one per run."""
    F, Q = _uniform(axes, dt)
    return F, np.multiply.outer(Q, density)


@lru_cache(maxsize=64)
def _uniform(axes: int, dt: float) -> tuple[Array, Array]:
    """The same for a density of one; shared, read-only."""
    F, Q = (np.kron(np.eye(axes), matrix) for matrix in constant_velocity(dt, 1.0))
    F.flags.writeable = Q.flags.writeable = False
    return F, Q


def check_tuning(acceleration_density: Array, sub_step: float) -> None:
    """Raise ``ValueError`` where a process noise or a sub-step cannot be."""
    if not np.all(np.asarray(acceleration_density) >= 0.0):
        raise ValueError(f"acceleration_density must not be negative, not {acceleration_density} m2/s3")
    if not sub_step >= SHORTEST_SUB_STEP:
        raise ValueError(f"sub_step must be at least {SHORTEST_SUB_STEP} s, not {sub_step} s")
