"""What `compare` finds between runs of an26_turbulence with 8 flights: nothing between seeds, a changed law always.

    python -m pytest -m acceptance tests/acceptance/test_compare.py

flies 2400 flights of about two seconds of one core each; ``COMPARE_PAIRS=26`` before it takes fewer pairs. The method
is that of ``sim.studies.comparing.judging``: all metrics together, by arrangements of the flights, with an error of
2.5 % over the family of all metrics. A user who changes a key keeps the seed, so that the second figure is of pairs of
flights; between runs of different seeds, turbulence hides so small a change, and that is told beside it.
"""

import os
from functools import cache

import pytest

import sim

pytestmark = pytest.mark.acceptance
PAIRS, FLIGHTS = int(os.environ.get("COMPARE_PAIRS", 100)), 8
SEEDS = range(1, 2 * PAIRS, 2)  # of the first run of each pair; the second has the next one
QUIET, FOUND = 0.95, 0.9  # of the pairs
LIMIT = "autopilot.law.cross_track_limit_m"


@cache
def flown(seed, factor=1.0):
    """A run; its law's cross-track limit times ``factor``."""
    changed = {}
    if factor != 1.0:
        changed[LIMIT] = factor * sim.prepare(sim.read("an26_turbulence")).law.cross_track_limit
    return sim.run("an26_turbulence", seed=seed, flights=FLIGHTS, workers=2, overrides=changed)


def told(a, b):
    """Whether a comparison says that anything has changed."""
    found = sim.compare(a, b)
    return found.differs or bool(found.changed)


def test_between_seeds_nothing_changes(row):
    """Independent pairs: seeds 1 and 2, 3 and 4, and so on."""
    quiet = sum(not told(flown(seed), flown(seed + 1)) for seed in SEEDS)
    met = quiet >= QUIET * PAIRS
    row("pairs of seeds without a flagged metric", ">= 95 of 100", f"{quiet} of {PAIRS}", met)
    assert met


def test_a_cross_track_limit_changed_by_a_tenth_is_found(row):
    found = sum(told(flown(seed), flown(seed, 1.1)) for seed in SEEDS)
    hidden = sum(told(flown(seed + 1), flown(seed, 1.1)) for seed in SEEDS)
    met = found >= FOUND * PAIRS
    measured = f"{found} of {PAIRS} (with another seed as well: {hidden})"
    row("cross-track limit changed by 10 %: found", ">= 90 of 100", measured, met)
    assert met
