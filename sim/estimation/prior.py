"""What the components of a tracker's state truly were, and what is known of them when a track begins."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.interpolation import truth_at
from sim.flight.record import Flight
from sim.randomness import stream
from tracking.gaussian import Gaussian
from tracking.measurement import wrap

PRIOR_POSITION, PRIOR_RATE, PRIOR_ACCELERATION = 100.0, 5.0, 0.5  # m, m/s, m/s2: of the unit that hands over
DIFFERENCE = 0.1  # s, of the central differences behind rates
ORDERS = ("", "_rate", "_acceleration")
PLANE = ("north", "east", "height")


def split(component: str) -> tuple[str, int]:
    """(quantity, order of its derivative) of a component such as ``radar.azimuth_rate``."""
    for order in (2, 1):
        if component.endswith(ORDERS[order]):
            return component.removesuffix(ORDERS[order]), order
    return component, 0


def true_values(flight: Flight, sensors: dict[str, Any], component: str, time: np.ndarray) -> np.ndarray:
    """(k,) true values of a component at ``time`` (k,); rates by central differences.

    Raises ``KeyError`` for a component that no flight has.
    """
    quantity, order = split(component)
    if order == 0:
        return _quantity(flight, sensors, quantity, time)
    first, last = flight.time[0] + DIFFERENCE, flight.time[-1] - DIFFERENCE
    middle = np.clip(time, first, last)
    before, now, after = (
        _quantity(flight, sensors, quantity, middle + shift) for shift in (-DIFFERENCE, 0.0, DIFFERENCE)
    )
    if quantity.endswith(("azimuth", "elevation")):
        before, after = now + wrap(before - now), now + wrap(after - now)
    if order == 1:
        return np.asarray((after - before) / (2 * DIFFERENCE))
    return np.asarray((after - 2 * now + before) / DIFFERENCE**2)


def _quantity(flight: Flight, sensors: dict[str, Any], quantity: str, time: np.ndarray) -> np.ndarray:
    position = truth_at(flight, time).position
    if quantity in PLANE:
        return np.asarray(position[PLANE.index(quantity)])
    name, _, channel = quantity.rpartition(".")
    sensor = sensors[name]
    return np.asarray(sensor.truth(position)[sensor.channels.index(channel)])


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
        quantity, order = split(component)
        sigma = (PRIOR_POSITION, PRIOR_RATE, PRIOR_ACCELERATION)[order]
        if quantity.endswith(("azimuth", "elevation")):
            sigma /= _distance(flight, sensors[quantity.rpartition(".")[0]], at)
        means.append(true_values(flight, sensors, component, at)[0])
        spreads.append(sigma)
        errors.append([stream(seed, number, draw, f"prior.{component}").standard_normal() for draw in range(draws)])
    sigmas = np.array(spreads)
    return Gaussian(np.array(means)[:, None] + sigmas[:, None] * np.array(errors), np.diag(sigmas**2))


def _distance(flight: Flight, sensor: Any, time: np.ndarray) -> float:
    place = truth_at(flight, time).position[:, 0]
    return float(np.linalg.norm(place - np.array(sensor.antenna)))
