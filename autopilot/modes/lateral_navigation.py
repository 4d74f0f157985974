"""Route mode: bank commanded by the cross-track deviation and its rate, each through its own limit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

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

    def __post_init__(self) -> None:
        for name in ("k1", "k2", "bank_limit", "cross_track_limit", "cross_track_rate_limit"):
            if not np.all(np.asarray(getattr(self, name)) > 0.0):
                raise ValueError(f"{name} of the lateral navigation law must be positive, not {getattr(self, name)}")

    def __call__(self, deviation: Any) -> Any:
        """Bank command, rad, for ``deviation.cross_track`` (m) and ``deviation.cross_track_rate`` (m/s)."""
        position = saturate(deviation.cross_track, self.cross_track_limit)
        rate = saturate(deviation.cross_track_rate, self.cross_track_rate_limit)
        return saturate(-self.k1 * position - self.k2 * rate, self.bank_limit)

    @property
    def intercept_speed(self) -> Any:
        """Cross-track rate at which the position limit is balanced, m/s: where far intercepts settle."""
        return self.k1 * self.cross_track_limit / self.k2

    def check_convergence(self, ground_speed: float, offset: float = np.inf, turns: bool = False) -> None:
        """Raise ``ValueError`` when the aircraft would orbit instead of reaching the leg [Vasylyev 2003, eq. (4)].

        Far out the bank must return to zero on some course: k1 min(z_max, offset) < k2 min(zdot_max, ground speed).
        The limit zdot_max alone does not decide, because the cross-track rate cannot exceed the ground speed. A law
        that also flies the turn between two legs must keep the whole bank limit while the leg is far abeam.

        Parameters
        ----------
        ground_speed : m/s, the least that the wind allows
        offset : m, the largest distance from which the leg is approached
        turns : whether the law flies turns between legs
        """
        position = float(np.max(self.k1 * np.minimum(self.cross_track_limit, offset)))
        rate = float(np.min(self.k2 * np.minimum(self.cross_track_rate_limit, max(ground_speed, 0.0))))
        if position >= rate:
            raise ValueError(
                f"the law would orbit: far from the leg it asks for {np.degrees(position):.1f} deg of bank, but at "
                f"{ground_speed:.0f} m/s over the ground the rate takes back only {np.degrees(rate):.1f} deg"
            )
        bank = float(np.max(self.bank_limit))
        if turns and position + bank > rate * (1 + 1e-9):
            raise ValueError(
                f"the law cannot fly the turns of this route: at {ground_speed:.0f} m/s over the ground only "
                f"{np.degrees(rate - position):.1f} deg of bank are left abeam of a leg, "
                f"less than the bank limit of {np.degrees(bank):.1f} deg"
            )
