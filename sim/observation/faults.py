"""Sensors that measure worse than they state: the same noise, larger, from a time on."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.flight.record import Event, Flight
from sim.observation.sensor import Look, quantity_of
from sim.scenario.tables import SensorFault
from tracking.measurement import wrap


def faulty(look: Look, sensor: Any, faults: Sequence[SensorFault], before: AircraftState, after: AircraftState) -> Look:
    """A look between two records as its sensor's ``faults`` leave it; R stays what the sensor states.

    Noise is scaled and not drawn anew: what came before the fault, and what comes after its end, is the same bytes.
    """
    begun = [one for one in faults if one.at <= look.epoch]
    factor = max(begun, key=lambda one: one.at).error_factor if begun else 1.0
    if factor == 1.0:
        return look
    exact = np.asarray(sensor.truth(state_at(before, after, look.epoch)), float)[:, None]
    angles = np.array([quantity_of(channel).wraps for channel in sensor.channels])[:, None]
    error = look.z - exact
    z = exact + factor * np.where(angles, wrap(error), error)
    plots = None if look.candidates is None else np.concatenate((z[None], look.candidates[1:]))
    return look._replace(z=z, candidates=plots)


def with_fault_events(flight: Flight, faults: Sequence[SensorFault]) -> Flight:
    """The flight with the faults of its sensors among the events."""
    begun = [Event(one.at, "sensor_fault", in_words(one)) for one in faults if one.at <= flight.time[-1]]
    if not begun:
        return flight
    return dataclasses.replace(flight, events=tuple(sorted((*flight.events, *begun), key=lambda event: event.time)))


def in_words(fault: SensorFault) -> str:
    """What a sensor does from then on."""
    if fault.error_factor == 1.0:
        return f"{fault.sensor} errs as it states"
    return f"{fault.sensor} errs {fault.error_factor:.3g} times as much as it states"
