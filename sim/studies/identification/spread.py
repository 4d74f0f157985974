"""What many captures say together: quantiles of each number of the law, with bounds taken for what they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from autopilot.identification import LawFit, Parameter
from autopilot.law_search import NAMES

SHARES = (0.05, 0.25, 0.5, 0.75, 0.95)
FEWEST = 5  # captures, of which quantiles are said
OUTLYING = 1.5  # times the middle half beyond it, and an estimate lies apart (Tukey)


class Spread(NamedTuple):
    """The distribution of one number over captures, SI."""

    quantiles: tuple[float, ...]  # at `SHARES`; NaN beyond what bounds let be known
    lowest: float
    highest: float
    estimated: int  # captures that give a value
    bounds: int  # captures that give only a bound


def spread_of(parameters: Sequence[Parameter]) -> Spread:
    """Quantiles of estimates and lower bounds together.

    A limit that never acted lies somewhere above its bound. Leaving it out would make limits too small, and taking the
    bound for the value as well; Kaplan and Meier's estimate of the distribution does neither. Where the largest numbers
    are bounds, the upper quantiles are not known.
    """
    values = np.array([one.value for one in parameters])
    known = np.array([one.met for one in parameters], bool)
    order = np.lexsort((~known, values))  # a bound counts as beyond an equal value
    values, known = values[order], known[order]
    above = np.arange(len(values), 0, -1)  # captures at or beyond each number
    share = 1.0 - np.cumprod(np.where(known, 1.0 - 1.0 / above, 1.0))  # at or below
    found = values[known]
    quantiles = [_quantile(found, share[known], wanted) for wanted in SHARES]
    ends = (float(found[0]), float(found[-1])) if len(found) else (math.nan, math.nan)
    return Spread(tuple(quantiles), *ends, len(found), int((~known).sum()))


def _quantile(values: Any, share: Any, wanted: float) -> float:
    """Between the middles of the steps of a distribution; NaN where it does not rise so far."""
    if not len(values) or wanted > share[-1] + 1e-12:
        return math.nan
    middles = 0.5 * (share + np.r_[0.0, share[:-1]])
    return float(np.interp(wanted, middles, values))


def spreads(fits: Sequence[LawFit]) -> dict[str, Spread]:
    """Of each number of the law over the captures that a law explains."""
    explained = [fit for fit in fits if fit.explained]
    return {name: spread_of([getattr(fit, name) for fit in explained]) for name in NAMES}


def outlying(fit: LawFit, of: dict[str, Spread]) -> tuple[str, ...]:
    """Numbers of a capture that lie apart from those of the others (beyond Tukey's fences on a logarithmic scale)."""
    found = []
    for name, spread in of.items():
        low, high = (math.log(value) for value in (spread.quantiles[1], spread.quantiles[3]))
        room = OUTLYING * (high - low)
        if spread.estimated >= FEWEST and not low - room <= math.log(getattr(fit, name).value) <= high + room:
            found.append(name)
    return tuple(found)


def correlations(fits: Sequence[LawFit]) -> dict[str, float]:
    """Spearman's rank correlation of each pair of numbers over the captures in which both are known."""
    from scipy.stats import spearmanr

    explained = [fit for fit in fits if fit.explained]
    found = {}
    for i, one in enumerate(NAMES):
        for other in NAMES[i + 1 :]:
            pairs = [(getattr(fit, one), getattr(fit, other)) for fit in explained]
            both = np.array([(a.value, b.value) for a, b in pairs if a.met and b.met])
            if len(both) >= FEWEST and (np.ptp(both, axis=0) > 0.0).all():
                found[f"{one}, {other}"] = float(spearmanr(both[:, 0], both[:, 1]).statistic)
    return found
