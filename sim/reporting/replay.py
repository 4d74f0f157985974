"""Data of the replay in the page: the flight, the measurements as they arrived, the estimates of draw 0."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.interpolation import truth_at
from sim.flight.record import Flight, runs
from sim.metrics.comparison import plotted
from sim.metrics.signals import height_error
from sim.reporting.figures import style
from sim.reporting.figures.plan_view import RUNWAY_LENGTH
from sim.reporting.text.labels import words
from sim.reporting.tracker_figures.error_curves import Shown
from tracking.height_profile import Charted

LEAD = 10.0  # s, by which the replay opens before two trackers part
MOST_STATES, MOST_ESTIMATES, MOST_PLOTS = 1200, 500, 1000  # of a flight, of each tracker, of each sensor


def replay(
    flight: Flight,
    scenario: Any,
    followed: list[Shown],
    records: dict[str, Any],
    chart: Charted | None = None,
    parted: float | None = None,
) -> dict[str, Any] | None:
    """Plain lists for the script: metres along (x) and to the right of (y) the final course; None for no time at all.

    Heights are above the threshold; ``flown`` is the distance over the ground, the abscissa of the vertical profile.
    Plots of a radar that measures neither elevation nor height are shown where the ``chart`` puts them. It opens a
    little before the instant ``parted``, s, at which two trackers part; without one, with the flight. Of an unknown
    flight there are plots and estimates, and lists without any number are empty.
    """
    if len(flight.time) < 2 or (flight.known and not np.isfinite(flight.state.north).all()):
        return None
    course = flight.route.legs[-1].course
    turn = np.array(((np.cos(course), np.sin(course)), (-np.sin(course), np.cos(course))))
    state = flight.state
    steps = np.hypot(np.diff(state.north), np.diff(state.east))
    flown = np.concatenate(([0.0], np.cumsum(steps)))
    few = np.unique(np.linspace(0, len(flight.time) - 1, MOST_STATES).astype(int))
    x, y = turn @ np.array((state.north, state.east))[:, few]
    corners = turn @ np.array([leg.start for leg in flight.route.legs] + [flight.route.legs[-1].end]).T
    far = turn @ np.array(scenario.runway.to_local(RUNWAY_LENGTH * 1e3, 0.0))
    return {
        "opens": round(float(flight.time[0] if parted is None else max(parted - LEAD, flight.time[0])), 1),
        "flight": {
            "t": _listed(flight.time[few], 3),
            "x": _listed(x),
            "y": _listed(y),
            "flown": _listed(flown[few], 0),
            "height": _listed(state.height[few]),
            "asked": _listed((state.height - height_error(flight, scenario.runway))[few]),
            "bank": _listed(np.degrees(state.bank[few])),
            "pitch": _listed(np.degrees(state.pitch[few])),
            "heading": _listed(np.degrees(np.unwrap(nose(flight)) - course)[few]),
            "speed": _listed(state.airspeed[few]),
        },
        "phases": [
            {
                "from": round(float(flight.time[first]), 2),
                "name": words(flight.phases[int(flight.phase[first])]),
                "colour": style.phase_colour(flight.phases[int(flight.phase[first])]),
            }
            for first, _ in runs(flight.phase)[:MOST_STATES]
        ],
        "route": _listed(corners.T),
        "runway": _listed(np.array(((0.0, 0.0), far))),
        "plots": [
            found
            for name, record in records.items()
            for some in (false_plots(record), record)
            if some is not None and (found := _plots(flight, scenario, name, some, turn, some is not record, chart))
        ],
        "trackers": [_estimates(one, turn) for one in followed],
    }


def nose(flight: Flight) -> np.ndarray:
    """(k,) rad, where the nose points; of a recorded flight, where it goes."""
    return np.asarray(flight.state.course if flight.is_recorded else flight.state.heading)


def false_plots(record: Any) -> Any | None:
    """The false plots of draw 0 as a record of their own; None for a sensor without clutter."""
    if record.candidates is None:
        return None
    plots = record.candidates[:, 1:, :, 0]  # the first is the target's own
    epoch, plot = np.nonzero(np.isfinite(plots).all(axis=-1))
    return record._replace(
        time=record.time[epoch], arrival=record.arrival[epoch], z=plots[epoch, plot][..., None], candidates=None
    )


def _plots(
    flight: Flight,
    scenario: Any,
    name: str,
    record: Any,
    turn: np.ndarray,
    false: bool,
    chart: Charted | None,
) -> dict[str, Any] | None:
    """Measured places and heights of draw 0 when they became known; None for a sensor that measures neither."""
    thin = max(1, -(-len(record.time) // MOST_PLOTS))
    some = record._replace(time=record.time[::thin], arrival=record.arrival[::thin], z=record.z[::thin])
    place = place_of_plots(scenario.sensors[name], some, chart)
    height = height_of_plots(flight, scenario.sensors[name], some)
    if place is None and height is None:
        return None
    nowhere = np.full(len(some.time), np.nan)
    x, y = (nowhere, nowhere) if place is None else turn @ place
    return {
        "name": words(name),
        "false": false,
        "t": _listed(some.arrival, 3),
        "x": _listed(x),
        "y": _listed(y),
        "height": _listed(nowhere if height is None else height),
    }


def place_of_plots(sensor: Any, record: Any, chart: Charted | None) -> np.ndarray | None:
    """(2, k) m north, east of the measurements of draw 0; None for a sensor that measures no place."""
    if not len(record.time):
        return None
    z = dict(zip(record.channels, np.moveaxis(record.z[..., :1], 1, 0), strict=True))
    place = plotted(z, sensor, chart)
    return None if place is None else place[..., 0]


def height_of_plots(flight: Flight, sensor: Any, record: Any) -> np.ndarray | None:
    """(k,) m height of the measurements of draw 0; None for a sensor on the ground that measures none.

    An elevation without a range is taken at the true distance.
    """
    z = dict(zip(record.channels, np.moveaxis(record.z[..., 0], 1, 0), strict=True))
    if not len(record.time):
        return None
    if "range" in z and "height" in z:
        return np.asarray(z["height"])
    if "elevation" not in z:
        return None
    north, east, up = sensor.antenna
    if "range" in z:
        return np.asarray(up + z["range"] * np.sin(z["elevation"]))
    true = truth_at(flight, record.time).position
    return np.asarray(up + np.hypot(true[0] - north, true[1] - east) * np.tan(z["elevation"]))


def _estimates(one: Shown, turn: np.ndarray) -> dict[str, Any]:
    """Places, 2 sigma ellipses (semi-axes, direction of the longer) and heights of one tracker."""
    few = np.unique(np.linspace(0, len(one.curves.path.time) - 1, MOST_ESTIMATES).astype(int))
    x, y = turn @ one.curves.path.place[few].T
    long, short, direction = ellipse(np.einsum("ij,kjl,ml->kim", turn, one.curves.path.spread[few], turn))
    return {
        "name": words(one.name),
        "colour": one.look["colour"],
        "dash": [round(1.5 * dash, 1) for dash in one.look["dashes"]],  # pixels
        "law": one.law_from,
        "t": _listed(one.curves.path.time[few], 3),
        "x": _listed(x),
        "y": _listed(y),
        "long": _listed(2 * long),
        "short": _listed(2 * short),
        "direction": _listed(direction, 3),
        "height": _listed(one.curves.path.height[few]),
        "spread": _listed(2 * one.curves.path.height_sigma[few]),
    }


def ellipse(cov: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(longer, shorter standard deviation, direction of the longer in rad from x to y) of covariances (k, 2, 2)."""
    a, b, c = cov[:, 0, 0], cov[:, 0, 1], cov[:, 1, 1]
    middle, radius = (a + c) / 2, np.hypot((a - c) / 2, b)
    return np.sqrt(middle + radius), np.sqrt(np.maximum(middle - radius, 0.0)), 0.5 * np.arctan2(2 * b, a - c)


def _listed(values: np.ndarray, places: int = 1) -> list[Any]:
    """Rounded numbers for JSON; what is not finite is null. A list without any number is empty."""
    values = np.asarray(values, float)
    finite = np.isfinite(values)
    if finite.all():
        rounded = values.round(places)
        whole: list[Any] = rounded.astype(int).tolist() if places == 0 else rounded.tolist()
        return whole
    if not finite.any():
        return []
    return [round(v, places) if v == v and abs(v) != np.inf else None for v in values.tolist()]
