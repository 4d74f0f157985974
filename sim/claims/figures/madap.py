"""The flights of MADAP; the guidelines have no figure of them."""

from __future__ import annotations

from collections.abc import Iterator

from sim.claims.plots import Curve, Plot
from sim.claims.runs.madap import SEVERAL, STEP
from sim.truths.madap import BANKS, KNOT, NAUTICAL_MILE, SPEEDS, Madap


def flights(seed: int) -> Iterator[Plot]:
    """Four of the sixteen."""
    curves = []
    for speed in SPEEDS:
        state = Madap(speed, BANKS[1]).fly(step=STEP).state
        curves.append(Curve(f"{speed / KNOT:.0f} kt", state.north / NAUTICAL_MILE, state.east / NAUTICAL_MILE))
    places = ([r.north / NAUTICAL_MILE for r in SEVERAL], [r.east / NAUTICAL_MILE for r in SEVERAL])
    yield Plot(
        "flights",
        "Four of the sixteen, bank 30 deg",
        "Dots are the radars, chosen here.",
        "north, NM",
        "east, NM",
        (*curves, Curve("radars", *places, "dots")),
        equal=True,
    )


FIGURES = {"flights": flights}
