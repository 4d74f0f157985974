"""The captures of many flights, identified one after another, and what is said of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from aircraft.units import preferred
from autopilot.identification import LawFit, Parameter
from autopilot.law_search import NAMES
from sim.errors import ScenarioError
from sim.flight.record import Flight
from sim.studies.identification.captures import identify
from sim.studies.identification.spread import SHARES, Spread, correlations, outlying, spreads

UNITS = {"k1": "rad/m", "k2": "rad/(m/s)", "cross_track_limit": "m", "bank_limit": "rad", "lag": "s"}
KEYS = {name: preferred(name, unit) for name, unit in UNITS.items()}  # spelling of files, and its factor to SI
UNIT_WORDS = {"k1": "deg/m", "k2": "deg/(m/s)", "cross_track_limit": "m", "bank_limit": "deg", "lag": "s"}
LABELS = {name: name.replace("cross_track", "cross-track").replace("_", " ") for name in NAMES}


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


def sentence(found: Survey) -> str:
    """How many captures there are, and how many of them a law explains."""
    flights = len(found.fits) + len(found.refused)
    some = f"{flights} flight{'s' if flights != 1 else ''}"
    if not found.fits:
        return f"{some}, no capture."
    captures = f"{len(found.fits)} capture{'s' if len(found.fits) != 1 else ''}"
    return f"{some}, {captures}: law (4) explains {found.explained} of {len(found.fits)}."


def as_json(found: Survey) -> dict[str, Any]:
    """All of it by names that carry their unit; what is not known is null."""
    return {
        "source": found.source,
        "flights": len(found.fits) + len(found.refused),
        "captures": len(found.fits),
        "explained": found.explained,
        "each": {name: _one(fit, found.spread) for name, fit in found.fits.items()},
        "refused": found.refused,
        "spread": {KEYS[name][0]: _spread(name, one) for name, one in found.spread.items()},
        "rank_correlations": correlations([*found.fits.values()]),
    }


def _one(fit: LawFit, spread: dict[str, Spread]) -> dict[str, Any]:
    return {
        **{KEYS[name][0]: _parameter(name, getattr(fit, name)) for name in NAMES},
        "line_m": {"value": fit.line.value, "sigma": fit.line.sigma},
        "frequency_radps": fit.frequency,
        "damping": fit.damping,
        "cross_track_rms_m": fit.cross_track_rms,
        "bank_rms_deg": math.degrees(fit.bank_rms),
        "explained": fit.explained,
        "why": list(why(fit)),
        "outlier_in": list(outlying(fit, spread)) if fit.explained else [],
    }


def _parameter(name: str, one: Parameter) -> dict[str, Any]:
    return {"value": scaled(name, one.value), "sigma": scaled(name, one.sigma), "met": one.met}


def _spread(name: str, one: Spread) -> dict[str, Any]:
    quantiles = {f"p{100 * share:g}": scaled(name, q) for share, q in zip(SHARES, one.quantiles, strict=True)}
    return {**quantiles, "estimated": one.estimated, "bounds": one.bounds}


def why(fit: LawFit) -> tuple[str, ...]:
    """What keeps a law from explaining the capture, and which of its limits the capture does not show."""
    unmet = [name for name in NAMES if not getattr(fit, name).met]
    least = {name: digits(scaled(name, getattr(fit, name).value)) for name in unmet}
    told = [f"the {LABELS[name]} was never met: no less than {least[name]} {UNIT_WORDS[name]}" for name in unmet]
    return (*fit.objections, *told)


def scaled(name: str, value: float) -> float:
    """A number of the law in the unit of files."""
    return value / KEYS[name][1]


def cells(fit: LawFit) -> list[str]:
    """Value and standard error of each number in the units of files, ">=" before a bound."""
    found = []
    for name in NAMES:
        one = getattr(fit, name)
        error = f" +- {digits(scaled(name, one.sigma), 2)}" if math.isfinite(one.sigma) else ""
        value = digits(scaled(name, one.value))
        found.append(f"{value}{error}" if one.met else f">= {value}")
    return found


def digits(value: float, significant: int = 3) -> str:
    """A number with so many significant digits, without an exponent where it is large."""
    return f"{value:.0f}" if abs(value) >= 10.0 ** (significant - 1) else f"{value:.{significant}g}"
