"""Radio-beacon mode: bank commanded by the angle off the prescribed direction and the error of the course."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self

from aircraft.ranges import ABOVE_ZERO, NOT_NEGATIVE, check_ranges
from autopilot.mode import DesignCase, LimitedInput
from autopilot.saturation import saturate

DISTANCE = 2000.0  # m; there the stiffness k3/D of the designed law is that of the route law
INTERCEPT = math.radians(30.0)


@dataclass(frozen=True)
class RadioBeacon:
    """The law ``bank = c{k3 c3{eps} - k4 dpsi}`` with its two limits [Vasylyev 2003, eq. (5)].

    ``eps`` is the bearing to the beacon minus the course, so it is negative right of the leg and the law restores.
    ``dpsi`` is the error of the heading, or of the ground track: in a crosswind the heading form settles off the leg,
    where ``k3 eps = k4 (eps + drift)``, and flies the homing curve. Inside ``cone_radius`` of the station
    the bearing means nothing and only the course is held.

    Erratum: printed without the sign of eps, used eps = -atan2(z, D), because k3 > 0 drives the aircraft away from
    the leg otherwise.
    """

    k3: Annotated[float, ABOVE_ZERO]
    k4: Annotated[float, ABOVE_ZERO]
    bank_limit: Annotated[Any, "rad", ABOVE_ZERO]
    bearing_limit: Annotated[Any, "rad", ABOVE_ZERO]
    course: Literal["track", "heading"] = "track"
    cone_radius: Annotated[float, "m", NOT_NEGATIVE] = 500.0

    intent: ClassVar[str] = "beacon law"
    standard: ClassVar[bool] = True
    intercept: ClassVar[tuple[str, ...]] = ("bearing_limit",)

    def __post_init__(self) -> None:
        if self.course not in ("track", "heading"):
            raise ValueError(f"the course of the radio-beacon law is 'track' or 'heading', not '{self.course}'")
        check_ranges(self)

    @classmethod
    def designed(cls, given: dict[str, Any], case: DesignCase) -> Self:
        """Stiffness k1 = k3/D, damping k2 = k4/V and intercepts at 30 degrees, where the file is silent."""
        k3 = given.get("k3", case.k1 * DISTANCE)
        k4 = given.get("k4", case.k2 * case.speed)
        limit = given.get("bearing_limit", k4 * INTERCEPT / k3)
        return cls(**{**given, "k3": k3, "k4": k4, "bearing_limit": limit, "bank_limit": case.bank_limit})

    def __call__(self, deviation: Any) -> Any:
        """Bank command, rad, for a deviation with the bearing error and the track or heading error (rad)."""
        course_error = deviation.track_error if self.course == "track" else deviation.heading_error
        outside = deviation.distance_to_go > self.cone_radius
        bearing = saturate(deviation.bearing_error, self.bearing_limit) * outside
        return saturate(self.k3 * bearing - self.k4 * course_error, self.bank_limit)

    def limits(self) -> tuple[LimitedInput, ...]:
        """The bearing, outside the cone, and the course."""
        return (
            LimitedInput("bearing_error", -self.k3, self.bearing_limit, self.cone_radius),
            LimitedInput(f"{self.course}_error", self.k4),
        )

    def explain(self) -> str:
        """Equation, gains and limits."""
        return (
            f"bank = c{{k3 c3{{eps}} - k4 dpsi}} [Vasylyev 2003, eq. (5)]: k3 {self.k3:.3g}, k4 {self.k4:.3g}, "
            f"bank limit {math.degrees(self.bank_limit):.1f} deg, bearing limit "
            f"{math.degrees(self.bearing_limit):.2f} deg, on the {self.course}"
        )

    def check_convergence(self, ground_speed: float, offset: float = math.inf, turns: bool = False) -> None:
        """Nothing: the bearing brings every course back to the beacon, at whatever speed."""
