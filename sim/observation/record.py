"""observe(): sensors measure a recorded flight with the same steps as in the closed loop."""

from __future__ import annotations

import bisect
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.errors import ScenarioError
from sim.flight.record import Flight
from sim.observation.faults import faulty
from sim.observation.recordings import dated
from sim.observation.sensor import Look, SensorError, ask, looks_of
from sim.randomness import Streams
from sim.scenario.tables import SensorFault
from tracking.track import Measurements


class SensorRecord(NamedTuple):
    """All measurements of one flight by one sensor."""

    channels: tuple[str, ...]
    time: np.ndarray  # (k,) s
    arrival: np.ndarray  # (k,) s
    z: np.ndarray  # (k, m, draws)
    R: np.ndarray  # (k, m, m), or (k, m, m, draws) where the accuracy depends on the measured place
    candidates: np.ndarray | None = None  # (k, c, m, draws) plots with the false ones, of a sensor with clutter

    def __repr__(self) -> str:
        """One line; the arrays have thousands of looks."""
        k, _, draws = self.z.shape
        plots = ", with false plots" if self.candidates is not None else ""
        return f"<SensorRecord of {', '.join(self.channels)}: {k} looks, {draws} draws{plots}>"

    def until(self, time: float) -> SensorRecord:
        """The looks that were true at ``time`` (s) or before."""
        kept = self.time <= time
        candidates = None if self.candidates is None else self.candidates[kept]
        return SensorRecord(self.channels, self.time[kept], self.arrival[kept], self.z[kept], self.R[kept], candidates)

    def draws(self, chosen: slice) -> SensorRecord:
        """The looks in some of the draws: views."""
        R = self.R if self.R.ndim == 3 else self.R[..., chosen]
        candidates = None if self.candidates is None else self.candidates[..., chosen]
        return self._replace(z=self.z[..., chosen], R=R, candidates=candidates)


def of_draws(records: dict[str, SensorRecord], chosen: slice) -> dict[str, SensorRecord]:
    """What all sensors measured in some of the draws."""
    return {name: record.draws(chosen) for name, record in records.items()}


def observe(
    flight: Flight,
    sensors: dict[str, Any],
    seed: int,
    number: int = 0,
    draws: int = 1,
    faults: Iterable[SensorFault] = (),
) -> dict[str, SensorRecord]:
    """What every sensor measures along a flight and its roll-out, ``draws`` times with independent noise.

    ``faults`` are those of a scenario, its ``sensor_faults``; without them every sensor errs as it states.

    Raises ``ScenarioError`` for a sensor that does not keep its contract, or measures what nobody knows of the flight,
    and for recorded plots of which none falls into the flight.
    """
    sensors = dated(flight, sensors)
    refuse_unknown(flight, sensors)
    return {
        name: _watch(
            flight, name, sensor, Streams(seed, number, draws, name), [one for one in faults if one.sensor == name]
        )
        for name, sensor in sensors.items()
    }


def refuse_unknown(flight: Flight, sensors: dict[str, Any]) -> None:
    """Raise ``ScenarioError`` for a sensor of something that a recorded flight does not know, such as an airspeed.

    What a sensor has recorded itself it need not be told.
    """
    if not flight.is_recorded:
        return
    state = AircraftState(*(float(column[0]) for column in flight.state))
    for name, sensor in sensors.items():
        known = np.isfinite(np.asarray(sensor.truth(state), float))
        unknown = [channel for channel, one in zip(sensor.channels, known, strict=True) if not one]
        if unknown and sensor.recording is None:
            raise ScenarioError(f"[sensors.{name}] measures {', '.join(unknown)}, which a recording does not know")


def _watch(flight: Flight, name: str, sensor: Any, streams: Streams, faults: list[SensorFault]) -> SensorRecord:
    motion = np.array(flight.whole.state)
    times: list[float] = motion[0].tolist()
    looks: list[Look] = []
    try:
        state = ask(sensor, "begin", times[0], streams)
        row = 0
        while (row := max(row, _before(times, state))) < len(times) - 1:
            before, after = (AircraftState(*motion[:, at].tolist()) for at in (row, row + 1))
            state, seen = looks_of(sensor, state, before, after, streams.draws)
            looks += [faulty(look, sensor, faults, before, after) for look in seen]
            row += 1
    except SensorError as error:
        raise ScenarioError(f"[sensors.{name}] {error}") from error
    m = len(sensor.channels)
    if not looks:
        return SensorRecord(
            sensor.channels, np.empty(0), np.empty(0), np.empty((0, m, streams.draws)), np.empty((0, m, m))
        )
    time, arrival, z, R, plots = zip(*looks, strict=True)
    try:
        found = Measurements(sensor.channels, *map(np.array, (time, arrival, z, R)))
    except ValueError as error:
        raise ScenarioError(f"[sensors.{name}] step gives what is no measurement: {error}") from error
    candidates = None if plots[0] is None else np.array(plots)
    return SensorRecord(found.channels, found.time, found.arrival, found.z, found.R, candidates)


def _before(times: list[float], state: Any) -> int:
    """The record before the next epoch of a sensor whose state tells it: what lies between is not walked through."""
    epoch = getattr(state, "epoch", None)
    return bisect.bisect_left(times, epoch) - 1 if isinstance(epoch, float) and epoch > times[0] else 0


def measurements(records: dict[str, SensorRecord], sensors: tuple[str, ...]) -> Measurements:
    """The looks of several sensors at the union of their epochs, NaN where a sensor was silent.

    Candidates are given for a single sensor only: plots of several sensors are not associated with each other here.
    """
    chosen = [(name, records[name]) for name in sensors]
    channels = tuple(f"{name}.{channel}" for name, record in chosen for channel in record.channels)
    draws = chosen[0][1].z.shape[2]
    stamps = np.concatenate([np.column_stack((r.arrival, r.time)) for _, r in chosen])
    stamps = np.unique(stamps, axis=0)
    k, m = len(stamps), len(channels)
    z = np.full((k, m, draws), np.nan)
    per_draw = any(record.R.ndim == 4 for _, record in chosen)  # a stated accuracy that depends on the measured place
    R = np.zeros((k, m, m, draws if per_draw else 1))
    R[:, range(m), range(m)] = 1.0
    candidates = None
    if len(chosen) == 1 and chosen[0][1].candidates is not None:
        candidates = chosen[0][1].candidates[np.lexsort((chosen[0][1].time, chosen[0][1].arrival))]
    row = 0
    for _, record in chosen:
        n = len(record.channels)
        place = np.searchsorted(_sortable(stamps), _sortable(np.column_stack((record.arrival, record.time))))
        z[place, row : row + n] = record.z
        R[place, row : row + n, row : row + n] = record.R if record.R.ndim == 4 else record.R[..., None]
        row += n
    for shared in (z, R):
        shared.flags.writeable = False  # by all trackers: none may change what the others see
    return Measurements(channels, stamps[:, 1], stamps[:, 0], z, R, candidates)


def _sortable(stamps: np.ndarray) -> np.ndarray:
    return stamps[:, 0] + 1j * stamps[:, 1]  # complex numbers sort by their real part first
