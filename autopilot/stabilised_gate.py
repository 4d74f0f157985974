"""Is the approach stabilised? Five-second means against the limits of a stabilised approach."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

BLOCK = 0.5  # s, the window moves in steps of this


class GateState(NamedTuple):
    """Sums over the running block, the blocks of the window, and how long a limit has been exceeded."""

    elapsed: float
    sums: tuple[float, float, float, float]
    blocks: tuple[tuple[float, float, float, float], ...]  # of the whole window, the newest last
    filled: int  # of them, so far
    exceeded: float  # s, INSIDE while no limit is


INSIDE = -1.0
ROUNDING = 1e-6  # s, of a sum of steps
NOTHING = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class StabilisedGate:
    """Limits at ``height`` and below, each on the mean over ``window``, to be exceeded for ``persistence``.

    Defaults: airspeed from the reference speed to 20 kt above it, sink 1000 ft/min, one dot of the glide path and of
    the localiser (0.35 deg, half of 105 m) [FSF ALAR; PANS-OPS half-scale rule].
    """

    height: Annotated[float, "m"] = 300.0
    slow: Annotated[float, "m/s"] = 4.3  # below the approach speed
    fast: Annotated[float, "m/s"] = 8.0  # above it
    sink: Annotated[float, "m/s"] = 5.08
    glide_path: Annotated[float, "rad"] = math.radians(0.35)
    height_error: Annotated[float, "m"] = 8.0  # never asked to be nearer to the glide path than this
    cross_track: Annotated[float, "m"] = 52.5
    window: Annotated[float, "s"] = 5.0
    persistence: Annotated[float, "s"] = 3.0

    def __post_init__(self) -> None:
        for name in ("slow", "fast", "sink", "glide_path", "height_error", "cross_track"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the stabilised-approach gate must be positive, not {getattr(self, name)}")
        if not self.window >= BLOCK or not self.persistence >= 0.0:
            raise ValueError(
                f"the window of the stabilised-approach gate must be at least {BLOCK} s, its persistence not negative"
            )

    def begin(self) -> GateState:
        """Nothing measured yet."""
        return GateState(0.0, NOTHING, (NOTHING,) * round(self.window / BLOCK), 0, INSIDE)

    def step(
        self,
        s: GateState,
        airspeed_error: float,
        sink: float,
        height_error: float,
        cross_track: float,
        distance: float,
        dt: float,
    ) -> GateState:
        """Add one sample; errors are flown minus wanted, ``distance`` (m) is to the aiming point."""
        elapsed, sums, blocks, filled, exceeded = s
        elapsed += dt
        sums = (
            sums[0] + airspeed_error * dt,
            sums[1] + sink * dt,
            sums[2] + height_error * dt,
            sums[3] + cross_track * dt,
        )
        if elapsed < BLOCK - ROUNDING:
            return GateState(elapsed, sums, blocks, filled, exceeded)
        wanted = len(blocks)
        mean = (sums[0] / elapsed, sums[1] / elapsed, sums[2] / elapsed, sums[3] / elapsed)
        blocks, filled = (*blocks[1:], mean), min(filled + 1, wanted)
        if filled == wanted:
            airspeed_error, sink, height_error, cross_track = (
                sum(column) / wanted for column in zip(*blocks, strict=True)
            )
            outside = (
                not -self.slow <= airspeed_error <= self.fast
                or sink > self.sink
                or abs(height_error) > max(self.glide_path * distance, self.height_error)
                or abs(cross_track) > self.cross_track
            )
            exceeded = INSIDE if not outside else 0.0 if exceeded == INSIDE else exceeded + elapsed
        return GateState(0.0, NOTHING, blocks, filled, exceeded)

    def missed(self, s: GateState) -> bool:
        """Whether a limit was exceeded for long enough: go around."""
        return s.exceeded >= self.persistence - ROUNDING and s.exceeded != INSIDE
