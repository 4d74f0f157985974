"""What the sensors measured, against the truth: a panel for each channel, whether or not a tracker uses it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.flight.interpolation import truth_at
from sim.flight.record import Flight
from sim.metrics.comparison import raw
from sim.observation.sensor import quantity_of
from sim.reporting.drawing.figure import Drawing
from sim.reporting.figures import style
from sim.reporting.figures.histories import TIME
from sim.reporting.figures.style import Chart
from sim.reporting.figures.thinning import peaks
from sim.reporting.text.labels import unit, words

COLUMNS = 3
MOST_PANELS = 12
MOST_POINTS = 120  # stretches of a panel whose least and greatest value are drawn


def measurement_charts(flight: Flight, sensors: Mapping[str, Any], records: Mapping[str, Any]) -> list[Chart]:
    """The chart of all channels that measured something; none where there is nothing to show."""
    seen = [(name, row) for name, record in records.items() for row in _seen(record)]
    if not seen:
        return []
    left_out = f" {len(seen) - MOST_PANELS} more channels are not shown." if len(seen) > MOST_PANELS else ""
    with np.errstate(invalid="ignore"):
        figure = measurement_errors(flight, sensors, records, seen[:MOST_PANELS])
    caption = (
        "Measured minus true, draw 0, of every channel of every sensor. The lines are two of the standard deviations "
        f"that the sensor states.{left_out}"
    )
    return [Chart("What the sensors measured", figure, caption)]


def _seen(record: Any) -> list[int]:
    """Rows of the channels that measured something."""
    return np.flatnonzero(np.isfinite(record.z[..., 0]).any(axis=0)).tolist() if len(record.time) else []


def measurement_errors(
    flight: Flight, sensors: Mapping[str, Any], records: Mapping[str, Any], shown: list[tuple[str, int]]
) -> Drawing:
    """Figure of the errors of ``shown`` channels, (sensor, row of its z), over time."""
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)
    figure, grid = style.grid(rows, columns, 0.8, own_scales=True)
    for axes, (name, row) in zip(grid, shown, strict=False):
        record, channel = records[name], records[name].channels[row]
        quantity = quantity_of(channel)
        names = tuple(f"{name}.{one}" for one in record.channels)
        errors = raw(flight, truth_at(flight, record.time), names, record.z[..., :1], {name: sensors[name]}, None)
        suffix = f"_{quantity.unit}" if quantity.unit else ""
        error = errors[f"{name}.{channel}{suffix}"].error[:, 0, 0]
        sigma = quantity.factor * np.sqrt(record.R[:, row, row] if record.R.ndim == 3 else record.R[:, row, row, 0])
        few = peaks(error, MOST_POINTS)
        axes.line(record.time[few], error[few], colour=style.BLUE, width=0.4)
        few = peaks(sigma, MOST_POINTS // 4)
        for side in (-2.0, 2.0):
            axes.line(record.time[few], side * sigma[few], colour=style.BLACK, width=0.6)
        axes.title = ", ".join(filter(None, (f"{words(name)}: {words(channel)}", unit(quantity.unit))))
        axes.title_size = 7.0
        axes.x.limits = float(flight.time[0]), float(flight.time[-1]) + 1e-6
    style.end_columns(figure, len(shown), columns)
    grid[0].x.label = TIME
    return figure
