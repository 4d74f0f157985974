"""write_asterix(): the plots and tracks of a run as ASTERIX, a file for each sensor and each tracker."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sim.errors import OutputError
from sim.interchange.asterix.blocks import Blocks
from sim.interchange.asterix.encoding import FieldError
from sim.interchange.asterix.pcap import capture_of
from sim.interchange.asterix.writing import MOST_DRAWS, system_tracks
from sim.results.asterix.sensors import messages_of
from sim.results.asterix.trackers import estimates_of
from sim.results.result import Result


class Messages(NamedTuple):
    """What becomes one file."""

    name: str  # without its ending
    of: str  # what the file holds, in words
    blocks: Blocks


def write_asterix(
    result: Result, place: Path, *, begins: float, draw: int | None = None, capture: bool = False
) -> tuple[list[str], list[str]]:
    """Write the plots of the sensors and the tracks of the trackers of a result into an existing folder.

    Gives a sentence for each file, which begins with its name, and one for whatever is left out. A radar is CAT048 with
    CAT034, a receiver of ADS-B CAT021, a tracker CAT062. They are told apart by SIC: sensors in the order of the
    scenario, from 1 on, then trackers.

    Parameters
    ----------
    begins : s since 1970 when the flight begins; a flight with a date has its own
    draw : the only one that leaves; None = all, each with its number as track number
    capture : write captures of UDP datagrams (pcap) instead of data blocks as they stand

    Raises ``OutputError`` in one sentence where nothing can leave, or a value is beyond what its item holds.
    """
    draws = result.scenario.draws
    if draw is not None and not 0 <= draw < draws:
        raise OutputError(f"--draw {draw}: the run has the draws 0 to {draws - 1}")
    if draw is None and draws > MOST_DRAWS:
        raise OutputError(f"{draws} draws are more than the {MOST_DRAWS} that one file tells apart; say --draw K")
    chosen = np.arange(draws) if draw is None else np.array([draw])
    begins = begins if result.flight.utc is None else result.flight.utc
    files: list[str] = []
    left: list[str] = []
    try:
        for one in _messages(result, begins, chosen, left.append):
            name = f"{one.name}.{'pcap' if capture else 'ast'}"
            with (place / name).open("wb") as file:
                file.writelines(capture_of(one.blocks) if capture else [one.blocks.octets.tobytes()])
            files.append(f"{name}: {one.of}")
    except FieldError as error:
        raise OutputError(f"cannot leave as ASTERIX: {error}") from None
    if not files:
        raise OutputError(f"nothing can leave as ASTERIX: {left[0] if left else 'the scenario has no sensors'}")
    return files, left


def _messages(result: Result, begins: float, draws: np.ndarray, left: Callable[[str], None]) -> Iterator[Messages]:
    """What becomes a file, one after another; ``left`` is told what is left out."""
    for sic, (name, record) in enumerate(result.records.items(), 1):
        blocks = messages_of(result.scenario, sic, name, record, begins, draws)
        if blocks is None:
            left(f"sensor '{name}' measures {', '.join(record.channels)}, which no category here has")
        else:
            yield Messages(f"measurements.{name}", f"{len(record.time)} looks", blocks)
    for sic, (name, one) in enumerate(result.tracks.items(), 1 + len(result.records)):
        estimates, lost = estimates_of(result, one, begins, draws)
        if lost:
            left(f"tracker '{name}': {lost} estimates of places or speeds that no aircraft has")
        if estimates is None:
            left(f"tracker '{name}' estimates no place on the ground plane")
        else:
            yield Messages(f"tracks.{name}", f"{len(estimates.stamps)} estimates", system_tracks(sic, estimates))
