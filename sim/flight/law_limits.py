"""Where the limits of a law act on a flight: its bank command, and each of the deviations that it looks at."""

from __future__ import annotations

import numpy as np

from autopilot.mode import Mode
from sim.flight.record import Flight

BANK = "bank"  # the name of the limit of the command among those of the inputs


def acting_limits(flight: Flight, law: Mode, bank_limit: float) -> dict[str, np.ndarray]:
    """(k,) bool by name: where the command is at its limit (`BANK`), and where each limited input is beyond its own.

    Inputs are named as the fields of ``PathDeviation`` that they are; inputs without a limit are left out.
    ``bank_limit`` is that of the command, rad.
    """
    deviation = flight.deviation
    acting = {BANK: np.abs(flight.command.bank) >= bank_limit * (1 - 1e-6)}
    for one in law.limits():
        if np.isfinite(one.limit):
            seen = deviation.distance_to_go > one.blind
            acting[one.of] = seen & (np.abs(getattr(deviation, one.of)) >= one.limit)
    return acting
