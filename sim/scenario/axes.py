"""Axes of a study: what is varied, over which values, and how values are drawn.

Lists and grids are choices: every combination of them is a cell. Distributions are what nobody chooses (a mass, a wind,
an aerodynamic factor): every cell flies the same samples of them, so that cells are compared on common ground.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.errors import did_you_mean
from sim.randomness import stream

LARGEST_GRID = 10_000  # values of one axis
LARGEST_NUMBER = 1e300  # an integer beyond is none that a float can hold


class Listed(NamedTuple):
    """An axis of chosen values."""

    address: str  # table.key in the spelling of files
    values: tuple[Any, ...]


class Sampled(NamedTuple):
    """An axis of drawn values."""

    address: str
    distribution: str  # uniform, latin_hypercube, sobol: within (first, second); normal: mean first, sigma second
    first: float
    second: float


Axis = Listed | Sampled
DISTRIBUTIONS = ("uniform", "normal", "latin_hypercube", "sobol")
FIXED = ("name", "seed", "flights", "draws", "designed", "contrasts", "checks", "study")  # of a whole study; no axis


def axis(address: str, given: Any) -> Axis:
    """The axis that a file describes; raises ``ValueError`` with one sentence."""
    place = f'axes "{address}"'
    head = address.partition(".")[0]
    if head in FIXED:
        where = " (write it in [study])" if address == "samples" else ""
        raise ValueError(f"{place}: '{head}' belongs to the whole study and is no axis{where}")
    if isinstance(given, list | tuple):
        if not given:
            raise ValueError(f"{place}: the list is empty; give at least one value")
        return Listed(address, tuple(given))
    if not isinstance(given, Mapping) or len(given) != 1:
        raise ValueError(f"{place}: write a list of values, or one of {_forms()}")
    (kind, numbers), *_ = given.items()
    if kind not in ("grid", *DISTRIBUTIONS):
        raise ValueError(f"{place}: no form '{kind}'; {did_you_mean(kind, ('grid', *DISTRIBUTIONS))}")
    wanted = 3 if kind == "grid" else 2
    if not isinstance(numbers, list | tuple) or len(numbers) != wanted or not all(map(_finite, numbers)):
        raise ValueError(f"{place}: {kind} needs {wanted} finite numbers: {_forms(kind)}")
    if kind == "grid":
        return Listed(address, _grid(place, *numbers))
    first, second = map(float, numbers)
    if kind == "normal" and second < 0:
        raise ValueError(f"{place}: sigma must not be negative, not {second:g}")
    if kind != "normal" and not first < second:
        raise ValueError(f"{place}: {kind} needs its low end below its high end, not {first:g} and {second:g}")
    return Sampled(address, kind, first, second)


def _grid(place: str, low: float, high: float, count: float) -> tuple[float, ...]:
    if count != int(count) or not 1 <= count <= LARGEST_GRID:
        raise ValueError(f"{place}: a grid has 1 to {LARGEST_GRID} values, not {count:g}")
    if count > 1 and low == high:
        raise ValueError(f"{place}: a grid needs two different ends")
    return tuple(float(value) for value in np.linspace(low, high, int(count)))


def _finite(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < LARGEST_NUMBER


def _forms(only: str | None = None) -> str:
    forms = {"grid": "{ grid = [low, high, count] }", "normal": "{ normal = [mean, sigma] }"}
    forms |= {kind: f"{{ {kind} = [low, high] }}" for kind in DISTRIBUTIONS if kind != "normal"}
    return forms[only] if only else ", ".join(forms.values())


def cells(axes: Sequence[Axis]) -> tuple[dict[str, Any], ...]:
    """Every combination of the listed axes, the last axis running fastest; one empty cell without any."""
    listed = [one for one in axes if isinstance(one, Listed)]
    return tuple(
        dict(zip([one.address for one in listed], values, strict=True))
        for values in itertools.product(*(one.values for one in listed))
    )


def samples(axes: Sequence[Axis], count: int, seed: int) -> tuple[dict[str, float], ...]:
    """``count`` joint draws of the sampled axes; each stratified kind fills the cube of all axes of its kind."""
    columns: dict[str, Any] = {}
    for kind in DISTRIBUTIONS:
        chosen = [one for one in axes if isinstance(one, Sampled) and one.distribution == kind]
        for one, unit in zip(chosen, _unit(kind, chosen, count, seed), strict=True):
            columns[one.address] = (
                one.first + one.second * unit if kind == "normal" else one.first + (one.second - one.first) * unit
            )
    return tuple({address: float(column[i]) for address, column in columns.items()} for i in range(count))


def _unit(kind: str, chosen: list[Sampled], count: int, seed: int) -> Any:
    """Draws of each axis: standard normal, or uniform on 0..1."""
    if kind in ("uniform", "normal"):
        streams = [stream(seed, 0, 0, f"study.{one.address}") for one in chosen]
        return [g.standard_normal(count) if kind == "normal" else g.random(count) for g in streams]
    if not chosen:
        return []
    from scipy.stats import qmc

    engine = qmc.Sobol if kind == "sobol" else qmc.LatinHypercube
    return engine(len(chosen), rng=stream(seed, 0, 0, f"study.{kind}")).random(count).T
