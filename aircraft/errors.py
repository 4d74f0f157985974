"""What can go wrong with an aircraft; every message is one sentence for the user."""

from __future__ import annotations

import math
from typing import Any

from aircraft.state import AircraftState

LONGEST_MESSAGE = 600  # characters


class ModelError(ValueError):
    """A model that does not exist, is broken, or may not be loaded; the message is one sentence, and can be printed."""

    def __init__(self, message: str) -> None:
        shown = "".join(c if c.isprintable() else repr(c)[1:-1] for c in message[:LONGEST_MESSAGE])
        super().__init__(shown + ("..." if len(message) > LONGEST_MESSAGE else ""))


class TrimError(ValueError):
    """No steady state at the wanted condition; the message says what ran out."""


class FlightError(RuntimeError):
    """A flight that cannot go on; carries the time (s) and the last state that was finite."""

    def __init__(self, message: str, time: float = math.nan, state: AircraftState | None = None) -> None:
        super().__init__(message)
        self.time = time
        self.state = state

    def __reduce__(self) -> tuple[Any, ...]:
        return FlightError, (str(self), self.time, self.state)
