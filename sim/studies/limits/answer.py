"""What a map of ratios shows, in one sentence: where one tracker becomes worse than the other, and by how much."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from sim.reporting.text.labels import words
from sim.scenario.tables import Contrast
from sim.studies.figures import Scale
from sim.studies.limits.maps import Panel, RatioMap, undecided

SEPARATED = 0.9  # least share of the decided cells that a time at the limits must tell apart to be named


def question(asked: Contrast) -> str:
    """What a study of a contrast asks."""
    return f"Where does {words(asked.of)} err more than {words(asked.against)}, and by how much?"


def answer(asked: Contrast, maps: Sequence[RatioMap]) -> str:
    """The sentence, of the first map; where there is none, that nothing could be compared."""
    of, against = words(asked.of), words(asked.against)
    of = of[:1].upper() + of[1:]
    if not maps or not any(np.isfinite(panel.ratio).any() for panel in maps[0].panels):
        return f"{of} and {against} cannot be compared in any cell: one of them never tracked, or was lost."
    one = maps[0]
    ratio, low, high, open_ = (
        np.concatenate([np.ravel(part(panel)) for panel in one.panels])
        for part in (lambda p: p.ratio, lambda p: p.low, lambda p: p.high, undecided)
    )
    known = np.isfinite(ratio)
    count, worse = int(known.sum()), int((known & ~open_ & (ratio > 1.0)).sum())
    lacking = f"; {len(ratio) - count} cells have no ratio" if count < len(ratio) else ""

    def extreme(place: int) -> str:
        between = f"{low[place]:.3g} to {high[place]:.3g}; " if np.isfinite(low[place]) else ""
        return f"{ratio[place]:.3g} times ({between}RMSE, {one.what}){lacking}."

    if not worse:
        return f"{of} errs more than {against} in none of {count} cells; at most {extreme(int(np.nanargmax(ratio)))}"
    most = f"in the worst cell {extreme(int(np.nanargmax(ratio)))}"
    if worse == count:
        return f"{of} errs more than {against} in all of {count} cells; {most}"
    seconds, place = _separating(one.panels), _where(one)
    acts = f"where a limit acts for more than about {seconds:.0f} s" if seconds else f"in {worse} of {count} cells"
    return f"{of} errs more than {against} {acts}{': ' + place if place else ''}; {most}"


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
    if across is None:
        return f" ({title})" if title else ""
    value = _at(across, float(across.at[row])) if across.ticks is None else f"{across.label} {across.ticks[row]}"
    return f" at {value}" + (f" ({title})" if title else "")


def _at(scale: Scale, value: float) -> str:
    """A value of an axis with its name and unit."""
    name, _, unit = scale.label.partition(", ")
    shown = f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"
    return f"a {name.removeprefix('autopilot ').removeprefix('law ')} of {shown} {unit}".rstrip()
