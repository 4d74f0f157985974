"""Interacting multiple models [Volovyk 2022, table 1] with any set of motion models."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from tracking.gaussian import Gaussian, Innovation, Mixture, lift
from tracking.measurement import MeasurementModel
from tracking.motion import (
    AlongTrackAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Motion,
    ScheduledTurn,
    Transition,
)
from tracking.packed import (
    Packed,
    SharedMotion,
    interact,
    pack,
    predict,
    predict_shared,
    shared_motion,
    unpack,
    update,
)

STRAIGHT_DENSITY, MANOEUVRE_DENSITY = 0.3, 1.0  # m2/s3, of the improved set: the choice of docs/densities.md


class ModelSet(NamedTuple):
    """Motion models, how they switch (rows "from", columns "to") and how likely each is at the start.

    The switching matrix holds over ``period`` seconds; over another time it is that power of it. Without a period it
    holds once per step, whatever the time.
    """

    models: tuple[Motion, ...]
    switching: tuple[tuple[float, ...], ...]
    probabilities: tuple[float, ...]
    period: float | None = None  # s
    names: tuple[str, ...] = ()  # of the models, for reports; () = they have none


def published_set(acceleration_density: float = 0.01, slow: float = -0.001, fast: float = -0.045) -> ModelSet:
    """Two left turns and straight flight, scanned every 0.7 s, as published [Volovyk 2022, section 4].

    Erratum: printed initial probabilities .53 .33 .13, which sum to .99, used 8/15 5/15 2/15, because these truncate
    to the printed digits and sum to one.
    """
    return ModelSet(
        (
            CoordinatedTurn(slow, acceleration_density),
            CoordinatedTurn(fast, acceleration_density),
            ConstantVelocity(acceleration_density),
        ),
        ((0.99, 0.01, 0.0), (0.01, 0.98, 0.01), (0.0, 0.01, 0.99)),
        (8 / 15, 5 / 15, 2 / 15),
        0.7,
        ("slow left turn", "fast left turn", "straight"),
    )


def improved_set(
    straight_density: float = STRAIGHT_DENSITY,
    manoeuvre_density: float = MANOEUVRE_DENSITY,
    acceleration: float = -0.5,
    bank: float = math.radians(15.0),
) -> ModelSet:
    """Straight flight, slowing down, and a turn to either side at the rate of the bank limit and estimated speed.

    The switching follows from how long each lasts in a landing pattern: 140 s straight, 23 s slowing down from 69 to
    58 m/s, 58 s in a turn of 90 deg and its roll. Straight flight ends in either manoeuvre alike, these end in it.
    """
    return ModelSet(
        (
            ConstantVelocity(straight_density),
            AlongTrackAcceleration(acceleration, manoeuvre_density),
            ScheduledTurn(bank, manoeuvre_density),
            ScheduledTurn(-bank, manoeuvre_density),
        ),
        (
            (0.995, 0.0025, 0.00125, 0.00125),
            (0.02, 0.97, 0.005, 0.005),
            (0.009, 0.003, 0.988, 0.0),
            (0.009, 0.003, 0.0, 0.988),
        ),
        (0.7, 0.1, 0.1, 0.1),
        0.7,
        ("straight", "slowing down", "right turn", "left turn"),
    )


@dataclass(frozen=True)
class InteractingMultipleModel:
    """Interact, predict, update, reweigh, merge [Volovyk 2022, table 1].

    The file parameters are those of the improved set; another set is given as `model_set`. Its turns are flown at
    ``bank``, or where that is None at the autopilot's ``bank_limit``. The measurement is linearised at the merged
    prediction, once for all models.
    """

    measurement: Annotated[MeasurementModel, "given"]
    model_set: Annotated[ModelSet | None, "given"] = None
    bank_limit: Annotated[float, "given"] = math.radians(15.0)
    straight_density: Annotated[float, "m2/s3"] = STRAIGHT_DENSITY
    manoeuvre_density: Annotated[float, "m2/s3"] = MANOEUVRE_DENSITY
    acceleration: Annotated[float, "m/s2"] = -0.5
    bank: Annotated[float | None, "rad"] = None
    per_run: ClassVar[dict[str, str]] = {name: name for name in ("straight_density", "manoeuvre_density")}

    def __post_init__(self) -> None:
        _check(self._set)

    @cached_property
    def _set(self) -> ModelSet:
        if self.model_set is not None:
            return self.model_set
        bank = self.bank_limit if self.bank is None else self.bank
        return improved_set(self.straight_density, self.manoeuvre_density, self.acceleration, bank)

    @property
    def channels(self) -> tuple[str, ...]:
        return self._set.models[0].channels

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the models."""
        return self._set.names

    def begin(self, prior: Gaussian) -> Packed:
        batch = prior.mean.ndim - 1
        count = len(self._set.models)
        weights = lift(np.array(self._set.probabilities), 1, batch)
        mean = np.repeat(prior.mean[:, None], count, axis=1)
        return pack(Mixture(weights, mean, np.repeat(lift(prior.cov, 2, batch)[:, :, None], count, axis=2)))

    def step(self, state: Packed, dt: float, z: Any | None, R: Any | None) -> tuple[Packed, Innovation | None]:
        if dt > 0.0:  # no time, no switching
            state = interact(state, switching_over(self._set, dt))
            state = _moved(state, self._set.models, dt)
        if z is None:
            return state, None
        predicted = np.einsum("m...,im...->i...", state.weights, state.mean)
        return update(state, *self.measurement.linearise(z, R, predicted))

    def estimate(self, state: Packed) -> Mixture:
        return unpack(state)


