"""From the glide path to the ground: the path, the flare, the de-crab and when each begins."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated

from aircraft.state import STANDARD_GRAVITY
from autopilot.stabilised_gate import StabilisedGate

SCREEN_HEIGHT = 15.24  # m, 50 ft: there the reference speed is flown [CS 25.125]
REFERENCE_MARGIN = 1.3  # of the reference speed over the stall [CS 25.125]
TOUCHDOWN_MARGIN = 1.15  # over the stall, at which a flare means to end; it is not slowed down further
ATTITUDE_HEIGHT = 3.0  # m of the wheels, below which the pitch is led towards what the landing gear allows
CLEARANCE = math.radians(1.0)  # from the pitch at which nose wheel or tail would touch with the main wheels
DECRAB_BANK = 0.5  # of the bank at which a wing tip would touch; the rest is for gusts, and tips behind the wheels
TOUCHDOWN_ANGLE = 0.4 / 58.0  # rad, of the path on which the flare meets the runway
POSITIVE = (
    *("approach_speed", "glide_path", "capture_load_factor", "capture_cross_track", "flare_time"),
    *("stall_speed", "align_height", "align_time", "sideslip_limit", "climb_angle", "regained_height"),
)

HALF_SCALE = 52.5 / 2800.0  # rad, 75 microampere of a localiser that stands 2800 m behind the threshold
SECTOR = 180.0 / 75.0 * HALF_SCALE  # rad, up to which its deviation grows with the angle; beyond it says the side
LEAST_MARGIN = 1.0  # m/s, over which the climb of a go-around fades out


@dataclass(frozen=True)
class Landing:
    """How an approach ends. Heights of the wheels are above the runway, the others are of the aircraft's position."""

    approach_speed: Annotated[float, "m/s"] = 58.0
    stall_speed: Annotated[float, "given"] = 41.3  # m/s, with landing flaps
    flaps: Annotated[float, "rad"] = math.radians(38.0)
    glide_path: Annotated[float, "rad"] = math.radians(2.0 + 40.0 / 60.0)
    capture_load_factor: float = 0.05  # taken off while the path bends down onto the glide path
    capture_cross_track: Annotated[float, "m"] = 130.0  # half scale: no descent outside it
    localiser: Annotated[float | None, "given"] = (
        None  # m, of its antenna behind the aiming point; None = there is none
    )
    flare_time: Annotated[float, "s"] = 3.2  # time constant of the exponential
    align_height: Annotated[float, "m"] = 14.0  # of the wheels, where the de-crab begins
    align_time: Annotated[float, "s"] = 3.0
    sideslip_limit: Annotated[float, "rad"] = math.radians(8.0)
    climb_angle: Annotated[float, "rad"] = math.radians(3.0)  # of the go-around
    regained_height: Annotated[float, "m"] = 100.0  # after which the go-around is over
    wheel_height: Annotated[float, "given"] = 0.0  # m, height of the aircraft's position with the wheels on the ground
    lowest_pitch: Annotated[float, "given"] = -math.pi / 2.0  # rad, with nose wheel and main wheels down
    highest_pitch: Annotated[float, "given"] = math.pi / 2.0  # rad, with tail and main wheels down
    highest_bank: Annotated[float, "given"] = math.pi / 2.0  # rad, with a wing tip and a main wheel down
    sideslip_bank: Annotated[float, "given"] = 0.0  # bank per sideslip that keeps the track straight
    gate: Annotated[StabilisedGate, "given"] = field(default_factory=StabilisedGate)

    def __post_init__(self) -> None:
        for name in POSITIVE:
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} of the landing must be positive, not {getattr(self, name)}")
        if self.glide_path > math.radians(10.0):
            raise ValueError(f"a glide path of {math.degrees(self.glide_path):.1f} deg is too steep: at most 10 deg")

    @cached_property
    def slope(self) -> float:
        """Tangent of the glide path."""
        return math.tan(self.glide_path)

    @cached_property
    def most_sideslip(self) -> float:
        """Sideslip, rad, of the de-crab at most; what then stays of the crab is left to the wheels.

        Its bank is at most `DECRAB_BANK` of what brings a wing tip down: an airliner that needs 2 deg of bank for one
        of sideslip would strike its tip in 12 m/s of crosswind.
        """
        if self.sideslip_bank <= 0.0:
            return self.sideslip_limit
        return min(self.sideslip_limit, max(DECRAB_BANK * self.highest_bank, 0.0) / self.sideslip_bank)

    def may_descend(self, cross_track: float, distance: float, is_established: bool) -> bool:
        """Whether the glide path may be followed so far (m) off the line and before the aiming point.

        Half scale of a localiser is an angle, 52.5 m at the threshold [ICAO annex 10 volume I, 3.1.3.7, from memory].
        Inside it the glide path is captured while the aircraft still turns; without one it has to be established.
        """
        if self.localiser is None:
            return is_established and abs(cross_track) < self.capture_cross_track
        return abs(cross_track) < HALF_SCALE * (distance + self.localiser)

    def sees_line(self, cross_track: float, distance: float) -> bool:
        """Whether the line can be captured so far (m) off it and before the aiming point: a localiser's deviation grows
        with the angle up to 180 microampere [ICAO annex 10 volume I, 3.1.3.7, from memory]."""
        return self.localiser is None or abs(cross_track) < SECTOR * (distance + self.localiser)

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

    @cached_property
    def threshold_speed(self) -> float:
        """Airspeed, m/s, over the threshold: what the approach was flown faster than the reference speed is gone."""
        return min(REFERENCE_MARGIN * self.stall_speed, self.approach_speed)

    @cached_property
    def touchdown_speed(self) -> float:
        """Airspeed, m/s, down to which a flare is slowed: the angle of attack that it takes raises the nose."""
        return min(TOUCHDOWN_MARGIN * self.stall_speed, self.threshold_speed)

    @cached_property
    def touchdown_sink(self) -> float:
        """Sink, m/s, with which the flare meets the runway: every aircraft at the same angle, from the same margin."""
        return TOUCHDOWN_ANGLE * self.threshold_speed

    @cached_property
    def flare_deceleration(self) -> float:
        """Deceleration, m/s2, that takes a flare from ``threshold_speed`` to ``touchdown_speed``.

        The exponential sink' = -sink / flare_time takes flare_time ln(sink / touchdown_sink) from the glide path's sink
        to that of the touchdown.
        """
        time = self.flare_time * max(math.log(self.slope / TOUCHDOWN_ANGLE), 1.0)
        return (self.threshold_speed - self.touchdown_speed) / time

    def slows_down(self, wheels: float, sink: float, airspeed: float, deceleration: float) -> bool:
        """Whether the speed falls now, to be down to ``threshold_speed`` when the wheels (m) pass the screen height.

        ``sink`` and ``airspeed`` are those of the glide path, m/s, ``deceleration`` is in m/s2.
        """
        return (wheels - SCREEN_HEIGHT) * deceleration < (airspeed - self.threshold_speed) * sink

    def flare_begins(self, wheels: float, sink: float) -> bool:
        """Whether the exponential through the wheels' height (m) starts with no more than this sink (m/s)."""
        return wheels < self.flare_time * (sink - self.touchdown_sink)

    def flare_sink(self, wheels: float) -> float:
        """Sink, m/s, of the flare: it decays with the height of the wheels, at the runway to ``touchdown_sink``."""
        return max(wheels, 0.0) / self.flare_time + self.touchdown_sink

    def climb_away(self, airspeed: float, wheels: float) -> float:
        """Fastest climb, m/s, of a go-around at this airspeed (m/s), with the wheels so high (m).

        It is free from ``threshold_speed`` on and none at ``touchdown_speed``; below it height buys speed, down to a
        sink that ends at the runway as a flare does.
        """
        if airspeed >= self.threshold_speed:
            return math.inf
        full = self.threshold_speed * self.climb_angle
        margin = max(self.threshold_speed - self.touchdown_speed, LEAST_MARGIN)
        return max(full * max((airspeed - self.touchdown_speed) / margin, -1.0), -self.flare_sink(wheels))

    def attitude(self, wheels: float, pitch: float) -> float:
        """Angle, rad, by which the flare's path is bent for the landing gear: the nearer to the ground, the more.

        It is the pitch (rad) that lacks for the main wheels to touch first, or, negative, what it is nearer to a strike
        of the tail than ``CLEARANCE``.
        """
        wanted = max(self.lowest_pitch + CLEARANCE, min(pitch, self.highest_pitch - CLEARANCE))
        return (wanted - pitch) * min(max(1.0 - wheels / ATTITUDE_HEIGHT, 0.0), 1.0)
