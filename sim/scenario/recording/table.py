"""``[record]``: a recorded flight stands in place of an aircraft that flies."""

from __future__ import annotations

from dataclasses import dataclass, field

from sim.scenario.tables import LegsTable, LegTable, Runway

# The final where no route is told: the extended centreline, by the heights and speeds of a usual clearance
FINAL = 60_000.0  # m before the aiming point, where it begins
FINAL_SPEED, FINAL_HEIGHT = 82.3, 914.4  # m/s and m: 160 kt, 3000 ft above the threshold


@dataclass(frozen=True)
class RecordTable:
    """A recorded flight: the file, which of its flights, and what its columns are called where nobody knows them.

    Without a file nothing is known of it but what sensors of the kind ``recorded`` saw.
    """

    file: str | None = None  # CSV or Parquet; a relative path counts from the folder of the scenario's file
    flight: str | None = None  # absent = the only one of the file
    runway: str | None = None  # a TOML file with a table [runway], and [air] if it likes; absent = it stands here
    sha256: str | None = None  # of the file, as the run had it that wrote this scenario; another content is refused
    columns: dict[str, str] = field(default_factory=dict)  # our names with a unit -> names of the file

    def __post_init__(self) -> None:
        for name in ("flight", "sha256", "columns"):
            if self.file is None and getattr(self, name):
                raise ValueError(f"{name} is of a file of recorded tracks, and no file is named")

    @property
    def known(self) -> bool:
        """Whether there is a true flight."""
        return self.file is not None


def final(runway: Runway) -> LegsTable:
    """The extended centreline to the aiming point, as the route of a recording for which none is told."""
    (north, east), end = (runway.to_local(runway.aiming_point - before, 0.0) for before in (FINAL, 0.0))
    return LegsTable((LegTable((north, east), end, FINAL_SPEED, FINAL_HEIGHT),))
