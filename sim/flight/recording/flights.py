"""The flights of a file of recorded tracks, each made when it is asked for."""

from __future__ import annotations

import difflib
import functools
from collections.abc import Iterator, Mapping
from pathlib import Path

from aircraft.air import Air
from autopilot.route import Route
from sim.errors import ScenarioError
from sim.flight.record import Flight
from sim.flight.recording.flight import recorded_flight
from sim.interchange.track_record import TrackRecord
from sim.interchange.tracks import read_tracks
from sim.scenario.reading import read_runway
from sim.scenario.recording.completion import sha256
from sim.scenario.recording.table import RecordTable
from sim.scenario.tables import Runway

SHOWN, MOST_NEAR = 12, 2000  # names of flights in a sentence, and among which a near one is looked for


class RecordedFlights(Mapping[str, Flight]):
    """Flights by name, of one file and to one runway. One is smoothed when it is first asked for, and kept."""

    def __init__(self, tracks: dict[str, TrackRecord], runway: Runway, air: Air) -> None:
        self._tracks, self._runway, self._air = tracks, runway, air
        self._made: dict[str, Flight] = {}

    def __getitem__(self, name: str) -> Flight:
        """A flight; raises ``ScenarioError``, in a sentence, for a track that is no flight to this runway."""
        if name not in self._made:
            self._made[name] = recorded_flight(self._tracks[name], self._runway, self._air)
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._tracks)

    def __len__(self) -> int:
        return len(self._tracks)


def recorded(path: str | Path, runway: str | Path, columns: Mapping[str, str] | None = None) -> RecordedFlights:
    """The flights of a file of recorded tracks, smoothed on demand, in the frame of a runway.

    Parameters
    ----------
    path : CSV or Parquet in the columns of the traffic library or of OpenSky's state vectors
    runway : a TOML file with a table ``[runway]``: latitude_deg, longitude_deg, heading_deg, elevation_m; where it has
        ``[air]`` too, pressure altitudes become heights by its qnh_hpa and temperature_c
    columns : what the columns are called in another file, ``{"time": "t", "latitude_deg": "y", "height_ft": "alt"}``

    Raises ``ScenarioError``, in one sentence, for what is no such file.
    """
    place, air = read_runway(Path(runway))
    return RecordedFlights(read_tracks(path, columns), place, air)


@functools.lru_cache(maxsize=1)
def _tracks(path: str, digest: str | None, columns: tuple[tuple[str, str], ...]) -> dict[str, TrackRecord]:
    """The tracks of a file of this content, kept for the next flight of it."""
    tracks = read_tracks(path, dict(columns))
    if digest is not None and sha256(Path(path)) != digest:
        raise ScenarioError(f"{path} was changed while it was read")
    return tracks


def recording(record: RecordTable, runway: Runway, air: Air, route: Route) -> Flight:
    """The flight of a ``[record]``; raises ``ValueError``, in one sentence, where there is none."""
    tracks = _tracks(record.file, record.sha256, tuple(sorted(record.columns.items())))
    wanted = record.flight
    if wanted is None and len(tracks) == 1:
        (wanted,) = tracks
    if wanted is None:
        raise ValueError(f"flight: the file has {len(tracks)} flights, say which: {_some(tracks)}")
    if wanted not in tracks:
        near = difflib.get_close_matches(wanted, list(tracks)[:MOST_NEAR], n=1)
        hint = f"did you mean '{near[0]}'?" if near else f"it has {_some(tracks)}"
        raise ValueError(f"flight: no flight '{wanted}' in {record.file}; {hint}")
    return recorded_flight(tracks[wanted], runway, air, route)


def _some(tracks: dict[str, TrackRecord]) -> str:
    """The names of the flights of a file, the first of them where there are many."""
    return ", ".join(list(tracks)[:SHOWN]) + (", ..." if len(tracks) > SHOWN else "")
