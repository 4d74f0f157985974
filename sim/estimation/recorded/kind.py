"""A tracker that made its estimates elsewhere, from a file."""

from __future__ import annotations

import functools
import hashlib
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np

from aircraft.runway import Runway as Place
from sim.errors import ScenarioError
from sim.estimation.recorded.chain import Rows
from sim.files import read_bytes
from sim.interchange.asterix.reading import is_asterix
from sim.interchange.cells import parquet_columns
from sim.interchange.estimates import Estimates, estimates_of, estimates_of_asterix, read_estimates
from sim.interchange.tables import PARQUET
from sim.scenario.tables import Runway

EXAMPLE = Path(__file__).with_suffix(".csv")  # made up: two looks at an aircraft on its final approach
APART = 100.0  # m, of the median estimate: what heights do to latitude and longitude is less, another origin is more
DIGEST = re.compile("[0-9a-f]{64}")


@dataclass(frozen=True)
class Recorded:
    """Estimates of one flight as they were made elsewhere; ``sim.interchange.estimates`` says which columns it knows.

    Each is judged at its own time. A file without a column of draws is of the first draw of the noise. Latitude and
    longitude are brought to the plane that touches the earth at the threshold, at the height of the threshold: 400 m up
    and 30 km away that is 2 m.
    """

    file: str
    sha256: str | None = None  # of the file; absent = as it is found now
    flight: int = 0  # whose track it is, of the flights of the scenario
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    recorded: ClassVar[bool] = True
    example: ClassVar[dict[str, Any]] = {"file": str(EXAMPLE)}

    def __post_init__(self) -> None:
        if self.sha256 is not None and not DIGEST.fullmatch(self.sha256):
            raise ValueError("sha256 must be 64 hexadecimal digits")
        if self.flight < 0:
            raise ValueError("flight must not be negative")
        found = hashlib.sha256(_content(self.file)).hexdigest()
        if self.sha256 not in (None, found):
            raise ValueError(
                f"file '{self.file}' has changed since: its SHA-256 is not {self.sha256}; take sha256 out to use it"
            )
        object.__setattr__(self, "sha256", found)
        _ = self._read  # it can be read, or says why not

    @property
    def _read(self) -> Estimates:
        return _estimates(self.file, str(self.sha256))

    @property
    def channels(self) -> tuple[str, ...]:
        """Components of the estimates."""
        return ("north", "north_rate", "east", "east_rate") if self._read.velocity is not None else ("north", "east")

    def estimates(self, utc: float | None) -> Rows:
        """What the file says, for a flight whose time 0 is ``utc``, s since 1970; None = it is flown at no date."""
        read = self._read
        count = len(read.stamps.time)
        north, east = self._place(read)
        columns = [north, east]
        if read.velocity is not None:
            columns = [north, read.velocity[:, 0], east, read.velocity[:, 1]]
        return Rows(
            read.stamps.in_flight(utc),
            np.zeros(count, int) if read.draw is None else read.draw,
            np.zeros(count, int) if read.number is None else np.unique(read.number, return_inverse=True)[1],
            np.column_stack(columns),
            read.cov,
        )

    def _place(self, read: Estimates) -> tuple[np.ndarray, np.ndarray]:
        """(r,) m north and east of the threshold.

        A file that says both is read by x and y where they are counted from the threshold, which they are if they agree
        with latitude and longitude; else they are counted from another place.
        """
        if read.geographic is not None:
            runway = Place(self.runway.latitude, self.runway.longitude, self.runway.elevation)
            place = runway.local(*read.geographic.T)
            if read.local is None or np.median(np.hypot(*(np.array(place) - read.local.T))) > APART:
                return place
        assert read.local is not None, "a file without a place is refused"
        north, east = read.local.T
        return north, east


def _content(file: str) -> bytes:
    try:
        return read_bytes(Path(file))
    except OSError as error:
        raise ValueError(f"file '{file}' cannot be read: {error.strerror}") from None


@functools.lru_cache(maxsize=8)
def _estimates(file: str, digest: str) -> Estimates:
    """The estimates of a file of that content, kept for the next look at it."""
    content = _content(file)
    if hashlib.sha256(content).hexdigest() != digest:
        raise ValueError(f"file '{file}' was changed while it was read")
    try:
        if is_asterix(content, file):
            return estimates_of_asterix(content)
        if content.startswith(PARQUET):
            return estimates_of(parquet_columns(Path(file), "estimates"))
        return read_estimates(content)
    except (ValueError, ScenarioError) as error:
        raise ValueError(f"file '{file}' {error}") from None
