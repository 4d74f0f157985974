"""What a map of ratios shows, in one sentence: where one tracker becomes worse than the other, and by how much."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sim.reporting.text.labels import number, words
from sim.studies.figures import Scale
from sim.studies.limits.maps import Panel, RatioMap, undecided

SEPARATED = 0.9  # least share of the decided cells that a time at the limits must tell apart to be named


def question(one: RatioMap) -> str:
    """What a study of a contrast asks."""
    return f"Where does {words(one.of)} err more than {words(one.against)}, and by how much?"


def answer(one: RatioMap) -> str:
    """The sentence."""
    ratio, low, high, open_ = (
        np.concatenate([np.ravel(part) for part in parts])
        for parts in (
            [panel.ratio for panel in one.panels],
            [panel.low for panel in one.panels],
            [panel.high for panel in one.panels],
            [undecided(panel) for panel in one.panels],
        )
    )
    known = np.isfinite(ratio)
    worse, count = known & ~open_ & (ratio > 1.0), int(known.sum())
    subject, other = words(one.of), words(one.against)
    subject = subject[:1].upper() + subject[1:]
    rest = f" ({one.what})" + (f"; {len(ratio) - count} cells have no ratio" if count < len(ratio) else "")
    if not count:
        return f"No cell has a ratio of {words(one.of)} to {other} ({one.what})."
    if not worse.any():
        best = int(np.nanargmin(ratio))
        least = _times(ratio, low, high, best)
        return f"{subject} errs more than {other} in none of {count} cells; at best {least}{rest}."
    worst = int(np.nanargmax(ratio))
    most = f"; in the worst cell {_times(ratio, low, high, worst)}{rest}."
    if worse.sum() == count:
        return f"{subject} errs more than {other} in all of {count} cells{most}"
    seconds = _separating(one.panels)
    acts = (
        f"where a limit acts for more than about {seconds:.0f} s" if seconds else f"in {worse.sum()} of {count} cells"
    )
    place = _where(one)
    return f"{subject} errs more than {other} {acts}{': ' + place if place else ''}{most}"


def _times(ratio: np.ndarray, low: np.ndarray, high: np.ndarray, place: int) -> str:
    """A ratio with its interval, where it has one."""
    between = f" ({number(float(low[place]))} to {number(float(high[place]))})" if np.isfinite(low[place]) else ""
    return f"{number(float(ratio[place]))} times{between}"


def _separating(panels: Sequence[Panel]) -> float | None:
    """Seconds at the limits that tell cells that are worse from those that are better; None where none does."""
    times, worse = [], []
    for panel in panels:
        if panel.at_limits is None:
            return None
        decided = np.isfinite(panel.ratio) & ~undecided(panel)
        times.append(panel.at_limits[decided])
        worse.append(panel.ratio[decided] > 1.0)
    time, above = np.concatenate(times), np.concatenate(worse)
    levels = np.unique(time)
    cuts = 0.5 * (levels[1:] + levels[:-1])
    right = [np.mean((time > cut) == above) for cut in cuts]
    return float(cuts[int(np.argmax(right))]) if right and max(right) >= SEPARATED else None


def _where(one: RatioMap) -> str:
    """Where the ratio passes 1 on a line through the middle of the map, or on the nearest one that has such a place."""
    for panel in _from_the_middle(one.panels):
        for across, along, table in (
            (one.y, one.x, panel.ratio),
            *([(one.x, one.y, panel.ratio.T)] if one.y is not None else []),
        ):
            if along is None or along.ticks is not None:
                continue
            for row in _from_the_middle(range(len(table))):
                found = _crossing(along.at, np.log(table[row]))
                if found is not None:
                    side, place = found
                    return f"{side} {_at(along, place)}{_fixed(across, row, panel.title)}"
    return ""


def _from_the_middle(items: Sequence[Any]) -> list[Any]:
    """Items by their distance from the one in the middle."""
    middle = (len(items) - 1) // 2
    return [items[place] for place in sorted(range(len(items)), key=lambda place: abs(place - middle))]


def _crossing(at: np.ndarray, height: np.ndarray) -> tuple[str, float] | None:
    """The one place where a height passes 0, by straight lines between the values, and on which side it is above."""
    sides = np.flatnonzero(np.diff(np.signbit(height))) if np.isfinite(height).all() else np.zeros(0, int)
    if len(sides) != 1:
        return None
    (k,) = sides
    place = at[k] + (at[k + 1] - at[k]) * height[k] / (height[k] - height[k + 1])
    return ("beyond" if height[k] < 0.0 else "below"), float(place)


def _fixed(across: Scale | None, row: int, title: str) -> str:
    """What the other axes have there."""
    named = (
        [] if across is None else [_at(across, float(across.at[row])) if across.ticks is None else across.ticks[row]]
    )
    return f" at {' and '.join(named)}" * bool(named) + f" ({title})" * bool(title)


def _at(scale: Scale, value: float) -> str:
    """A value of an axis with its name and unit."""
    name, _, unit = scale.label.partition(", ")
    return f"a {name.removeprefix('autopilot ').removeprefix('law ')} of {value:.3g} {unit}".rstrip()
