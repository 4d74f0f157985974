"""Route mode: bank commanded by the cross-track deviation and its rate, each through its own limit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from autopilot.saturation import saturate


@dataclass(frozen=True)
class LateralNavigation:
    """The law ``bank = c{-k1 c1{z} - k2 c2{z'}}`` with its three limits [Vasylyev 2003, eq. (4)].

    Limits may be arrays: a bank of laws is then one call. The law is pure; rate limit and bank lag are states of
    whatever uses it.
    """

    k1: Annotated[Any, "rad/m"]
    k2: Annotated[Any, "rad/(m/s)"]
    bank_limit: Annotated[Any, "rad"]
    cross_track_limit: Annotated[Any, "m"]
    cross_track_rate_limit: Annotated[Any, "m/s"]

    def __call__(self, deviation: Any) -> Any:
        """Bank command, rad, for ``deviation.cross_track`` (m) and ``deviation.cross_track_rate`` (m/s)."""
        position = saturate(deviation.cross_track, self.cross_track_limit)
        rate = saturate(deviation.cross_track_rate, self.cross_track_rate_limit)
        return saturate(-self.k1 * position - self.k2 * rate, self.bank_limit)

    @property
    def intercept_speed(self) -> Any:
        """Cross-track rate at which the position limit is balanced, m/s: where far intercepts settle."""
        return self.k1 * self.cross_track_limit / self.k2
