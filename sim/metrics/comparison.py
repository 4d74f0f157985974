"""Comparison channels: truth and any estimate brought to position, cross-track, height or a sensor's own angles."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.flight.interpolation import Truth
from sim.flight.record import Flight
from sim.observation.sensor import QUANTITIES, quantity_of
from tracking.height_profile import Charted
from tracking.measurement import wrap


class Compared(NamedTuple):
    """One channel of one tracker, or of the raw measurements, against the truth."""

    error: np.ndarray  # (k, d, draws)
    cov: Any  # (k, d, d, draws or 1); None for raw measurements


def compare(
    flight: Flight,
    truth: Truth,
    components: tuple[str, ...],
    mean: np.ndarray,
    cov: np.ndarray,
    sensors: dict[str, Any],
) -> dict[str, Compared]:
    """Errors of estimates (k, n, draws) in every comparison channel that their components allow.

    ``sensors`` are those whose angles an estimate of the position is projected onto.
    """
    found: dict[str, Compared] = {}
    plane = on_the_plane(components, mean, cov, sensors)
    if plane is not None:
        error = plane[0] - truth.position[:2].T[:, :, None]
        found["position_m"] = Compared(error, plane[1])
        found["cross_track_m"] = _across(flight, truth, error, plane[1])
    for name, sensor in sensors.items():
        for quantity in sensor.channels:
            component = f"{name}.{quantity}"
            factor = quantity_of(quantity).factor
            if component in components:
                row = components.index(component)
                error = _off(quantity, mean[:, [row]], _exact(sensor, truth, quantity)[:, None, None])
                found[with_unit(component)] = Compared(factor * error, factor**2 * cov[:, [row]][:, :, [row]])
            elif quantity == "azimuth" and plane is not None:
                found[with_unit(component)] = _azimuth(sensor, truth, plane[0], plane[1], factor)
    if "height" in components:
        row = components.index("height")
        found["height_m"] = Compared(mean[:, [row]] - truth.position[2][:, None, None], cov[:, [row]][:, :, [row]])
    return found


def with_unit(channel: str) -> str:
    """The name of a comparison channel: that of the component with the suffix of its unit."""
    unit = quantity_of(channel).unit
    return f"{channel}_{unit}" if unit else channel


def says_place(channel: str) -> bool:
    """Whether a comparison channel depends on where the aircraft is."""
    sensor, _, own = channel.rpartition(".")
    return not sensor or own in {with_unit(name) for name, quantity in QUANTITIES.items() if quantity.place}


def _exact(sensor: Any, truth: Truth, quantity: str) -> np.ndarray:
    """(k,) a channel without error."""
    return np.asarray(sensor.truth(truth.state)[sensor.channels.index(quantity)])


def _off(quantity: str, value: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Value minus truth; angles wrapped to the shorter way round."""
    return np.asarray(wrap(value - exact) if quantity_of(quantity).wraps else value - exact)


def on_the_plane(
    components: tuple[str, ...], mean: np.ndarray, cov: np.ndarray, sensors: dict[str, Any]
) -> tuple[np.ndarray, np.ndarray] | None:
    """North and east (k, 2, draws) with covariance, from a cartesian state or the range and angles of one radar."""
    if "north" in components and "east" in components:
        rows = [components.index("north"), components.index("east")]
        return mean[:, rows], cov[:, rows][:, :, rows]
    for name, sensor in sensors.items():
        wanted = [f"{name}.{quantity}" for quantity in ("range", "azimuth", "elevation")]
        if all(component in components for component in wanted):
            rows = [components.index(component) for component in wanted]
            slant, azimuth, elevation = (mean[:, row] for row in rows)
            bearing = azimuth + sensor.zero_azimuth
            north, east, _ = sensor.antenna
            ground, up = slant * np.cos(elevation), slant * np.sin(elevation)
            c, s = np.cos(bearing), np.sin(bearing)
            place = np.stack((north + ground * c, east + ground * s), axis=1)
            # d (north, east) / d (range, azimuth, elevation)
            J = np.stack((np.cos(elevation) * c, -ground * s, -up * c, np.cos(elevation) * s, ground * c, -up * s), 1)
            J = J.reshape(len(mean), 2, 3, -1)
            return place, np.einsum("kijn,kjln,kmln->kimn", J, cov[:, rows][:, :, rows], J)
    return None


def _across(flight: Flight, truth: Truth, error: np.ndarray, cov: Any) -> Compared:
    """The part of position errors across the leg active in truth, + right."""
    course = np.array([leg.course for leg in flight.route.legs])[truth.leg]
    right = np.stack((-np.sin(course), np.cos(course)), axis=1)  # (k, 2)
    across = np.einsum("ki,kin->kn", right, error)[:, None]
    spread = None if cov is None else np.einsum("ki,kijn,kj->kn", right, cov, right)[:, None, None]
    return Compared(across, spread)


