"""write_asterix(): the plots and tracks of a run as ASTERIX, a file for each sensor and each tracker."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from aircraft.runway import Runway as Place
from sim.errors import OutputError
from sim.estimation.tracking_run import Tracked, joined
from sim.interchange.asterix.blocks import Blocks, merged
from sim.interchange.asterix.pcap import capture_of
from sim.interchange.asterix.writing import (
    MOST_DRAWS,
    Estimate,
    north_markers,
    position_reports,
    system_tracks,
    target_reports,
)
from sim.metrics.comparison import on_the_plane
from sim.observation.as_recorded import as_seen, records_traffic
from sim.observation.record import SensorRecord
from sim.results.result import Result
from sim.scenario.tables import Runway

FARTHEST, FASTEST = 1e6, 4e3  # m, m/s: an estimate beyond is one of a track that is lost
CONTAINED = math.sqrt(-2.0 * math.log(0.05))  # standard deviations in each direction of a circle that holds 95 %

# NACp and NACv by the bound of the 95 % error of position, m, and of horizontal velocity, m/s [RTCA DO-260B, from
# memory]
POSITION_CATEGORIES = ((3.0, 11), (10.0, 10), (30.0, 9), (92.6, 8), (185.2, 7), (555.6, 6), (926.0, 5), (1852.0, 4))
VELOCITY_CATEGORIES = ((0.3, 4), (1.0, 3), (3.0, 2), (10.0, 1))


class Messages(NamedTuple):
    """What becomes one file."""

    name: str  # without its ending
    of: str  # what the file holds, in words
    blocks: Blocks


def write_asterix(
    result: Result, place: Path, *, begins: float, draw: int | None = None, capture: bool = False
) -> tuple[list[str], list[str]]:
    """Write the plots of the sensors and the tracks of the trackers of a result into an existing folder.

    Gives a sentence for each file, which begins with its name, and one for each sensor, tracker or estimate that is
    left out. A radar is CAT048 with CAT034, a receiver of ADS-B CAT021, a tracker CAT062. Sensors and trackers are told
    apart by SIC, in the order of the scenario, from 1 on.

    Parameters
    ----------
    begins : s since 1970 when the flight begins; a flight with a date has its own
    draw : the only one that leaves; None = all, each with its number as track number
    capture : write captures of UDP datagrams (pcap) instead of data blocks as they stand

    Raises ``OutputError`` in one sentence where nothing can leave.
    """
    scenario = result.scenario
    draws = scenario.draws
    if draw is not None and not 0 <= draw < draws:
        raise OutputError(f"--draw {draw}: the run has the draws 0 to {draws - 1}")
    if draw is None and draws > MOST_DRAWS:
        raise OutputError(f"{draws} draws are more than the {MOST_DRAWS} that one file tells apart; say --draw K")
    chosen = np.arange(draws) if draw is None else np.array([draw])
    begins = begins if result.flight.utc is None else result.flight.utc
    files: list[str] = []
    left: list[str] = []
    ending = "pcap" if capture else "ast"
    for one in _messages(result, begins, chosen, left.append):
        name = f"{one.name}.{ending}"
        with (place / name).open("wb") as file:
            if capture:
                file.writelines(capture_of(one.blocks))
            else:
                file.write(one.blocks.octets.tobytes())
        files.append(f"{name}: {one.of}")
    if not files:
        raise OutputError(f"nothing can leave as ASTERIX: {left[0] if left else 'there are no sensors'}")
    return files, left


def _messages(result: Result, begins: float, draws: np.ndarray, left: Callable[[str], None]) -> Iterator[Messages]:
    """The files one after another; ``left`` is told what cannot leave."""
    scenario = result.scenario
    for sic, (name, record) in enumerate(result.records.items(), 1):
        sensor = scenario.sensors[name]
        if {"range", "azimuth"} <= {*record.channels}:
            of, blocks = _of_radar(result, sic, sensor, record, begins, draws)
        elif records_traffic(sensor):
            of, blocks = _of_receiver(result, sic, record, begins, draws)
        else:
            left(f"sensor '{name}' measures {', '.join(record.channels)}, which no category here has")
            continue
        yield Messages(f"measurements.{name}", of, blocks)
    for sic, (name, one) in enumerate(result.tracks.items(), 1 + len(result.records)):
        sensors = {key: scenario.sensors[key] for key in result.records}
        estimate = _of_tracker(result, one, sensors, begins, draws)
        if estimate is None:
            left(f"tracker '{name}' estimates no place on the ground plane")
            continue
        lost = int(np.sum(~_sound(estimate)))
        if lost:
            left(f"tracker '{name}': {lost} of its {len(estimate.stamps)} estimates are lost, and of no place on earth")
        estimate = Estimate(*(column[..., _sound(estimate)] for column in estimate))
        yield Messages(f"tracks.{name}", f"{len(estimate.stamps)} estimates", system_tracks(sic, estimate))


def _place(runway: Runway) -> Place:
    return Place(runway.latitude, runway.longitude, runway.elevation, runway.heading)


def _of_radar(
    result: Result, sic: int, sensor: Any, record: SensorRecord, begins: float, draws: np.ndarray
) -> tuple[str, Blocks]:
    """CAT048 and CAT034 of a radar. An elevation makes a height above the sea; a height is a transponder's answer."""
    runway = result.scenario.runway
    plots = record.z[:, None] if record.candidates is None else record.candidates
    plots = plots[..., draws]  # (k, c, m, draws)
    row = {channel: plots[:, :, number] for number, channel in enumerate(record.channels)}
    epoch, plot, number = np.nonzero(np.isfinite(row["range"] + row["azimuth"]))
    values = {channel: column[epoch, plot, number] for channel, column in row.items()}
    north, east, up = sensor.antenna
    latitude, longitude = _place(runway).geodetic(north, east, up)
    # meridians meet: north at the antenna is not quite that of the threshold
    zero = sensor.zero_azimuth + (longitude - runway.longitude) * math.sin(runway.latitude)
    columns = {"range": values["range"], "azimuth": values["azimuth"] + zero}
    if "elevation" in values:
        columns["height"] = runway.elevation + up + values["range"] * np.sin(values["elevation"])
    elif "height" in values:
        columns["level"] = values["height"] + result.scenario.air.pressure_altitude(0.0)
    stamps = begins + record.time[epoch]
    cooperative = "elevation" not in values and record.candidates is None
    reports = target_reports(
        sic,
        stamps,
        draws[number],
        columns,
        sent=begins + record.arrival[epoch],
        cooperative=cooperative,
        numbered=len(draws) > 1,
    )
    first = np.flatnonzero(np.diff(epoch, prepend=-1))
    share = 0.0 if "elevation" in values else np.mod(columns["azimuth"][first], 2.0 * math.pi) / (2.0 * math.pi)
    antenna = (float(latitude), float(longitude), runway.elevation + up)
    markers = north_markers(sic, stamps[first] - sensor.period * share, sensor.period, antenna)
    return f"{len(stamps)} plots", merged([markers, reports])


