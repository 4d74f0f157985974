"""Where along one value of a scenario a figure of its flight passes a limit, by bisection."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

from sim.errors import ScenarioError, did_you_mean
from sim.experiment import fly, read
from sim.flight.preparation import prepare
from sim.metrics import table
from sim.metrics.figures import Context
from sim.metrics.flight import value as figure_of
from sim.scenario.plugins import catalogue_with

FAILED = ("diverged", "orbit", "envelope")  # outcomes of flights that are beyond every limit


class FoundLimit(NamedTuple):
    """Two values of the scenario between which the figure passes the limit, and how many flights it took."""

    below: float
    above: float
    flights: int

    @property
    def value(self) -> float:
        """Geometric middle."""
        return math.sqrt(self.below * self.above)


def find_limit(
    source: str | Path | dict[str, Any],
    address: str,
    low: float,
    high: float,
    metric: str,
    limit: float,
    *,
    overrides: dict[str, Any] | None = None,
    plugins: Any = (),
    within: float = 0.01,
) -> FoundLimit:
    """The value of ``address`` (``table.key``, in the spelling of files) above which a metric exceeds a limit.

    Flight 0 is flown at every value. A flight that diverges, orbits or leaves the envelope exceeds every limit.

    Parameters
    ----------
    low, high : positive values between which the limit lies
    metric, limit : a scalar of the flight's metrics, in its own suffix
    plugins : what brings kinds that are not bundled, as in `sim.run`
    within : relative width of the interval that is found

    Raises ``ScenarioError`` when the limit does not lie between the values.
    """
    row = table.find(metric)
    if row is None:
        raise ScenarioError(f"no metric '{metric}'; {did_you_mean(metric, table.names())}")
    if not 0.0 < low < high or not within > 0.0:
        raise ScenarioError(f"a limit is looked for between 0 < low < high, not between {low:g} and {high:g}")

    catalogue = catalogue_with(plugins)

    def exceeds(value: float) -> bool:
        prepared = prepare(read(source, {**(overrides or {}), address: value}, plugins=catalogue))
        flight = fly(prepared)
        figure = figure_of(
            row, flight, Context(prepared.scenario.runway, prepared.law.bank_limit, stall_speed=prepared.stall_speed)
        )
        return flight.outcome in FAILED or (figure is not None and figure > limit)

    if exceeds(low):
        raise ScenarioError(f"{metric} exceeds {limit:g} already at {address} = {low:g}")
    if not exceeds(high):
        raise ScenarioError(f"{metric} does not exceed {limit:g} even at {address} = {high:g}")
    flights = 2
    while high / low - 1.0 > within:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if exceeds(middle) else (middle, high)
        flights += 1
    return FoundLimit(low, high, flights)
