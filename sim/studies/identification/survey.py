"""The captures of many flights, identified one after another, and what is said of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from aircraft.units import preferred
from autopilot.identification import NAMES, LawFit, Parameter
from sim.errors import ScenarioError
from sim.flight.record import Flight
from sim.studies.identification.captures import identify
from sim.studies.identification.spread import SHARES, Spread, correlations, outlying, spreads

UNITS = {"k1": "rad/m", "k2": "rad/(m/s)", "cross_track_limit": "m", "bank_limit": "rad", "lag": "s"}
KEYS = {name: preferred(name, unit) for name, unit in UNITS.items()}  # spelling of files, and its factor to SI


class Survey(NamedTuple):
    """What was found in a file of recordings or in a run."""

    source: str
    fits: dict[str, LawFit]  # by the name of the flight
    refused: dict[str, str]  # flights without a capture, and why
    spread: dict[str, Spread]  # of each number, over the captures that are explained

    @property
    def explained(self) -> int:
        """Captures that a law explains."""
        return sum(fit.explained for fit in self.fits.values())


def survey(
    source: str, flights: Mapping[str, Flight], leg: int | None = None, progress: Callable[..., Any] | None = None
) -> Survey:
    """Identify the capture of a leg in each flight; a flight without one is told, not skipped."""
    fits: dict[str, LawFit] = {}
    refused: dict[str, str] = {}
    items: Iterable[tuple[str, Flight]] = flights.items()
    for name, flight in progress(items, len(flights), "captures") if progress is not None else items:
        try:
            fits[name] = identify(flight, leg)
        except ScenarioError as error:
            refused[name] = str(error).removeprefix("identify: ")
    return Survey(source, fits, refused, spreads([*fits.values()]))


def as_json(found: Survey) -> dict[str, Any]:
    """All of it by names that carry their unit; what is not known is null."""
    return {
        "source": found.source,
        "flights": len(found.fits) + len(found.refused),
        "captures": len(found.fits),
        "explained": found.explained,
        "each": {name: _one(fit, found.spread) for name, fit in found.fits.items()},
        "refused": found.refused,
        "spread": {KEYS[name][0]: _spread(one, KEYS[name][1]) for name, one in found.spread.items()},
        "rank_correlations": correlations([*found.fits.values()]),
    }


def _one(fit: LawFit, spread: dict[str, Spread]) -> dict[str, Any]:
    numbers = {KEYS[name][0]: _parameter(getattr(fit, name), KEYS[name][1]) for name in NAMES}
    return {
        **numbers,
        "frequency_radps": fit.frequency,
        "damping": fit.damping,
        "cross_track_rms_m": fit.cross_track_rms,
        "bank_rms_deg": math.degrees(fit.bank_rms),
        "explained": fit.explained,
        "why": list(why(fit)),
        "outlier_in": list(outlying(fit, spread)) if fit.explained else [],
    }


def _parameter(one: Parameter, factor: float) -> dict[str, Any]:
    return {"value": one.value / factor, "sigma": one.sigma / factor, "met": one.met}


def _spread(one: Spread, factor: float) -> dict[str, Any]:
    quantiles = {f"p{100 * share:g}": value / factor for share, value in zip(SHARES, one.quantiles, strict=True)}
    return {**quantiles, "estimated": one.estimated, "bounds": one.bounds}


def why(fit: LawFit) -> tuple[str, ...]:
    """What keeps a law from explaining the capture, and which of its limits the capture does not show."""
    told = [*fit.objections]
    for name, word in (("cross_track_limit", "cross-track limit"), ("bank_limit", "bank limit")):
        if not getattr(fit, name).met:
            told.append(f"the {word} was never met: no less than {number(fit, name)}")
    return tuple(told)


def number(fit: LawFit, name: str) -> str:
    """One number of a law with its unit, as pages print it."""
    factor = KEYS[name][1]
    unit = {"k1": "deg/m", "k2": "deg/(m/s)", "cross_track_limit": "m", "bank_limit": "deg", "lag": "s"}[name]
    return f"{getattr(fit, name).value / factor:.3g} {unit}"


def cells(fit: LawFit) -> list[str]:
    """Value and standard error of each number in the units of files, "> " before a bound."""
    found = []
    for name in NAMES:
        one, factor = getattr(fit, name), KEYS[name][1]
        digits = f"{one.value / factor:.3g}"
        found.append(f"{digits} +- {one.sigma / factor:.2g}" if one.met else f">= {digits}")
    return found
