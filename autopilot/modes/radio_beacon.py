"""Radio-beacon mode: bank commanded by the angle off the prescribed direction and the error of the course."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np

from autopilot.saturation import saturate


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

    k3: float
    k4: float
    bank_limit: Annotated[Any, "rad"]
    bearing_limit: Annotated[Any, "rad"]
    course: Literal["track", "heading"] = "track"
    cone_radius: Annotated[float, "m"] = 500.0

    def __post_init__(self) -> None:
        if self.course not in ("track", "heading"):
            raise ValueError(f"the course of the radio-beacon law is 'track' or 'heading', not '{self.course}'")
        if not np.all(np.asarray(self.k3) > 0.0) or not np.all(np.asarray(self.k4) > 0.0):
            raise ValueError("k3 and k4 of the radio-beacon law must be positive")
        if not np.all(np.asarray(self.bank_limit) > 0.0) or not np.all(np.asarray(self.bearing_limit) > 0.0):
            raise ValueError("the limits of the radio-beacon law must be positive")
        if not self.cone_radius >= 0.0:
            raise ValueError(f"the cone radius of the radio-beacon law must not be negative, not {self.cone_radius} m")

    def __call__(self, deviation: Any) -> Any:
        """Bank command, rad, for a deviation with the bearing error and the track or heading error (rad)."""
        course_error = deviation.track_error if self.course == "track" else deviation.heading_error
        outside = deviation.distance_to_go > self.cone_radius
        bearing = saturate(deviation.bearing_error, self.bearing_limit) * outside
        return saturate(self.k3 * bearing - self.k4 * course_error, self.bank_limit)
