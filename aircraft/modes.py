"""Natural modes of a linear model, and how MIL-F-8785C would grade them on approach."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from aircraft.linearise import LATERAL, LONGITUDINAL, LinearModel
from aircraft.state import STANDARD_GRAVITY

LEVEL_SOURCE = "MIL-F-8785C, flight phase category C, class II-L and III"


class Mode(NamedTuple):
    """One mode: a complex pair or a real root of the linear model."""

    name: str
    root: complex  # 1/s, of a pair the one with positive frequency

    @property
    def natural_frequency(self) -> float:
        """rad/s."""
        return abs(self.root)

    @property
    def damping(self) -> float:
        """Damping ratio; 1 or -1 for a real root."""
        return -self.root.real / abs(self.root)

    @property
    def time_constant(self) -> float:
        """s until the motion has changed e-fold; negative where it grows."""
        return -1.0 / self.root.real

    @property
    def time_to_double(self) -> float:
        """s; infinite where the motion decays."""
        return math.log(2.0) / self.root.real if self.root.real > 0.0 else math.inf


class Modes(NamedTuple):
    """The five modes of an aeroplane."""

    phugoid: Mode
    short_period: Mode
    dutch_roll: Mode
    roll: Mode
    spiral: Mode


def modes(linear: LinearModel) -> Modes:
    """Modes at constant height and heading: eigenvalues of the two four-state blocks, told apart by their frequency.

    Raises ``ValueError`` where the modes are not the usual ones (two pairs; a pair and two real roots).
    """
    slow, fast = _pairs(linear.part(LONGITUDINAL[:4], ())[0], 2)
    lateral = linear.part(LATERAL[:4], ())[0]
    (dutch_roll,) = _pairs(lateral, 1)
    spiral, roll = sorted((root.real for root in np.linalg.eigvals(lateral) if root.imag == 0.0), key=abs)
    return Modes(
        Mode("phugoid", slow),
        Mode("short period", fast),
        Mode("Dutch roll", dutch_roll),
        Mode("roll", complex(roll)),
        Mode("spiral", complex(spiral)),
    )


def _pairs(block: np.ndarray, wanted: int) -> list[complex]:
    pairs = sorted((complex(root) for root in np.linalg.eigvals(block) if root.imag > 0.0), key=abs)
    if len(pairs) != wanted:
        raise ValueError(f"a block of four states with {len(pairs)} oscillations, where {wanted} are usual")
    return pairs


class Requirement(NamedTuple):
    """A quantity of a mode and its range in each level, 1 the best."""

    mode: str
    quantity: str
    unit: str
    levels: tuple[tuple[float, float], ...]
    source: str = LEVEL_SOURCE


REQUIREMENTS = (
    Requirement("phugoid", "damping", "", ((0.04, math.inf), (0.0, math.inf))),
    Requirement("phugoid", "time_to_double", "s", ((math.inf, math.inf), (math.inf, math.inf), (55.0, math.inf))),
    Requirement("short_period", "damping", "", ((0.35, 1.30), (0.25, 2.0), (0.15, math.inf))),
    Requirement("short_period", "natural_frequency", "rad/s", ((0.7, math.inf), (0.4, math.inf))),
    Requirement("short_period", "control_anticipation", "1/(g s2)", ((0.16, 3.6), (0.096, 10.0))),
    Requirement("dutch_roll", "damping", "", ((0.08, math.inf), (0.02, math.inf), (0.0, math.inf))),
    Requirement("dutch_roll", "damping_rate", "rad/s", ((0.10, math.inf), (0.05, math.inf), (-math.inf, math.inf))),
    Requirement("dutch_roll", "natural_frequency", "rad/s", ((0.4, math.inf),) * 3),
    Requirement("roll", "time_constant", "s", ((0.0, 1.4), (0.0, 3.0), (0.0, 10.0))),
    Requirement(
        "spiral",
        "time_to_double",
        "s",
        ((12.0, math.inf), (8.0, math.inf), (4.0, math.inf)),
        LEVEL_SOURCE + "; the three times from memory",
    ),
)


class Verdict(NamedTuple):
    """What was required, what was found, and the level it reaches (4 = none)."""

    requirement: Requirement
    value: float
    level: int


def flying_qualities(linear: LinearModel) -> tuple[Verdict, ...]:
    """Levels of the bare aircraft [MIL-F-8785C, 3.2.1.2, 3.2.2.1, 3.3.1]; limits not in the text are from memory."""
    found = modes(linear)
    lift = -linear.A[1, 1] * linear.trim.initial.airspeed / STANDARD_GRAVITY  # load factor per rad
    verdicts = []
    for requirement in REQUIREMENTS:
        mode = getattr(found, requirement.mode)
        if requirement.quantity == "control_anticipation":
            value = mode.natural_frequency**2 / lift
        elif requirement.quantity == "damping_rate":
            value = -mode.root.real
        else:
            value = getattr(mode, requirement.quantity)
        met = (level for level, (low, high) in enumerate(requirement.levels, 1) if low <= value <= high)
        verdicts.append(Verdict(requirement, value, next(met, 4)))
    return tuple(verdicts)
