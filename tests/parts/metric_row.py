"""A metric is one row: how much of the final approach was flown with the wings level, in seconds.

In the house the row stands in `METRICS` of `sim/metrics/table.py` and its function in `sim/metrics/figures.py`.
"""

import numpy as np

from sim.flight.record import RECORD_STEP, Flight
from sim.metrics.figures import Context
from sim.metrics.table import Metric


def wings_level(flight: Flight, context: Context) -> float | None:
    """Time on the glide path with less than a degree of bank, s; None where no glide path was flown."""
    glide = flight.during("glide")
    level = glide & (np.abs(flight.state.bank) < np.radians(1.0))
    return float(level.sum() * RECORD_STEP) if glide.any() else None


ROW = Metric("wings_level_s", "s", "wings level on the glide path", wings_level, digits=1)
