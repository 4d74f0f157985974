"""The curves of all trackers as the figures show them: each has one look, the same in every figure."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from sim.metrics.conformance import MISMATCHED
from sim.metrics.error_curves import ErrorCurves
from sim.reporting.figures import style

FIRST = ("position_m", "cross_track_m", "height_m")  # channels in the order in which they are shown


class Shown(NamedTuple):
    """A tracker in the figures."""

    name: str
    law_from: str | None
    look: dict[str, Any]  # colour and dashes
    curves: ErrorCurves


def shown_trackers(scenario: Any, tracked: dict[str, Any]) -> list[Shown]:
    """The trackers that can be compared with the truth in any channel, or say a place, each with its look."""
    looks = looks_of(scenario, tracked)
    return [
        Shown(name, it.law_from, looks[name], it.curves)
        for name, it in tracked.items()
        if it.curves.channels or np.isfinite(it.curves.path.place).any()
    ]


def shown_channels(shown: list[Shown]) -> list[str]:
    """Names of the channels that the trackers have: place first, angles where no tracker knows a place."""
    found = dict.fromkeys(channel for one in shown for channel in one.curves.channels)
    first = [channel for channel in FIRST if channel in found]
    return first or list(found)


def looks_of(scenario: Any, tracked: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """A colour for each tracker; one with a mismatched law has that of the first of its kind, dashed in its own way."""
    choices = {name: scenario.trackers.get(name) for name in tracked}
    kinds = {name: name if choice is None else choice.kind for name, choice in choices.items()}
    mismatched = [name for name, one in tracked.items() if one.law_from == MISMATCHED]
    colours: dict[str, str] = {}  # of the first of each kind
    looks: dict[str, dict[str, Any]] = {}
    for number, name in enumerate(name for name in tracked if name not in mismatched):
        again, place = divmod(number, len(style.TRACKERS))
        looks[name] = {"colour": style.TRACKERS[place], "dashes": style.DOT_DASHES[again % len(style.DOT_DASHES)]}
        colours.setdefault(kinds[name], style.TRACKERS[place])
    for name in mismatched:
        free = style.TRACKERS[len(looks) % len(style.TRACKERS)]
        colour = colours.setdefault(kinds[name], free)
        twins = sum(looks[other]["colour"] == colour for other in mismatched if other in looks)
        looks[name] = {"colour": colour, "dashes": style.DASHES[twins % len(style.DASHES)]}
    return looks
