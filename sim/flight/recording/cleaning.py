"""Rows of a recorded track that say nothing are taken out, and of what gaps leave one piece is kept."""

from __future__ import annotations

import math

import numpy as np

from sim.flight.outcomes import LONGEST_FLIGHT
from sim.flight.recording.places import Rows

STILL = 0.5  # m: who moves less from one row to the next has not been seen anew
LONGEST_GAP = 20.0  # s; in its middle a smoothed place is known to 7 m
FASTEST = 400.0  # m/s over the ground, that nothing on an approach exceeds
SLACK = 300.0  # m, by which two rows may lie farther apart: stamps jitter
STEEPEST = 100.0  # m/s up or down
HEIGHT_SLACK = 100.0  # m
FARTHEST = 111_120.0  # m, 60 NM: the range of a terminal radar; what lies beyond is no part of an approach
SHORTEST, FEWEST = 20.0, 10  # s and rows: less is no flight
AIRBORNE = 20.0  # m/s; a piece that was never so fast is a taxiing aircraft


def cleaned(rows: Rows) -> tuple[Rows, list[str]]:
    """The rows of one approach, each at its own place and time, and what was taken out.

    In this order: rows without time or place; rows of a stamp that was there already; stale rows, which repeat the last
    place; rows that nothing could have flown to, `FASTEST`; rows beyond `FARTHEST`. At gaps longer than `LONGEST_GAP`
    the record falls into pieces, and that which ends nearest the threshold is the flight. Of a longer flight the last
    `LONGEST_FLIGHT` seconds are kept.

    Raises ``ValueError``, in words, where nothing is left that could be a flight.
    """
    told: list[str] = []
    count = len(rows.time)
    if not count:
        raise ValueError("it has no rows")

    def keep(which: np.ndarray, why: str) -> None:
        nonlocal rows
        out = len(rows.time) - int(which.sum())
        if out:
            told.append(f"{out} of {count} rows {why}")
            rows = rows.some(which)

    keep(np.isfinite(rows.time + rows.north + rows.east), "have no time or place and are left out")
    if not len(rows.time):
        raise ValueError(f"none of its {count} rows has a time and a place")
    if np.any(np.diff(rows.time) < 0.0):
        told.append(f"{int(np.sum(np.diff(rows.time) < 0.0))} of {count} rows came out of order and are sorted")
        rows = rows.some(np.argsort(rows.time, kind="stable"))
    keep(_after_first(np.diff(rows.time) > 0.0), "repeat a time stamp and are left out")
    moved = np.hypot(np.diff(rows.north), np.diff(rows.east)) > STILL
    keep(_after_first(moved), "are stale, their place is repeated, and are left out")
    before = len(rows.time)
    possible = _possible(rows)
    if before and possible.sum() < 0.5 * before:
        raise ValueError(
            f"{before - int(possible.sum())} of {before} rows lie where nothing flies to from the rows before, "
            f"at more than {FASTEST:g} m/s: are units or flights mixed?"
        )
    keep(possible, f"lie where nothing flies to, at more than {FASTEST:g} m/s, and are left out")
    distance = np.hypot(rows.north, rows.east)
    if len(distance) and distance.min() > FARTHEST:
        raise ValueError(
            f"it never comes nearer to the threshold than {distance.min() / 1e3:.0f} km: another runway, or unit?"
        )
    keep(distance <= FARTHEST, f"lie beyond {FARTHEST / 1852.0:.0f} NM and are left out")
    rows = _piece(rows, told)
    keep(rows.time >= rows.time[-1] - LONGEST_FLIGHT, f"lie before the last {LONGEST_FLIGHT:.0f} s and are left out")
    height = np.where(_level(rows), rows.height, np.nan)
    if (wrong := int(np.isfinite(rows.height).sum() - np.isfinite(height).sum())) > 0:
        told.append(f"{wrong} of {count} rows have a height that nothing climbs to, which is left out")
    if not np.isfinite(height).any():
        raise ValueError("it has no height in any row that is left")
    return rows._replace(height=height), told