def _of_receiver(
    result: Result, sic: int, record: SensorRecord, begins: float, draws: np.ndarray
) -> tuple[str, Blocks]:
    """CAT021 of a receiver of ADS-B."""
    scenario = result.scenario
    seen = [as_seen("", record, scenario.runway, scenario.air, begins, draw) for draw in draws.tolist()]
    R = record.R if record.R.ndim == 4 else np.repeat(record.R[..., None], record.z.shape[2], axis=3)
    index = {channel: number for number, channel in enumerate(record.channels)}
    rows = [np.isin(begins + record.time, one.time) for one in seen]
    variances = np.concatenate([R[row][:, :, :, draw] for row, draw in zip(rows, draws.tolist(), strict=True)])
    place = 0.5 * (variances[:, index["north"], index["north"]] + variances[:, index["east"], index["east"]])
    columns = {
        "latitude": np.concatenate([one.latitude for one in seen]),
        "longitude": np.concatenate([one.longitude for one in seen]),
        "position_category": _category(CONTAINED * np.sqrt(place), POSITION_CATEGORIES),
        "velocity_category": np.zeros(len(place)),
    }
    for name, own in (
        ("level", "pressure_altitude"),
        *((one, one) for one in ("ground_speed", "course", "vertical_rate")),
    ):
        columns[name] = np.concatenate([getattr(one, own) for one in seen])
    if "ground_speed" in index:
        speed = variances[:, index["ground_speed"], index["ground_speed"]]
        columns["velocity_category"] = _category(CONTAINED * np.sqrt(speed), VELOCITY_CATEGORIES)
    stamps = np.concatenate([one.time for one in seen])
    draw = np.concatenate([np.full(len(one.time), own) for one, own in zip(seen, draws.tolist(), strict=True)])
    order = np.lexsort((draw, stamps))
    columns = {name: column[order] for name, column in columns.items()}
    reports = position_reports(sic, stamps[order], draw[order], columns, numbered=len(draws) > 1)
    return f"{len(stamps)} reports", reports


