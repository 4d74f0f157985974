"""Route mode: bank commanded by the cross-track deviation and its rate, each through its own limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Self

import numpy as np

from aircraft.ranges import ABOVE_ZERO, check_ranges
from aircraft.state import STANDARD_GRAVITY
from autopilot.mode import RATE_MARGIN, DesignCase, LimitedInput, Mode
from autopilot.saturation import saturate


@dataclass(frozen=True)
class LateralNavigation:
    """The law ``bank = c{-k1 c1{z} - k2 c2{z'}}`` with its three limits [Vasylyev 2003, eq. (4)].

    Limits may be arrays: a bank of laws is then one call. The law is pure; rate limit and bank lag are states of
    whatever uses it.
    """

    k1: Annotated[Any, "rad/m", ABOVE_ZERO]
    k2: Annotated[Any, "rad/(m/s)", ABOVE_ZERO]
    bank_limit: Annotated[Any, "rad", ABOVE_ZERO]
    cross_track_limit: Annotated[Any, "m", ABOVE_ZERO]
    cross_track_rate_limit: Annotated[Any, "m/s", ABOVE_ZERO]

    intent: ClassVar[str] = "route law"
    standard: ClassVar[bool] = True
    intercept: ClassVar[tuple[str, ...]] = ("cross_track_limit", "cross_track_rate_limit")

    def __post_init__(self) -> None:
        check_ranges(self)

    @classmethod
    def designed(cls, given: dict[str, Any], case: DesignCase) -> Self:
        """Gains and limits from what bank loop and bank limit allow, unless a file sets them [Vasylyev 2003, eq. (4)].

        The limit of the rate follows the others: it leaves the whole bank to the turn between two legs.
        """
        k1, k2 = given.get("k1", case.k1), given.get("k2", case.k2)
        limit = given.get("cross_track_limit", case.cross_track_limit)
        rate_limit = given.get("cross_track_rate_limit")
        if rate_limit is None:
            rate_limit = RATE_MARGIN * (k1 * limit + case.bank_limit) / k2
        return cls(k1, k2, case.bank_limit, limit, rate_limit)

    @classmethod
    def of(cls, law: Mode) -> Self | None:
        """Any mode written as this law, which theory knows; None for one that does something else."""
        inputs = law.limits()
        if [one.of for one in inputs] != ["cross_track", "cross_track_rate"]:
            return None
        position, rate = inputs
        if not (position.gain > 0.0 and rate.gain > 0.0):
            return None
        return cls(position.gain, rate.gain, law.bank_limit, position.limit, rate.limit)

    def __call__(self, deviation: Any) -> Any:
        """Bank command, rad, for ``deviation.cross_track`` (m) and ``deviation.cross_track_rate`` (m/s)."""
        position = saturate(deviation.cross_track, self.cross_track_limit)
        rate = saturate(deviation.cross_track_rate, self.cross_track_rate_limit)
        return saturate(-self.k1 * position - self.k2 * rate, self.bank_limit)

    def limits(self) -> tuple[LimitedInput, ...]:
        """Cross-track and its rate."""
        return (
            LimitedInput("cross_track", self.k1, self.cross_track_limit),
            LimitedInput("cross_track_rate", self.k2, self.cross_track_rate_limit),
        )

    def explain(self) -> str:
        """Equation, gains, limits, and what it does inside them."""
        return (
            f"bank = c{{-k1 c1{{z}} - k2 c2{{z'}}}} [Vasylyev 2003, eq. (4)]: k1 {math.degrees(self.k1):.4f} deg/m, "
            f"k2 {math.degrees(self.k2):.3f} deg/(m/s)\n"
            f"limits: bank {math.degrees(self.bank_limit):.1f} deg, cross-track {self.cross_track_limit:.0f} m, rate "
            f"{self.cross_track_rate_limit:.1f} m/s; intercept speed {self.intercept_speed:.1f} m/s\n"
            f"inside the limits: {self.frequency:.3f} rad/s, damping {self.damping:.2f}"
        )

    @property
    def frequency(self) -> float:
        """Natural frequency inside the limits, rad/s."""
        return math.sqrt(STANDARD_GRAVITY * self.k1)

    @property
    def damping(self) -> float:
        """Damping ratio inside the limits."""
        return float(STANDARD_GRAVITY * self.k2 / (2.0 * self.frequency))

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
