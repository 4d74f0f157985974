"""What leaves in the formats of other programs: recordings of traffic, ASTERIX, a globe, a root of JSBSim."""

from __future__ import annotations

import shlex
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sim.cli.exporting.records import is_study
from sim.errors import OutputError
from sim.files import refuse_unwritten, staged, whole

if TYPE_CHECKING:
    from sim.studies.recordings import Written

MIDNIGHT = 1767225600.0  # s since 1970: 2026-01-01, 0 h UTC
YEARS = (1971, 2099)  # in which a flight can begin
KMZ = "flight.kmz"


def export_tracks(
    folder: Path, out: Path | None, date: str | None, workers: int, plugins: Any, progress: Any
) -> Written:
    """Write the flights of a folder as recordings of traffic.

    ``date`` is when the first flight begins, ISO 8601, in UTC where it names no zone.
    """
    from sim.studies.recordings import DATE, write_recordings

    begins = _begins(date, DATE)
    return write_recordings(folder, out, date=begins, workers=workers, plugins=plugins, progress=progress)


def export_jsbsim(scenario: str, folder: Path, overrides: dict[str, Any], plugins: Any) -> list[str]:
    """Write a scenario as a root of JSBSim that flies it alone; what was written and how to fly it, in lines."""
    from sim.experiment import read
    from sim.flight.jsbsim_root.folder import SCRIPT, write_jsbsim_root
    from sim.flight.preparation import prepare

    root = write_jsbsim_root(prepare(read(scenario, overrides, plugins=plugins)), folder)
    fly = f"jsbsim --root={shlex.quote(str(folder))} --script={SCRIPT} --simulation-rate={root.rate:g}"
    return [f"wrote {folder}: {len(root.files)} files, {root.components} components of its autopilot", f"fly it: {fly}"]


def export_asterix(
    folder: Path, date: str | None, draw: int | None, capture: bool, plugins: Any
) -> tuple[list[str], list[str]]:
    """Write the plots and tracks of a run into its folder as ASTERIX; what was written and what was left out, in words.

    Without ``date`` the flight begins at midnight, so that times of day are its own. Raises ``OutputError`` in one
    sentence for a folder that is not of a run, before anything is written.
    """
    from sim.results.asterix.files import write_asterix
    from sim.results.loading import load

    _refuse_study(folder)
    begins = _begins(date, MIDNIGHT)
    result = load(folder, plugins=plugins)
    with staged(folder) as place:
        return write_asterix(result, place, begins=begins, draw=draw, capture=capture)


def export_kmz(
    folder: Path, out: Path | None, date: str | None, draw: int, plugins: Any
) -> tuple[str, tuple[str, ...]]:
    """Write a run as a KMZ, ``flight.kmz`` in its folder unless told; what was written and what was left out, in words.

    Raises ``OutputError`` in one sentence for a folder that is not of a run, and for a file beyond it that exists.
    """
    from sim.results.globe import globe
    from sim.results.loading import load

    _refuse_study(folder)
    begins = _begins(date, MIDNIGHT)
    path = folder / KMZ if out is None else out
    if path.suffix != ".kmz":
        raise OutputError(f"{path}: name it NAME.kmz")
    if not path.parent.is_dir():
        raise OutputError(f"{path.parent}: no such folder to write into")
    if path.parent.resolve() != folder.resolve() and (path.exists() or path.is_symlink()):
        raise OutputError(f"{path}: exists already; choose another name with -o")
    found = globe(load(folder, plugins=plugins), begins=begins, draw=draw)
    with whole(path) as partial:
        partial.write_bytes(found.kmz)
    return f"{path}: {', '.join(found.shown)}", found.left


def _refuse_study(folder: Path) -> None:
    refuse_unwritten(folder)
    if is_study(folder):
        raise OutputError(f"{folder}: is of a study, which keeps no plots and tracks; name the folder of a run")


def _begins(date: str | None, otherwise: float) -> float:
    """s since 1970 of a date as it is told, in UTC where it names no zone."""
    if date is None:
        return otherwise
    try:
        told = datetime.fromisoformat(date)
    except ValueError:
        raise OutputError(f"--date {date}: write it as 2026-01-01T12:00:00Z") from None
    if not YEARS[0] <= told.year <= YEARS[1]:
        raise OutputError(f"--date {date}: must lie in the years {YEARS[0]} to {YEARS[1]}")
    return (told if told.tzinfo is not None else told.replace(tzinfo=UTC)).timestamp()
