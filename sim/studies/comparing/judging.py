"""Whether two sides differ beyond noise, and in which metrics: all metrics together, by arrangements of their flights.

Each metric has a probability of its own: Student's of its paired differences, or Welch's, or Agresti and Caffo's for
answers. What they come to together where nothing has changed depends on how the metrics hang together, which nobody
knows; but every arrangement of the flights (``arrangements``) shows it. Two combinations of the probabilities p are
judged against what arrangements make of them, which is exact whatever the metrics are distributed like:

- the sum of 1 / sqrt(p) says *whether* anything has changed. It is a generalised mean of p [Vovk and Wang, Biometrika
  107, 2020] between their harmonic mean, which sees one great change, and their geometric mean (Fisher), which sees
  many small ones;
- the least p says *which* metrics have [Westfall and Young, Resampling-based Multiple Testing, 1993]. None is named
  unless the sum says that something has changed.

Both err with ``ERROR``, so that of two sides that differ in nothing but chance any metric is named with no more than
that. It is a fortieth: of a hundred such comparisons five or fewer show a change, nineteen times of twenty.

Where so few flights have no arrangement that is rare enough (six pairs, four flights of each), the metrics are taken
for normal, and Bonferroni's inequality stands for the arrangements.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from sim.studies.comparing import arrangements
from sim.studies.comparing.evidence import Evidence, of_answers, of_pairs, of_sides
from sim.studies.comparing.spans import Span, span

ERROR = 0.025
EQUAL = 1e-9  # relative, of what two arrangements make of the same numbers

Key = TypeVar("Key")
Columns = tuple[np.ndarray, np.ndarray]  # a metric of the flights of A and of B; NaN where a flight does not have it


class Judgement(NamedTuple, Generic[Key]):
    """What was found."""

    spans: dict[Key, Span]
    probability: float  # of sides that differ so much where nothing has changed
    arrangements: int  # that it was counted over; 1 = Bonferroni


def judge(columns: Mapping[Key, Columns], flights: tuple[int, int], paired: bool) -> Judgement[Key]:
    """Judge all metrics together.

    Parameters
    ----------
    columns : by metric; each has at least one flight of A and one of B, of pairs at least one pair
    flights : how many there are of A and of B; where ``paired``, number k of both has the same noise
    """
    rare = _least(*flights, paired) <= ERROR
    sides = _sides(*flights, paired)[: None if rare else 1]
    found, told, least, total = {}, {}, np.ones(len(sides)), np.zeros(len(sides))
    for key, (a, b) in columns.items():
        evidence = _evidence(sides, a, b, paired)
        told[key] = p = evidence.probability
        found[key] = Evidence(*(part[:1] for part in evidence))
        said = _said(a, b, paired)
        if rare and _least(*said, paired) > ERROR:  # so few that their own arrangements are often extreme
            found[key] = found[key]._replace(variance=np.array([np.nan]))
            continue
        least, total = np.minimum(least, p), total + 1.0 / np.sqrt(p)
    judged = sum(not np.isnan(one.variance[0]) for one in found.values())
    if rare:
        error = np.sort(least)[int(ERROR * len(sides) * (1.0 + EQUAL))] * (1.0 - EQUAL)
        probability = float(np.mean(total >= total[0] * (1.0 - EQUAL)))
    else:
        error, probability = ERROR / max(1, judged), min(1.0, judged * float(least[0]))
    if probability > ERROR:
        error = min(error, (1.0 - EQUAL) * least[0])  # nothing has changed, so that no interval may leave out 0
    adjusted = {
        key: float(np.mean(least <= p[0] * (1.0 + EQUAL))) if rare else min(1.0, judged * float(p[0]))
        for key, p in told.items()
    }
    spans = {key: span(one, float(error), adjusted[key]) for key, one in found.items()}
    return Judgement(spans, probability, len(sides))


def _evidence(sides: np.ndarray, a: np.ndarray, b: np.ndarray, paired: bool) -> Evidence:
    values = np.concatenate((a, b))
    if set(values[~np.isnan(values)]) <= {0.0, 1.0}:
        return of_answers(sides, values)
    if not paired:
        return of_sides(sides, values)
    both = ~np.isnan(a) & ~np.isnan(b)
    return of_pairs(sides[:, len(a) :][:, both], a[both], b[both])


def _said(a: np.ndarray, b: np.ndarray, paired: bool) -> tuple[int, int]:
    """How many flights of each side have a metric, of pairs both."""
    here, there = ~np.isnan(a), ~np.isnan(b)
    return (int(np.sum(here & there)),) * 2 if paired else (int(np.sum(here)), int(np.sum(there)))


def _sides(a: int, b: int, paired: bool) -> np.ndarray:
    return arrangements.of_pairs(a) if paired else arrangements.of_sides(a, b)


def _least(a: int, b: int, paired: bool) -> float:
    return arrangements.least_of_pairs(a) if paired else arrangements.least_of_sides(a, b)
