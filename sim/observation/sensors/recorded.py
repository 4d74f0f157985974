"""Recorded plots, from a file: range and azimuth, or latitude and longitude, and a height where it has one."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from aircraft.air import STANDARD_PRESSURE, Air
from aircraft.ranges import ABOVE_ZERO, check_ranges
from aircraft.runway import Runway as Place
from aircraft.state import AircraftState
from sim.files import read_bytes
from sim.flight.recording.places import HIGHEST, LOWEST, STEP
from sim.interchange.asterix import plots as asterix_plots
from sim.interchange.asterix.reading import is_asterix
from sim.interchange.plots import Plots, read_parquet_plots, read_plots
from sim.interchange.tables import PARQUET
from sim.observation.antenna import location, no_outline, place, polar
from sim.observation.sensor import Look, Recording
from sim.randomness import Streams
from sim.scenario.tables import Runway
from tracking.measurement import wrap

EXAMPLE = Path(__file__).with_suffix(".csv")  # made up: a radar 2 km right of the threshold sees a final approach
SIGMAS = ("range", "azimuth", "height", "position")


class Waiting(NamedTuple):
    """Where in its file the sensor is."""

    row: int  # of the next plot
    draws: int


@dataclass(frozen=True)
class Recorded:
    """Plots as they were recorded, the same in every draw; ``sim.interchange.plots`` says which columns it knows, and
    ``sim.interchange.asterix.plots`` which items of ASTERIX.

    Azimuths count from true north at the antenna, unless ``azimuth_zero`` says what course, from true north, its zero
    has. A pressure altitude becomes a height by the QNH and the temperature of the scenario. How accurate the plots
    are is stated, here or by columns of the file: nothing is taken for granted.

    The earth is taken for the plane that touches it at the threshold, which lies d^2 / 2 earth radii above the ground
    at a distance d. At 60 km that is 282 m, and an aircraft at 2000 m comes out 9 m too near.
    """

    file: str
    sha256: str | None = None  # of the file; absent = as it is found now
    target: str | None = None  # whose plots, where the file has several aircraft
    source: str | None = None  # "SAC/SIC" of the radar whose plots, where a file of ASTERIX has several
    position: Annotated[tuple[float, float, float] | None, "m"] = None  # antenna: past the threshold, right, up
    azimuth_zero: Annotated[float, "rad"] = 0.0
    range_sigma: Annotated[float | None, "m", ABOVE_ZERO] = None  # absent = the file has a column of it; so the others
    azimuth_sigma: Annotated[float | None, "rad", ABOVE_ZERO] = None
    height_sigma: Annotated[float | None, "m", ABOVE_ZERO] = None
    position_sigma: Annotated[float | None, "m", ABOVE_ZERO] = None  # of latitude and longitude, north and east alike
    utc: Annotated[float | None, "given"] = None  # s since 1970 at the flight's time 0; None = at no date
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)
    air: Annotated[Air, "given"] = field(default_factory=Air)

    gives_place: ClassVar[bool] = True
    clutter: ClassVar[float] = 0.0  # its plots are of one aircraft
    outline = no_outline  # it saw what it saw
    example: ClassVar[dict[str, Any]] = {
        "file": str(EXAMPLE), "position_m": [0.0, 2000.0, 10.0], "range_sigma_m": 60.0, "azimuth_sigma_deg": 0.15,
    }  # fmt: skip

    def __post_init__(self) -> None:
        check_ranges(self)
        found = hashlib.sha256(_content(self.file)).hexdigest()
        if self.sha256 not in (None, found):
            raise ValueError(
                f"file '{self.file}' has changed since: its SHA-256 is not {self.sha256}; take sha256 out to use it"
            )
        object.__setattr__(self, "sha256", found)
        _ = self.plots  # it can be read, or says why not
        if self._polar and self.position is None and self.plots.antenna is None:
            raise ValueError("position_m is missing: ranges and azimuths are counted from the antenna")
        for channel in ("position",) if not self._polar else ("range", "azimuth"):
            self._stated(channel)
        if self._measured_height is not None:
            self._stated("height")

    @property
    def plots(self) -> Plots:
        """What the file says; raises ``ValueError`` where it says nothing."""
        return _plots(self.file, str(self.sha256), self.target, self.source)

    @property
    def _polar(self) -> bool:
        return self.plots.range is not None and self.plots.azimuth is not None

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured, in the order of z."""
        place_channels = ("range", "azimuth") if self._polar else ("north", "east")
        return place_channels if self._measured_height is None else (*place_channels, "height")

    @property
    def antenna(self) -> tuple[float, float, float] | None:
        """(north, east, height) m, by the scenario, else by the file; None = its plots are latitude and longitude."""
        if not self._polar:
            return None
        if self.position is not None:
            return location(self.runway, self.position)
        assert self.plots.antenna is not None
        latitude, longitude, height = self.plots.antenna
        height -= self.runway.elevation
        north, east = self._place.local(latitude, longitude, height)
        return float(north), float(east), height

    @property
    def zero_azimuth(self) -> float | None:
        """Course of zero azimuth in the frame of the threshold.

        North there is that of the threshold. Meridians meet at the pole: true north at an antenna to the east points
        left of it, by the difference of longitude times the sine of the latitude.
        """
        if self.antenna is None:
            return None
        _, longitude = self._place.geodetic(*self.antenna[:2])
        return float(self.azimuth_zero - (longitude - self.runway.longitude) * math.sin(self.runway.latitude))

    @property
    def _place(self) -> Place:
        return Place(self.runway.latitude, self.runway.longitude, self.runway.elevation)

    @property
    def period(self) -> float:
        """Median time between plots, s."""
        time = self.plots.stamps.time
        return max(float(np.median(np.diff(time))), 1 / 120) if len(time) > 1 else 1.0

    @property
    def recording(self) -> Recording:
        """When its plots were made."""
        time, dated = self._seconds, self.plots.stamps.dated
        return Recording(len(time), float(time[0]), float(time[-1]), dated, (*self.plots.remarks, *self._assumed))

    @property
    def _assumed(self) -> tuple[str, ...]:
        """What is taken for granted of the heights and of the antenna."""
        by_file = self._polar and self.position is None
        told = ("its antenna stands where the file says, within 2 m",) if by_file else ()
        if self.plots.height is not None or self.plots.pressure_altitude is None or self.air.qnh != STANDARD_PRESSURE:
            return told
        return (
            *told,
            "its pressure altitudes are taken at 1013.25 hPa: each hPa that [air] qnh_hpa differs is 8 m",
        )

    def dated(self, utc: float | None) -> Recorded:
        """The sensor for a flight at that time."""
        return dataclasses.replace(self, utc=utc)

    @functools.cached_property
    def _seconds(self) -> np.ndarray:
        """(k,) s of the flight."""
        return self.plots.stamps.in_flight(self.utc)

    @functools.cached_property
    def _measured_height(self) -> np.ndarray | None:
        """(k,) m above the threshold."""
        if self.plots.pressure_altitude is None and self.plots.sea_level_height is not None:
            return self.plots.sea_level_height - self.runway.elevation
        if self.plots.height is not None or self.plots.pressure_altitude is None:
            return self.plots.height
        heights = np.arange(LOWEST, HIGHEST, STEP)
        altitudes = self.air.pressure_altitude(heights)
        return np.asarray(np.interp(self.plots.pressure_altitude, altitudes, heights, left=np.nan, right=np.nan))

    @functools.cached_property
    def _z(self) -> np.ndarray:
        """(k, m) channels."""
        plots = self.plots
        if plots.range is not None and plots.azimuth is not None:
            azimuth = plots.azimuth
            columns = [plots.range, np.where(np.abs(azimuth) > math.pi, wrap(azimuth), azimuth)]
        else:
            height = self._measured_height
            level = 0.0 if height is None else np.where(np.isfinite(height), height, 0.0)
            columns = [*self._place.local(plots.latitude, plots.longitude, level)]
        return np.column_stack([*columns, *(() if self._measured_height is None else (self._measured_height,))])

    @functools.cached_property
    def _R(self) -> np.ndarray:
        """(k, m, m), diagonal."""
        names = [*(("range", "azimuth") if self._polar else ("position", "position"))]
        names += [] if self._measured_height is None else ["height"]
        variances = np.column_stack([self._stated(name) ** 2 for name in names])
        return variances[:, :, None] * np.eye(len(names))

    def _stated(self, name: str) -> np.ndarray:
        """(k,) standard deviations of a quantity: of the scenario, else of the file."""
        own, column = getattr(self, f"{name}_sigma"), getattr(self.plots, f"{name}_sigma")
        count = len(self.plots.stamps.time)
        if own is not None:
            return np.full(count, float(own))
        unit = "deg" if name == "azimuth" else "m"
        if column is None:
            raise ValueError(f"{name}_sigma_{unit} is missing, and the file has no such column")
        if not np.isfinite(column).all():
            raise ValueError(f"the file's column of {name}_sigma has gaps: say {name}_sigma_{unit}")
        return np.asarray(column)

    def truth(self, state: AircraftState) -> np.ndarray:
        """Noise-free channels, shape (m, ...)."""
        channels = [state.north, state.east]
        if self.antenna is not None and self.zero_azimuth is not None:
            channels = [*polar(place(state), self.antenna, self.zero_azimuth)[:2]]
        return np.stack(channels if self._measured_height is None else [*channels, state.height])

    def begin(self, time: float, streams: Streams) -> Waiting:
        """Ready for the first plot after ``time``."""
        return Waiting(int(np.searchsorted(self._seconds, time, side="right")), streams.draws)

    def step(self, state: Waiting, before: AircraftState, after: AircraftState) -> tuple[Waiting, list[Look]]:
        """Plots that were made between two records."""
        end = int(np.searchsorted(self._seconds, after.time, side="right"))
        looks = [
            Look(epoch, epoch, np.repeat(self._z[row][:, None], state.draws, axis=1), self._R[row])
            for row, epoch in zip(range(state.row, end), self._seconds[state.row : end].tolist(), strict=True)
        ]
        return state._replace(row=max(state.row, end)), looks


def _content(file: str) -> bytes:
    try:
        return read_bytes(Path(file))
    except OSError as error:
        raise ValueError(f"file '{file}' cannot be read: {error.strerror}") from None


@functools.lru_cache(maxsize=8)
def _plots(file: str, digest: str, target: str | None, source: str | None) -> Plots:
    """The plots of a file of that content, kept for the next sensor of it."""
    content = _content(file)
    if hashlib.sha256(content).hexdigest() != digest:
        raise ValueError(f"file '{file}' was changed while it was read")
    try:
        if is_asterix(content, file):
            return asterix_plots.read_plots(content, target, source)
        if source is not None:
            raise ValueError(f"is no ASTERIX, so source = '{source}' chooses nothing; target chooses an aircraft")
        return read_parquet_plots(Path(file), target) if content.startswith(PARQUET) else read_plots(content, target)
    except ValueError as error:
        raise ValueError(f"file '{Path(file).name}' {error}") from None
