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
    looks = _looks(scenario, tracked)
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


def _looks(scenario: Any, tracked: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """A colour for each kind that assumes a law and for every other tracker; dashes where the law is mismatched."""
    colours: dict[str, str] = {}
    looks: dict[str, dict[str, Any]] = {}
    for name, one in tracked.items():
        choice = scenario.trackers.get(name)
        family = name if choice is None or one.law_from is None else f"kind {choice.kind}"
        colour = colours.setdefault(family, style.TRACKERS[len(colours) % len(style.TRACKERS)])
        looks[name] = {"color": colour, "dashes": style.DASHED if one.law_from == MISMATCHED else style.SOLID}
    return looks
