"""The flights of MADAP; the guidelines have no figure of them."""

from __future__ import annotations

from collections.abc import Iterator

from sim.claims.papers.madap.experiment import SEVERAL, STEP
from sim.claims.plots import Curve, Plot
from sim.flight.truths.madap import BANKS, KNOT, NAUTICAL_MILE, SPEEDS, Madap


def flights(seed: int) -> Iterator[Plot]:
    """Four of the sixteen."""
    curves = []
    for speed in SPEEDS:
        state = Madap(speed, BANKS[1]).fly(step=STEP).state
        curves.append(Curve(f"{speed / KNOT:.0f} kt", state.east / NAUTICAL_MILE, state.north / NAUTICAL_MILE))
    places = ([r.east / NAUTICAL_MILE for r in SEVERAL], [r.north / NAUTICAL_MILE for r in SEVERAL])
    yield Plot(
        "flights",
        "Four of the sixteen, bank 30 deg",
        "The radars are chosen here.",
        "east, NM",
        "north, NM",
        (*curves, Curve("radars", *places, "places")),
        equal=True,
    )


FIGURES = {"flights": flights}
