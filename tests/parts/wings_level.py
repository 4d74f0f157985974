"""Wings level: the bank is zero, wherever the aircraft is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Self

from autopilot.mode import DesignCase, LimitedInput


@dataclass(frozen=True)
class WingsLevel:
    """A mode in one file: a frozen dataclass with the members of ``autopilot.mode.Mode``.

    Its fields are the keys of ``[autopilot.law]``; the unit of ``Annotated`` says how a file spells them. The bank
    limit alone stands in ``[autopilot]``, because turns of the route are flown at it.
    """

    bank_limit: Annotated[Any, "rad"]

    intent: ClassVar[str] = "wings-level law"  # what a tracker calls it
    standard: ClassVar[bool] = False  # not a mode that every crew has: it changes no scenario that does not fly it
    intercept: ClassVar[tuple[str, ...]] = ()  # no field sets the course of a far intercept: it never intercepts

    @classmethod
    def designed(cls, given: dict[str, Any], case: DesignCase) -> Self:
        """What the file gives, by field and in SI; all else by the mode's own recipe from the case."""
        return cls(**{**given, "bank_limit": case.bank_limit})

    def __call__(self, deviation: Any) -> Any:
        """Bank, rad: zero in the shape of what is given, floats of the autopilot or arrays of a tracker."""
        return 0.0 * deviation.cross_track

    def limits(self) -> tuple[LimitedInput, ...]:
        """It looks at no deviation, so that a phase portrait has no regions and the history of the bank no bars."""
        return ()

    def explain(self) -> str:
        """The line of ``shortfinal explain``."""
        return f"bank = 0, whatever the deviation; turns are planned at {math.degrees(self.bank_limit):.1f} deg"

    def check_convergence(self, ground_speed: float, offset: float = math.inf, turns: bool = False) -> None:
        """It could refuse routes that it cannot fly; this one means not to reach its leg."""


# what the file brings when it is named as a plug-in; in the folder autopilot/modes its name is enough
SHORTFINAL = {"modes": {"wings_level": WingsLevel}}
