"""What `compare` finds between runs of an26_turbulence with 8 flights: nothing between seeds, a changed law always."""

from functools import cache

import pytest

import sim

pytestmark = pytest.mark.acceptance
PAIRS, FLIGHTS = 100, 8
QUIET, FOUND = 95, 90  # of the pairs
LIMIT = "autopilot.law.cross_track_limit_m"


@cache
def flown(seed, factor=1.0):
    """A run; its law's cross-track limit times ``factor``."""
    changed = {}
    if factor != 1.0:
        changed[LIMIT] = factor * sim.prepare(sim.read("an26_turbulence")).law.cross_track_limit
    return sim.run("an26_turbulence", seed=seed, flights=FLIGHTS, workers=2, overrides=changed)


def test_between_seeds_nothing_changes(row):
    """Independent pairs: seeds 1 and 2, 3 and 4, and so on."""
    quiet = sum(not sim.compare(flown(seed), flown(seed + 1)).changed for seed in range(1, 2 * PAIRS, 2))
    row("pairs of seeds without a flagged metric", f">= {QUIET} of {PAIRS}", str(quiet), quiet >= QUIET)
    assert quiet >= QUIET


def test_a_cross_track_limit_changed_by_a_tenth_is_found(row):
    found = sum(bool(sim.compare(flown(seed), flown(seed, 1.1)).changed) for seed in range(1, PAIRS + 1))
    row("cross-track limit changed by 10 %: found", f">= {FOUND} of {PAIRS}", str(found), found >= FOUND)
    assert found >= FOUND
