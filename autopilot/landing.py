"""From the glide path to the ground: the path, the flare, the de-crab and when each begins."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Annotated

from aircraft.state import STANDARD_GRAVITY
from autopilot.stabilised_gate import StabilisedGate

SCREEN_HEIGHT = 15.24  # m, 50 ft
FLOATING = 0.25  # of the touchdown sink, at which the path goes on below the runway
POSITIVE = (
    *("approach_speed", "glide_path", "capture_load_factor", "capture_cross_track", "flare_time", "touchdown_sink"),
    *("flare_deceleration", "align_height", "align_time", "sideslip_limit", "climb_angle", "regained_height"),
)


@dataclass(frozen=True)
class Landing:
    """How an approach ends. Heights of the wheels are above the runway, the others are of the aircraft's position."""

    approach_speed: Annotated[float, "m/s"] = 58.0
    threshold_speed: Annotated[float, "m/s"] = 58.0  # to which it is slowed down to before the flare, at most its own
    flaps: Annotated[float, "rad"] = math.radians(38.0)
    glide_path: Annotated[float, "rad"] = math.radians(2.0 + 40.0 / 60.0)
    capture_load_factor: float = 0.05  # taken off while the path bends down onto the glide path
    capture_cross_track: Annotated[float, "m"] = 130.0  # half scale: no descent outside it
    flare_time: Annotated[float, "s"] = 3.2  # time constant of the exponential
    touchdown_sink: Annotated[float, "m/s"] = 0.4
    flare_deceleration: Annotated[float, "m/s2"] = 1.0
    align_height: Annotated[float, "m"] = 14.0  # of the wheels, where the de-crab begins
    align_time: Annotated[float, "s"] = 3.0
    sideslip_limit: Annotated[float, "rad"] = math.radians(8.0)
    climb_angle: Annotated[float, "rad"] = math.radians(3.0)  # of the go-around
    regained_height: Annotated[float, "m"] = 100.0  # after which the go-around is over
    wheel_height: Annotated[float, "given"] = 0.0  # m, height of the aircraft's position with the wheels on the ground
    sideslip_bank: Annotated[float, "given"] = 0.0  # bank per sideslip that keeps the track straight
    gate: Annotated[StabilisedGate, "given"] = field(default_factory=StabilisedGate)

    def __post_init__(self) -> None:
        for name in POSITIVE:
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the landing must be positive, not {getattr(self, name)}")
        if self.glide_path > math.radians(10.0):
            raise ValueError(f"a glide path of {math.degrees(self.glide_path):.1f} deg is too steep: at most 10 deg")

    @property
    def slope(self) -> float:
        """Tangent of the glide path."""
        return math.tan(self.glide_path)

    def bend(self, ground_speed: float) -> float:
        """Length, m, of the parabola onto the glide path that takes ``capture_load_factor`` off."""
        return ground_speed * ground_speed * self.slope / (self.capture_load_factor * STANDARD_GRAVITY)

    def path(self, distance: float, level: float, bend: float) -> tuple[float, float]:
        """Height (m) and slope of the path ``distance`` (m) before the aiming point, from level flight at ``level``.

        A parabola of length ``bend`` joins the level leg and the glide path, so neither the height nor its rate jumps
        and the pitch-over begins before the glide path is reached.
        """
        slope = self.slope
        into = level / slope + 0.5 * bend - distance  # m flown since the bend began
        if into <= 0.0:
            return level, 0.0
        if into >= bend:
            return distance * slope, -slope
        return level - slope * into * into / (2.0 * bend), -slope * into / bend

    def slows(self, wheels: float, sink: float, airspeed: float, deceleration: float) -> bool:
        """x"""
        return (wheels - SCREEN_HEIGHT) * deceleration < (airspeed - self.threshold_speed) * sink

    def flare_begins(self, wheels: float, sink: float) -> bool:
        """Whether the exponential through the wheels' height (m) starts with no more than this sink (m/s)."""
        return wheels < self.flare_time * (sink - self.touchdown_sink)

    def flare_sink(self, wheels: float) -> float:
        """Sink, m/s, of the flare: it decays with the height of the wheels, at the runway to ``touchdown_sink``.

        Below the runway it never ends, for an aircraft that floats above it in ground effect.
        """
        return max(wheels / self.flare_time + self.touchdown_sink, FLOATING * self.touchdown_sink)