def _moved(state: Packed, models: tuple[Motion, ...], dt: float) -> Packed:
    """The state dt (s) later, before anything is measured."""
    if any(model.depends_on_state for model in models):
        return predict(state, *transitions(models, dt, state.mean))
    return predict_shared(state, _shared(models, dt))


@lru_cache(maxsize=64)
def _shared(models: tuple[Motion, ...], dt: float) -> SharedMotion:
    return shared_motion(*_fixed(models, dt, 0)[:2])


def switching_over(model_set: ModelSet, dt: float) -> Any:
    """Switching matrix (M, M) over dt (s)."""
    periods = 1.0 if model_set.period is None else round(dt / model_set.period, 9)
    return _power(model_set.switching, periods)


@lru_cache(maxsize=256)
def _power(switching: tuple[tuple[float, ...], ...], periods: float) -> Any:
    from scipy.linalg import fractional_matrix_power

    matrix = np.array(switching)
    if periods.is_integer():
        return np.asfortranarray(np.linalg.matrix_power(matrix, int(periods)))  # it is transposed at every step
    part = np.clip(np.real(fractional_matrix_power(matrix, periods)), 0.0, None)
    return part / part.sum(axis=1, keepdims=True)


def transitions(models: tuple[Motion, ...], dt: float, mean: Any) -> Transition:
    """Transitions of all models (n, n, M, *C) from the mean (n, M, *B) of each."""
    batch = mean.ndim - 2
    if not any(model.depends_on_state for model in models):
        return _fixed(models, dt, batch)
    each = [model.transition(dt, mean[:, i]) for i, model in enumerate(models)]
    F = _side_by_side([lift(one.F, 2, batch) for one in each])
    Q = _side_by_side([lift(one.Q, 2, batch) for one in each])
    if all(one.u is None for one in each):
        return Transition(F, Q)
    still = np.zeros(mean[:, 0].shape)
    return Transition(F, Q, np.stack([still if one.u is None else one.u for one in each], axis=1))


@lru_cache(maxsize=64)
def _fixed(models: tuple[Motion, ...], dt: float, batch: int) -> Transition:
    each = [model.transition(dt, None) for model in models]
    F, Q = (np.stack(matrices) for matrices in ([one.F for one in each], [one.Q for one in each]))
    return Transition(lift(np.moveaxis(F, 0, -1), 3, batch), lift(np.moveaxis(Q, 0, -1), 3, batch))


def _side_by_side(matrices: list[Any]) -> Any:
    shape = np.broadcast_shapes(*(matrix.shape for matrix in matrices))
    return np.stack([np.broadcast_to(matrix, shape) for matrix in matrices], axis=2)


def _check(model_set: ModelSet) -> None:
    models, switching, probabilities, period, names = model_set
    count = len(models)
    if not count:
        raise ValueError("a model set needs at least one model")
    if len({model.channels for model in models}) != 1:
        raise ValueError("the models of a set must share one state")
    if len(switching) != count or any(len(row) != count for row in switching):
        raise ValueError(f"switching must be {count} rows of {count} probabilities")
    if len(probabilities) != count:
        raise ValueError(f"there must be {count} initial probabilities, not {len(probabilities)}")
    if any(not entry >= 0.0 for row in (*switching, probabilities) for entry in row):
        raise ValueError("probabilities must not be negative")
    for i, row in enumerate(switching):
        if abs(sum(row) - 1.0) > 1e-12:
            raise ValueError(f"row {i} of the switching matrix sums to {sum(row):.12g}, not to one")
    if names and len(names) != count:
        raise ValueError(f"there must be {count} names of models, not {len(names)}")
    if period is not None and not period > 0.0:
        raise ValueError("the period of the switching matrix must be positive")
    if abs(sum(probabilities) - 1.0) > 1e-12:
        raise ValueError(f"the initial probabilities sum to {sum(probabilities):.12g}, not to one")
