"""Every random number of a run: one stream per kind of draw, addressed and never shared."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field

import numpy as np

BLOCK = 256  # rows drawn at once; the values do not depend on it


def stream(seed: int, flight: int, draw: int, name: str) -> np.random.Generator:
    """Generator of one kind of draw, such as ``radar.noise``, in one draw of one flight.

    Adding a sensor, more draws, other chunks or more workers leaves every other stream as it is. The name enters by
    128 bits of its digest: 32 would be few enough for two names of sensors to share their noise.
    """
    digest = hashlib.blake2b(name.encode(), digest_size=16).digest()
    words = (int.from_bytes(digest[i : i + 4], "little") for i in range(0, 16, 4))
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(flight, draw, *words))))


@dataclass
class Rows:
    """Rows of standard normal (or uniform) numbers for an ensemble of draws; row k belongs to epoch k.

    Drawing in blocks gives the numbers that drawing row by row would give, so a sensor in the loop and the same
    sensor on a recorded flight see the same noise.
    """

    generators: list[np.random.Generator]
    columns: int
    uniform: bool = False
    _block: np.ndarray = field(default_factory=lambda: np.empty((0, 0, 0)))
    _used: int = 0

    def row(self) -> np.ndarray:
        """The next row, shape (columns, draws)."""
        if self._used == len(self._block):
            shape = (BLOCK, self.columns)
            drawn = [g.random(shape) if self.uniform else g.standard_normal(shape) for g in self.generators]
            self._block, self._used = np.stack(drawn, axis=-1), 0
        self._used += 1
        row: np.ndarray = self._block[self._used - 1]
        return row


@dataclass(frozen=True)
class Streams:
    """The streams of one named thing (a sensor, the wind) over the draws of one flight."""

    seed: int
    flight: int
    draws: int
    owner: str

    def normal(self, kind: str, columns: int) -> Rows:
        """Standard normal rows for one kind of draw, such as ``noise`` or ``bias``."""
        return Rows(self._generators(kind), columns)

    def uniform(self, kind: str, columns: int) -> Rows:
        """Rows uniform on 0..1, for detection and clutter."""
        return Rows(self._generators(kind), columns, uniform=True)

    def generator(self, kind: str) -> np.random.Generator:
        """The single generator of draw 0, for what a flight has once (turbulence, wind, start)."""
        return stream(self.seed, self.flight, 0, f"{self.owner}.{kind}")

    def _generators(self, kind: str) -> list[np.random.Generator]:
        return [stream(self.seed, self.flight, draw, f"{self.owner}.{kind}") for draw in range(self.draws)]
