"""Level flight at constant speed through a sequence of turns: closed form in bank, course and acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import STANDARD_GRAVITY, AircraftState
from sim.flight.truths._motion import state_of_motion

Array = Any

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)  # exact to rounding over a record step


class Turn(NamedTuple):
    """A change of course after some straight flight."""

    after: float  # s of straight flight
    angle: float  # rad, + right


@dataclass(frozen=True)
class TurningFlight:
    """Straights and turns, rolled into and out of at a constant rate, so that the bank is linear in time by pieces.

    With bank ``b = b0 + p s`` the course ``g/V int tan b ds`` is ``g/(V p) ln(cos b0 / cos b)``; a turn that is over
    before the full bank is reached is flown with less.
    """

    speed: float  # m/s
    bank: float  # rad, of the steady turns
    roll_rate: float  # rad/s
    turns: tuple[Turn, ...]
    straight: float  # s after the last turn
    start: tuple[float, float, float]  # m: north, east, height
    course: float  # rad, at the start

    def __post_init__(self) -> None:
        if not self.speed > 0.0 or not self.roll_rate > 0.0:
            raise ValueError("speed and roll rate must be positive")
        if not 0.0 < self.bank < 0.5 * math.pi:
            raise ValueError(f"the bank of a turn must lie between 0 and 90 deg, not {math.degrees(self.bank):.1f} deg")

    @property
    def knots(self) -> tuple[Array, Array]:
        """Times (s) and banks (rad) between which the bank is linear."""
        time, bank = [0.0], [0.0]
        per_turn = STANDARD_GRAVITY / self.speed
        for turn in self.turns:
            half = 0.5 * abs(turn.angle) / per_turn * self.roll_rate  # ln(1/cos b) that half of the turn may use
            peak = min(self.bank, math.acos(math.exp(-half)))
            rolling = peak / self.roll_rate
            ramps = -2.0 * math.log(math.cos(peak)) * per_turn / self.roll_rate
            steady = max(abs(turn.angle) - ramps, 0.0) / (per_turn * math.tan(peak)) if peak > 0.0 else 0.0
            signed = math.copysign(peak, turn.angle)
            for duration, value in ((turn.after, 0.0), (rolling, signed), (steady, signed), (rolling, 0.0)):
                time.append(time[-1] + duration)
                bank.append(value)
        time.append(time[-1] + self.straight)
        bank.append(0.0)
        return np.array(time), np.array(bank)

    @property
    def entries(self) -> Array:
        """(turns,) s: when each turn begins."""
        return self.knots[0][1::4][: len(self.turns)]

    def state(self, step: float) -> AircraftState:
        """The record, every ``step`` seconds up to the end."""
        time = step * np.arange(math.floor(self.knots[0][-1] / step + 1e-9) + 1)
        bank, course = self._course(time)
        heading = np.array([np.cos(course), np.sin(course), np.zeros_like(course)])
        right = np.array([-np.sin(course), np.cos(course), np.zeros_like(course)])
        _, inside = self._course(time[:-1, None] + 0.5 * step * (1.0 + NODES))
        moved = 0.5 * step * self.speed * np.array([np.cos(inside) @ WEIGHTS, np.sin(inside) @ WEIGHTS])
        ground = np.concatenate([np.zeros((2, 1)), np.cumsum(moved, axis=1)], axis=1)
        position = np.array([self.start[0] + ground[0], self.start[1] + ground[1], np.full_like(bank, self.start[2])])
        return state_of_motion(
            time, position, self.speed * heading, STANDARD_GRAVITY * np.tan(bank) * right, np.asarray(bank)
        )

    def _course(self, time: Array) -> tuple[Array, Array]:
        """Bank and course at any times."""
        knots, banks = self.knots
        spans = np.diff(knots)
        rates = np.divide(np.diff(banks), spans, out=np.zeros_like(spans), where=spans > 0.0)
        turned = self._turned(banks[:-1], rates, spans)
        courses = self.course + np.concatenate([[0.0], np.cumsum(turned)])
        piece = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, len(spans) - 1)
        since = time - knots[piece]
        bank = banks[piece] + rates[piece] * since
        return bank, courses[piece] + self._turned(banks[piece], rates[piece], since)

    def _turned(self, bank: Array, rate: Array, since: Array) -> Array:
        """Course change over a piece that begins at ``bank``."""
        rolling = rate != 0.0
        safe = np.where(rolling, rate, 1.0)
        ramp = np.log(np.cos(bank) / np.cos(bank + rate * since)) / safe
        return STANDARD_GRAVITY / self.speed * np.where(rolling, ramp, np.tan(bank) * since)
