"""The record of one flight, flown here or anywhere: states, commands, phases and events at 30 Hz."""

from __future__ import annotations

import dataclasses
import itertools
import struct
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState, Command
from autopilot.route import ArrayDeviation, PathDeviation, Route

RECORD_STEP = 1.0 / 30.0  # s, of the record and of the autopilot
UNKNOWN = "unknown"  # outcome of a flight that only plots tell of: its motion is NaN


ROW = np.dtype(
    [
        ("state", np.float64, len(AircraftState._fields)),
        ("command", np.float64, len(Command._fields)),
        ("leg", np.int64),
        ("phase", np.int64),
    ]
)
PLAIN = struct.Struct(f"@{len(AircraftState._fields) + len(Command._fields)}d2q")  # the same
SET_ASIDE = 36_000  # rows, 20 minutes; memory that is never written costs nothing


class Event(NamedTuple):
    """Something that happened once."""

    time: float  # s
    name: str
    detail: str = ""


@dataclass(frozen=True)
class Flight:
    """One closed-loop flight; every array has the record's k instants in front."""

    route: Route
    state: AircraftState  # of arrays (k,)
    command: Command  # of arrays (k,)
    leg: np.ndarray  # (k,) int
    phase: np.ndarray  # (k,) index into phases
    phases: tuple[str, ...]
    events: tuple[Event, ...]
    outcome: str
    reason: str
    gate_height: float | None = None  # m; at and below, the approach must be stabilised; None = no gate was flown
    rollout: Flight | None = None  # from the landing to the stop; None = there was none
    utc: float | None = None  # s since 1970 at its time 0; None = it was flown at no date

    def __repr__(self) -> str:
        """One line; the arrays have thousands of instants."""
        span = f"{self.time[0]:.1f} to {self.time[-1]:.1f} s" if len(self.time) else "no instant"
        return f"<Flight {self.outcome}, {span}, {len(self.time)} instants; phases {', '.join(self.phases)}>"

    @property
    def known(self) -> bool:
        """Whether there is a true motion, against which anything can be judged."""
        return self.outcome != UNKNOWN

    @property
    def whole(self) -> Flight:
        """The flight with its roll-out as one record; the outcome stays that of the flight."""
        more = self.rollout
        if more is None:
            return self
        return dataclasses.replace(
            self,
            state=AircraftState(*map(_joined, self.state, more.state)),
            command=Command(*map(_joined, self.command, more.command)),
            leg=np.concatenate((self.leg, more.leg)),
            phase=np.concatenate((self.phase, more.phase)),
            events=(*self.events, *more.events),
            rollout=None,
        )

    @property
    def time(self) -> np.ndarray:
        """(k,) s."""
        return np.asarray(self.state.time)

    @property
    def deviation(self) -> PathDeviation | ArrayDeviation:
        """Deviation from the leg that was active, of arrays (k,)."""
        s = self.state
        return self.route.deviation(self.leg, (s.north, s.east), (s.velocity_north, s.velocity_east), s.heading)

    @property
    def wind(self) -> np.ndarray:
        """(3, k) m/s north, east, up: the way the air moves, from the velocity over the ground and through the air."""
        s = self.state
        return np.asarray(np.array((s.velocity_north, s.velocity_east, s.velocity_up)) - np.array(s.air_velocity))

    @property
    def is_recorded(self) -> bool:
        """Whether it was flown elsewhere, at a date, and seen from outside: what only the aircraft knows is NaN.

        One that only plots tell of need have no date.
        """
        return not self.known or (self.utc is not None and bool(np.isnan(self.state.airspeed).all()))

    def during(self, phases: str | tuple[str, ...]) -> np.ndarray:
        """(k,) bool: where one of the phases was flown.

        ``all`` is everywhere, ``gate`` the glide path at the height of the stabilised-approach gate and below.
        """
        wanted = (phases,) if isinstance(phases, str) else phases
        if "all" in wanted:
            return np.ones(len(self.time), bool)
        flown = np.isin(self.phase, [i for i, name in enumerate(self.phases) if name in wanted])
        if "gate" in wanted and self.gate_height is not None:
            flown |= self.during("glide") & (self.state.height <= self.gate_height)
        return flown


class Recorder:
    """The rows of a flight while it is flown, in memory that is set aside before: no object of a step outlives it."""

    __slots__ = ("_bytes", "_count", "_rows")

    def __init__(self) -> None:
        self._count = 0
        self._set_aside(np.empty(SET_ASIDE, ROW))

    def _set_aside(self, rows: np.ndarray) -> None:
        self._rows, self._bytes = rows, rows.data

    def add(self, state: AircraftState, command: Command, leg: int, phase: int) -> None:
        """One record of plain numbers."""
        count = self._count
        if count == len(self._rows):
            self._set_aside(np.concatenate((self._rows, np.empty_like(self._rows))))
        PLAIN.pack_into(self._bytes, count * PLAIN.size, *state, *command, leg, phase)
        self._count = count + 1

    def columns(self) -> tuple[AircraftState, Command, np.ndarray, np.ndarray]:
        """State, command, leg and phase of arrays (k,)."""
        rows = self._rows[: self._count]
        state, command, leg, phase = (rows[name].copy() for name in ("state", "command", "leg", "phase"))
        return AircraftState(*state.T), Command(*command.T), leg, phase


def _joined(first: Any, second: Any) -> np.ndarray:
    return np.concatenate((first, second))


def runs(values: Any) -> list[tuple[int, int]]:
    """(first, one past last) of every unbroken stretch of equal values."""
    values = np.asarray(values)
    if not len(values):
        return []
    edges = np.flatnonzero(values[1:] != values[:-1]) + 1
    bounds = [0, *edges.tolist(), len(values)]
    return list(itertools.pairwise(bounds))
