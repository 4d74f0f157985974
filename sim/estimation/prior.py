"""True values of the components of a tracker's state, and the estimate with which a track begins."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from sim.flight.interpolation import truth_at
from sim.flight.record import Flight
from sim.observation.sensor import quantity_of
from sim.randomness import stream
from tracking.gaussian import Gaussian
from tracking.measurement import wrap

PRIOR_POSITION, PRIOR_RATE, PRIOR_ACCELERATION = 100.0, 5.0, 0.5  # m, m/s, m/s2: of the unit that hands over
DIFFERENCE = 0.1  # s, of the central differences behind rates
SPREADS = (PRIOR_POSITION, PRIOR_RATE, PRIOR_ACCELERATION)
NEAR = 1000.0  # m, distance that turns the spread of a position into one of an angle, for a sensor without antenna
ORDERS = ("", "_rate", "_acceleration")
PLANE = ("north", "east", "height")


def split(component: str) -> tuple[str, int]:
    """(quantity, order of its derivative) of a component such as ``radar.azimuth_rate``."""
    for order in (2, 1):
        if component.endswith(ORDERS[order]):
            return component.removesuffix(ORDERS[order]), order
    return component, 0


def _measured_or_derived(sensors: dict[str, Any], component: str) -> tuple[str, int]:
    """As `split`, but a rate that is itself a channel of a sensor, and no derivative of another one, is a quantity."""
    quantity, order = split(component)
    name, _, channel = component.rpartition(".")
    own = sensors[name].channels if name in sensors else ()
    return (component, 0) if channel in own and quantity.rpartition(".")[2] not in own else (quantity, order)


def true_values(flight: Flight, sensors: dict[str, Any], component: str, time: np.ndarray) -> np.ndarray:
    """(k,) true values of a component at ``time`` (k,); rates by central differences.

    Raises ``KeyError`` for a component that no flight has.
    """
    quantity, order = _measured_or_derived(sensors, component)
    if order == 0:
        return _quantity(flight, sensors, quantity, time)
    first, last = flight.time[0] + DIFFERENCE, flight.time[-1] - DIFFERENCE
    middle = np.clip(time, first, last)
    before, now, after = (
        _quantity(flight, sensors, quantity, middle + shift) for shift in (-DIFFERENCE, 0.0, DIFFERENCE)
    )
    if quantity_of(quantity).wraps:
        before, after = now + wrap(before - now), now + wrap(after - now)
    if order == 1:
        return np.asarray((after - before) / (2 * DIFFERENCE))
    return np.asarray((after - 2 * now + before) / DIFFERENCE**2)


def _quantity(flight: Flight, sensors: dict[str, Any], quantity: str, time: np.ndarray) -> np.ndarray:
    truth = truth_at(flight, time)
    if quantity in PLANE:
        return np.asarray(truth.position[PLANE.index(quantity)])
    name, _, channel = quantity.rpartition(".")
    if name not in sensors or channel not in sensors[name].channels:
        raise KeyError(quantity)
    return np.asarray(sensors[name].truth(truth.state)[sensors[name].channels.index(channel)])


def prior(
    flight: Flight,
    sensors: dict[str, Any],
    components: tuple[str, ...],
    time: float,
    seed: int,
    number: int,
    draws: int,
) -> Gaussian:
    """The truth at ``time`` and, for each draw, an error of the stated spread; the same error for every tracker."""
    at = np.array([time])
    means, spreads, errors = [], [], []
    for component in components:
        quantity, order = _measured_or_derived(sensors, component)
        sigma = SPREADS[min(order + (quantity_of(quantity) == quantity_of("range_rate")), 2)]
        if quantity_of(quantity).wraps:
            sigma /= _distance(flight, sensors[quantity.rpartition(".")[0]], at)
        means.append(true_values(flight, sensors, component, at)[0])
        spreads.append(sigma)
        errors.append(_errors(seed, number, draws, component))
    sigmas = np.array(spreads)
    return Gaussian(np.array(means)[:, None] + sigmas[:, None] * np.array(errors), np.diag(sigmas**2))


@lru_cache(maxsize=64)
def _errors(seed: int, number: int, draws: int, component: str) -> tuple[float, ...]:
    """Standard normal errors of a component, one for each draw: every tracker begins with the same."""
    return tuple(stream(seed, number, draw, f"prior.{component}").standard_normal() for draw in range(draws))


def _distance(flight: Flight, sensor: Any, time: np.ndarray) -> float:
    if sensor.antenna is None:
        return NEAR
    place = truth_at(flight, time).position[:, 0]
    return float(np.linalg.norm(place - np.array(sensor.antenna)))
