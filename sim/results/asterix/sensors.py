"""Looks of sensors as messages of ASTERIX: a radar is CAT048 with CAT034, a receiver of ADS-B CAT021."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aircraft.runway import Runway as Place
from sim.interchange.asterix.blocks import Blocks, merged
from sim.interchange.asterix.writing import north_markers, position_reports, target_reports
from sim.observation.as_recorded import as_seen, records_traffic
from sim.observation.record import SensorRecord
from sim.scenario.model import Scenario

CONTAINED = math.sqrt(-2.0 * math.log(0.05))  # standard deviations in each direction of a circle that holds 95 %

# NACp and NACv by the bound of the 95 % error of position, m, and of horizontal velocity, m/s [RTCA DO-260B, from
# memory]
POSITION = ((3.0, 11), (10.0, 10), (30.0, 9), (92.6, 8), (185.2, 7), (555.6, 6), (926.0, 5), (1852.0, 4))
VELOCITY = ((0.3, 4), (1.0, 3), (3.0, 2), (10.0, 1))
MOTION = ("ground_speed", "course", "vertical_rate")


def messages_of(
    scenario: Scenario, sic: int, name: str, record: SensorRecord, begins: float, draws: np.ndarray
) -> Blocks | None:
    """What a sensor sends of some draws of its record; None = it measures nothing that a category here holds.

    ``begins`` is the time 0 of the record, s since 1970.
    """
    sensor = scenario.sensors[name]
    if {"range", "azimuth"} <= {*record.channels}:
        return _of_radar(scenario, sic, sensor, record, begins, draws)
    if records_traffic(sensor):
        return _of_receiver(scenario, sic, record, begins, draws)
    return None


def _of_radar(
    scenario: Scenario, sic: int, sensor: Any, record: SensorRecord, begins: float, draws: np.ndarray
) -> Blocks:
    """Plots, and for each look with one a message that a turn begins.

    An elevation becomes a height above the sea. A height is what a transponder answers, so the pressure altitude of the
    threshold is added that the radar took off. A radar that measures an elevation, or does not know its target, is a
    primary one: nothing in its plots says whose they are, but the track number where there are several draws.
    """
    runway = scenario.runway
    plots = (record.z[:, None] if record.candidates is None else record.candidates)[..., draws]  # (k, c, m, draws)
    row = {channel: plots[:, :, number] for number, channel in enumerate(record.channels)}
    epoch, plot, draw = np.nonzero(np.isfinite(row["range"] + row["azimuth"]))
    values = {channel: column[epoch, plot, draw] for channel, column in row.items()}
    north, east, up = sensor.antenna
    latitude, longitude = Place(runway.latitude, runway.longitude, runway.elevation).geodetic(north, east, up)
    # meridians meet at the pole: north at the antenna is not quite that of the threshold
    zero = sensor.zero_azimuth + (longitude - runway.longitude) * math.sin(runway.latitude)
    columns = {"range": values["range"], "azimuth": values["azimuth"] + zero}
    if "elevation" in values:
        columns["height"] = runway.elevation + up + values["range"] * np.sin(values["elevation"])
    elif "height" in values:
        columns["level"] = values["height"] + scenario.air.pressure_altitude(0.0)
    stamps = begins + record.time[epoch]
    reports = target_reports(
        sic,
        stamps,
        draws[draw],
        columns,
        sent=begins + record.arrival[epoch],
        cooperative="elevation" not in values and record.candidates is None,
        numbered=len(draws) > 1,
    )
    first = np.flatnonzero(np.diff(epoch, prepend=-1))  # plot of each look
    turned = np.mod(columns["azimuth"][first] / (2.0 * math.pi), 1.0) if "elevation" not in values else 0.0
    antenna = (float(latitude), float(longitude), runway.elevation + up)
    return merged([north_markers(sic, stamps[first] - sensor.period * turned, sensor.period, antenna), reports])


def _of_receiver(scenario: Scenario, sic: int, record: SensorRecord, begins: float, draws: np.ndarray) -> Blocks:
    """Reports with the accuracy that the record states, as categories."""
    seen = [as_seen("", record, scenario.runway, scenario.air, begins, draw) for draw in draws.tolist()]
    parts: dict[str, list[Any]] = {"latitude": [], "longitude": [], "level": []}
    parts |= {name: [] for name in (*MOTION, "position_category", "velocity_category")}
    spread = np.einsum("kii...->ki...", record.R)
    spread = spread if spread.ndim == 3 else spread[..., None]
    variances = np.broadcast_to(spread, record.z.shape)
    for one, draw in zip(seen, draws.tolist(), strict=True):
        kept = np.isin(begins + record.time, one.time)
        own = dict(zip(record.channels, variances[kept, :, draw].T, strict=True))
        parts["latitude"].append(one.latitude)
        parts["longitude"].append(one.longitude)
        parts["level"].append(one.pressure_altitude)
        for name in MOTION:
            parts[name].append(getattr(one, name))
        error = CONTAINED * np.sqrt(0.5 * (own["north"] + own["east"]))
        parts["position_category"].append(_category(error, POSITION))
        speed = CONTAINED * np.sqrt(own.get("ground_speed", np.full(len(error), np.inf)))
        parts["velocity_category"].append(_category(speed, VELOCITY))
    stamps = np.concatenate([one.time for one in seen])
    draw_of = np.repeat(draws, [len(one.time) for one in seen])
    order = np.lexsort((draw_of, stamps))
    columns = {name: np.concatenate(some)[order] for name, some in parts.items()}
    return position_reports(sic, stamps[order], draw_of[order], columns, numbered=len(draws) > 1)


def _category(error: np.ndarray, bounds: tuple[tuple[float, int], ...]) -> np.ndarray:
    """The category of each error; 0 beyond all bounds."""
    found = np.zeros(len(error))
    for bound, category in reversed(bounds):
        found[error < bound] = category
    return found