def _after_first(later: np.ndarray) -> np.ndarray:
    """(k,) bool: the first row, and those of the others that are wanted."""
    return np.concatenate((np.ones(1, bool), later))


def _possible(rows: Rows) -> np.ndarray:
    """(k,) bool: rows that one aircraft can have flown through: the longest run, and what fits to its ends."""
    step = np.hypot(np.diff(rows.north), np.diff(rows.east))
    broken = np.flatnonzero(step > FASTEST * np.diff(rows.time) + SLACK) + 1
    runs = np.split(np.arange(len(rows.time)), broken)
    longest = max(range(len(runs)), key=lambda number: len(runs[number]))
    kept = np.zeros(len(rows.time), bool)
    kept[runs[longest]] = True
    for order in (range(longest + 1, len(runs)), range(longest - 1, -1, -1)):
        end = runs[longest][-1 if order.step == 1 else 0]
        for number in order:
            near = runs[number][0 if order.step == 1 else -1]
            way = math.hypot(rows.north[near] - rows.north[end], rows.east[near] - rows.east[end])
            if way <= FASTEST * abs(rows.time[near] - rows.time[end]) + SLACK:
                kept[runs[number]] = True
                end = runs[number][-1 if order.step == 1 else 0]
    return kept


def _level(rows: Rows) -> np.ndarray:
    """(k,) bool: rows whose height is not far off the median of its neighbours."""
    seen = np.flatnonzero(np.isfinite(rows.height))
    kept = np.zeros(len(rows.time), bool)
    if len(seen) < 3:
        kept[seen] = True
        return kept
    height, time = rows.height[seen], rows.time[seen]
    width = min(5, len(seen) - (len(seen) + 1) % 2)
    padded = np.pad(height, width // 2, mode="edge")
    middle = np.median(np.lib.stride_tricks.sliding_window_view(padded, width), axis=1)
    stamps = np.lib.stride_tricks.sliding_window_view(np.pad(time, width // 2, mode="edge"), width)
    kept[seen] = np.abs(height - middle) <= STEEPEST * np.ptp(stamps, axis=1) + HEIGHT_SLACK
    return kept


def _piece(rows: Rows, told: list[str]) -> Rows:
    """The flight among the pieces that gaps leave."""
    cuts = np.flatnonzero(np.diff(rows.time) > LONGEST_GAP) + 1
    pieces = [rows.some(piece) for piece in np.split(np.arange(len(rows.time)), cuts)]
    flown = [piece for piece in pieces if _is_flight(piece)]
    if not flown:
        span = float(np.ptp(rows.time)) if len(rows.time) else 0.0
        raise ValueError(
            f"{len(rows.time)} rows over {span:.0f} s are no flight: it takes {FEWEST} rows over {SHORTEST:g} s "
            f"without a gap of more than {LONGEST_GAP:g} s, at {AIRBORNE:g} m/s or more"
        )
    chosen = min(flown, key=lambda piece: math.hypot(piece.north[-1], piece.east[-1]))
    if len(pieces) > 1:
        told.append(
            f"gaps of more than {LONGEST_GAP:g} s leave {len(pieces)} pieces; the flight is that of {len(chosen.time)} "
            f"rows which ends nearest the threshold, {_seconds(chosen)} s of {_seconds(rows)} s"
        )
    return chosen


def _seconds(rows: Rows) -> str:
    return f"{rows.time[-1] - rows.time[0]:.0f}"


def _is_flight(rows: Rows) -> bool:
    if len(rows.time) < FEWEST or rows.time[-1] - rows.time[0] < SHORTEST:
        return False
    third = len(rows.time) // 3  # over a third of it, so that jitter is no speed
    way = np.hypot(rows.north[third:] - rows.north[:-third], rows.east[third:] - rows.east[:-third])
    return bool((way / (rows.time[third:] - rows.time[:-third])).max() >= AIRBORNE)