def _category(error: np.ndarray, bounds: tuple[tuple[float, int], ...]) -> np.ndarray:
    """The category of each error; 0 beyond all bounds."""
    found = np.zeros(len(error))
    for bound, category in reversed(bounds):
        found[error < bound] = category
    return found


def _of_tracker(
    result: Result, one: Tracked, sensors: dict[str, Any], begins: float, draws: np.ndarray
) -> Estimate | None:
    """CAT062 of a tracker, in the plane that touches the earth at the threshold.

    A track on this plane says no height. Which latitude and longitude a place on it has depends on the height, and
    that is the aircraft's own.
    """
    track = one.track if one.rollout is None else joined(one.track, one.rollout)
    cov = track.cov if track.cov.ndim == 4 else track.cov[..., None]
    plane = on_the_plane(track.channels, track.mean, cov, sensors)
    if plane is None:
        return None
    count, _, runs = track.mean.shape
    place, spread = (
        plane[0][:, ::-1][..., draws],
        np.broadcast_to(plane[1], (count, 2, 2, runs))[:, ::-1, ::-1][..., draws],
    )
    rates = [track.channels.index(name) for name in ("east_rate", "north_rate") if name in track.channels]
    velocity, sigma = (
        np.full((2, *place.shape[:1], len(draws)), np.nan),
        np.full((2, *place.shape[:1], len(draws)), np.nan),
    )
    if len(rates) == 2:
        velocity = np.moveaxis(track.mean[:, rates], 1, 0)[..., draws]
        with np.errstate(invalid="ignore"):
            own = np.sqrt(np.stack([cov[:, row, row] for row in rates]))
        sigma = np.broadcast_to(own, (2, count, runs))[..., draws]
    state = result.flight.whole.state
    height = np.interp(track.time, state.time, state.height) if result.flight.known else np.zeros(count)
    with np.errstate(all="ignore"):  # an estimate that is lost may be anywhere
        latitude, longitude = _place(result.scenario.runway).geodetic(place[:, 1], place[:, 0], height[:, None])
    epoch, number = (grid.ravel() for grid in np.indices((count, len(draws))))
    return Estimate(
        begins + track.time[epoch],
        draws[number],
        latitude.ravel(),
        longitude.ravel(),
        np.moveaxis(place, 1, 0).reshape(2, -1),
        velocity.reshape(2, -1),
        np.moveaxis(spread, 0, 2).reshape(2, 2, -1),
        sigma.reshape(2, -1),
        epoch == 0,
        epoch == count - 1,
    )


def _sound(estimate: Estimate) -> np.ndarray:
    """(n,) whether an estimate is of a place on earth, and its covariance one."""
    x, y = estimate.position
    variance = estimate.position_cov[0, 0] + estimate.position_cov[1, 1] + estimate.position_cov[0, 1]
    with np.errstate(invalid="ignore"):
        slow = np.isnan(estimate.velocity).all(axis=0) | (np.abs(estimate.velocity) < FASTEST).all(axis=0)
        near = np.hypot(x, y) < FARTHEST
    return np.asarray(near & slow & np.isfinite(variance) & np.isfinite(estimate.latitude + estimate.longitude))
