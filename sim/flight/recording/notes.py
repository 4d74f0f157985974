"""What of a recorded flight does not fit its runway, or the pressure of the day."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from aircraft.air import QNH, Air
from sim.flight.recording.phases import ESTABLISHED, GROUND
from sim.flight.recording.smoothing import Path
from sim.scenario.tables import Runway

OFF_PATH = 30.0  # m, that a flight on the line may be off the glide path in the middle before it is worth a word
STEADY = math.radians(1.0)  # within which a slope is that of the glide path
PER_PASCAL = 0.0843  # m of height for a pascal of pressure at sea level


def notes(path: Path, phase: np.ndarray, runway: Runway, air: Air) -> Iterator[str]:
    """What does not fit, in sentences."""
    established = (phase >= ESTABLISHED) & (phase < GROUND)
    if not (phase >= ESTABLISHED).any():
        yield "it is never established on the line of the runway: is it this runway, and its course right?"
        return
    slope = np.arctan2(path.velocity[2], np.hypot(path.velocity[0], path.velocity[1]))
    descending = established & (np.abs(slope + runway.glide_path) < STEADY)
    if not descending.any():
        return
    past, _ = runway.from_local(path.position[0], path.position[1])
    off = float(np.median((path.position[2] - (runway.aiming_point - past) * math.tan(runway.glide_path))[descending]))
    if abs(off) <= OFF_PATH:
        return
    fitting = air.qnh - off / PER_PASCAL
    hint = f", which a QNH of {fitting / 100.0:.0f} hPa would mend" if QNH.fault(fitting) is None else ""
    yield (
        f"it descends along the glide path, but {abs(off):.0f} m {'above' if off > 0.0 else 'below'} it: heights are "
        f"by a QNH of {air.qnh / 100.0:.0f} hPa and an elevation of {runway.elevation:.0f} m{hint}"
    )