def _azimuth(sensor: Any, truth: Truth, place: np.ndarray, cov: np.ndarray, factor: float) -> Compared:
    north, east = (place[:, i] - sensor.antenna[i] for i in (0, 1))
    exact = _exact(sensor, truth, "azimuth")
    error = wrap(np.arctan2(east, north) - sensor.zero_azimuth - exact[:, None])
    square = north**2 + east**2
    slope = np.stack((-east / square, north / square), axis=1)
    spread = np.einsum("kin,kijn,kjn->kn", slope, np.broadcast_to(cov, (*cov.shape[:3], slope.shape[2])), slope)
    return Compared(factor * error[:, None], factor**2 * spread[:, None, None])


def raw(
    flight: Flight, truth: Truth, names: tuple[str, ...], z: np.ndarray, sensors: dict[str, Any], chart: Charted | None
) -> dict[str, Compared]:
    """Errors of the measurements themselves (k, m, draws) in the same channels; NaN where nothing was measured.

    A slant range without an elevation or a height is brought to the ground at the chart's height; without a chart, not.
    """
    found: dict[str, Compared] = {}
    k, _, draws = z.shape
    plots = np.full((k, 2, draws), np.nan)
    for name, sensor in sensors.items():
        rows = {c: names.index(f"{name}.{c}") for c in sensor.channels if f"{name}.{c}" in names}
        place = plotted({quantity: z[:, row] for quantity, row in rows.items()}, sensor, chart)
        if place is not None:
            plots = np.where(np.isnan(plots), np.moveaxis(place, 0, 1), plots)
        for quantity, row in rows.items():
            error = _off(quantity, z[:, row], _exact(sensor, truth, quantity)[:, None])
            found[with_unit(f"{name}.{quantity}")] = Compared(quantity_of(quantity).factor * error[:, None], None)
    if np.isfinite(plots).any():
        error = plots - truth.position[:2].T[:, :, None]
        found["position_m"] = Compared(error, None)
        found["cross_track_m"] = _across(flight, truth, error, None)
    return found


def plotted(z: dict[str, np.ndarray], sensor: Any, chart: Charted | None) -> np.ndarray | None:
    """(2, k, draws) m, north and east of measurements (k, draws) by quantity; None where they are no place."""
    if "north" in z and "east" in z:
        return np.stack((z["north"], z["east"]))
    if "range" not in z or "azimuth" not in z:
        return None
    slant, bearing = z["range"], z["azimuth"] + sensor.zero_azimuth
    north, east, up = sensor.antenna
    if "elevation" in z:
        ground = slant * np.cos(z["elevation"])
    elif "height" in z:
        ground = _on_the_ground(slant, z["height"] - up)
    elif chart is not None:
        ground = _on_the_ground(slant, _charted(chart, (north, east), slant, bearing) - up)
    else:
        return None
    return np.stack((north + ground * np.cos(bearing), east + ground * np.sin(bearing)))


def _on_the_ground(slant: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Horizontal distance at a height above the antenna; over it, 0."""
    return np.asarray(np.sqrt(np.maximum(slant**2 - height**2, 0.0)))


def _charted(chart: Charted, antenna: tuple[float, float], slant: np.ndarray, bearing: np.ndarray) -> np.ndarray:
    """Heights (k, draws) that the chart gives where plots are, seen at a slant range; the course is that between plots.

    A range that is some hundred metres too long for the ground moves the place so little that once is enough.
    """
    place = np.stack((antenna[0] + slant * np.cos(bearing), antenna[1] + slant * np.sin(bearing)))
    seen = np.isfinite(slant).any(axis=1)
    rates = np.zeros_like(place)
    if seen.sum() > 1:
        rates[:, seen] = np.nan_to_num(np.gradient(place[:, seen], axis=1))
    return np.asarray(chart.at(*place, *rates).height)


def squared(compared: Compared) -> np.ndarray:
    """Squared length of the errors (k, draws)."""
    return np.asarray(np.einsum("kdn,kdn->kn", compared.error, compared.error))


def normalised(compared: Compared) -> np.ndarray:
    """Normalised error squared e' P^-1 e (k, draws)."""
    cov = compared.cov
    if cov.shape[1] == 1:
        return np.asarray(compared.error[:, 0] ** 2 / cov[:, 0, 0])
    a, b, c = cov[:, 0, 0], cov[:, 0, 1], cov[:, 1, 1]
    x, y = compared.error[:, 0], compared.error[:, 1]
    return np.asarray((c * x * x - 2 * b * x * y + a * y * y) / (a * c - b * b))
