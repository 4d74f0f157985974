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
    distribution: str  # a key of FORMS
    numbers: tuple[Any, ...]  # as the file gives them

    @property
    def typical(self) -> float:
        """A value among those that are drawn."""
        if self.distribution == "quantiles":
            return float(self.numbers[0][1])
        first, _, *bounds = self.numbers
        return float(np.clip(first, *bounds)) if bounds else float(first)


Axis = Listed | Sampled
FORMS = {
    "uniform": "[low, high]",
    "normal": "[mean, sigma], or [mean, sigma, low, high] where nothing beyond is drawn",
    "quantiles": "[[0, lowest], [share at or below, value], ..., [1, highest]]",
    "latin_hypercube": "[low, high]",
    "sobol": "[low, high]",
}
DISTRIBUTIONS = tuple(FORMS)
STRATIFIED = ("latin_hypercube", "sobol")  # of these the draws of a study are not independent
LEAST_KEPT = 1e-6  # of a normal within its bounds
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
    if kind == "grid":
        return Listed(address, _grid(place, *_counted(place, kind, numbers, (3,))))
    if kind == "quantiles":
        return Sampled(address, kind, _quantiles(place, numbers))
    counts = (2, 4) if kind == "normal" else (2,)
    return Sampled(address, kind, _within_bounds(place, kind, *_counted(place, kind, numbers, counts)))


def _counted(place: str, kind: str, numbers: Any, counts: Sequence[int]) -> tuple[float, ...]:
    """So many finite numbers."""
    if not isinstance(numbers, list | tuple) or len(numbers) not in counts or not all(map(_finite, numbers)):
        wanted = " or ".join(map(str, counts))
        raise ValueError(f"{place}: {kind} needs {wanted} finite numbers: {_forms(kind)}")
    return tuple(map(float, numbers))


def _within_bounds(place: str, kind: str, first: float, second: float, *bounds: float) -> tuple[float, ...]:
    if kind != "normal":
        if not first < second:
            raise ValueError(f"{place}: {kind} needs its low end below its high end, not {first:g} and {second:g}")
        return first, second
    if second < 0:
        raise ValueError(f"{place}: sigma must not be negative, not {second:g}")
    if bounds and not bounds[0] < bounds[1]:
        raise ValueError(f"{place}: normal needs its low end below its high end, not {bounds[0]:g} and {bounds[1]:g}")
    if bounds and (second == 0 or np.diff(_shares(first, second, bounds))[0] < LEAST_KEPT):
        raise ValueError(f"{place}: almost nothing of this normal lies within {bounds[0]:g} and {bounds[1]:g}")
    return (first, second, *bounds)


def _shares(mean: float, sigma: float, bounds: Sequence[float]) -> Any:
    """Shares of a normal at or below its bounds."""
    from scipy.special import ndtr

    return ndtr((np.array(bounds) - mean) / sigma)


def _quantiles(place: str, given: Any) -> tuple[tuple[float, float], ...]:
    """Points of a cumulative distribution, between which it is straight."""
    pairs = given if isinstance(given, list | tuple) else ()
    if len(pairs) < 2 or not all(isinstance(one, list | tuple) and len(one) == 2 for one in pairs):
        raise ValueError(f"{place}: quantiles needs two or more pairs of a share and a value: {_forms('quantiles')}")
    if not all(_finite(number) for one in pairs for number in one):
        raise ValueError(f"{place}: quantiles needs finite numbers: {_forms('quantiles')}")
    points = tuple((float(share), float(value)) for share, value in pairs)
    shares, values = zip(*points, strict=True)
    if shares[0] != 0.0 or shares[-1] != 1.0 or not all(a < b for a, b in itertools.pairwise(shares)):
        raise ValueError(f"{place}: the shares of quantiles rise from 0 to 1")
    if not all(a <= b for a, b in itertools.pairwise(values)):
        raise ValueError(f"{place}: the values of quantiles must not fall as their shares rise")
    return points


def _grid(place: str, low: float, high: float, count: float) -> tuple[float, ...]:
    if count != int(count) or not 1 <= count <= LARGEST_GRID:
        raise ValueError(f"{place}: a grid has 1 to {LARGEST_GRID} values, not {count:g}")
    if count > 1 and low == high:
        raise ValueError(f"{place}: a grid needs two different ends")
    return tuple(float(value) for value in np.linspace(low, high, int(count)))


def _finite(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < LARGEST_NUMBER


def _forms(only: str | None = None) -> str:
    forms = {kind: f"{{ {kind} = {form} }}" for kind, form in {"grid": "[low, high, count]", **FORMS}.items()}
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
        units = _stratified(kind, len(chosen), count, seed) if kind in STRATIFIED else None
        for number, one in enumerate(chosen):
            generator = stream(seed, 0, 0, f"study.{one.address}")
            columns[one.address] = _drawn(one, generator, count) if units is None else _spanned(one, units[number])
    return tuple({address: float(column[i]) for address, column in columns.items()} for i in range(count))


def _drawn(axis: Sampled, generator: np.random.Generator, count: int) -> Any:
    """Independent draws of one axis."""
    if axis.distribution == "normal":
        mean, sigma, *bounds = axis.numbers
        if not bounds:
            return mean + sigma * generator.standard_normal(count)
        from scipy.special import ndtri

        low, high = _shares(mean, sigma, bounds)
        return np.clip(mean + sigma * ndtri(low + (high - low) * generator.random(count)), *bounds)
    if axis.distribution == "quantiles":
        shares, values = zip(*axis.numbers, strict=True)
        return np.interp(generator.random(count), shares, values)
    return _spanned(axis, generator.random(count))


def _spanned(axis: Sampled, unit: Any) -> Any:
    """Values between the ends of an axis, of numbers on 0..1."""
    low, high = axis.numbers
    return low + (high - low) * unit


def _stratified(kind: str, dimensions: int, count: int, seed: int) -> Any:
    """Points that fill the unit cube evenly, (dimensions, count)."""
    if not dimensions:
        return ()
    from scipy.stats import qmc

    engine = qmc.Sobol if kind == "sobol" else qmc.LatinHypercube
    return engine(dimensions, rng=stream(seed, 0, 0, f"study.{kind}")).random(count).T
