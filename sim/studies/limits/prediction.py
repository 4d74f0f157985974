"""What theory says of the cells of a limit study before they are flown: the captures of its scenario."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from aircraft.units import SUFFIXES
from autopilot.mode import DesignCase
from autopilot.modes.lateral_navigation import LateralNavigation
from sim.estimation.prior import PRIOR_POSITION, PRIOR_RATE
from sim.scenario.model import Scenario, TrackerChoice
from sim.scenario.parameters import given_values
from sim.scenario.tables import LegsTable
from sim.studies.limits.capture import Capture, Filters, capture, contact

Array = Any
OFFSET, BANK = "start.cross_track_m", "autopilot.bank_limit_deg"
CROSS_TRACK, RATE = "autopilot.law.cross_track_limit_m", "autopilot.law.cross_track_rate_limit_mps"
AT_LIMITS = "at_limits_s"  # how long any limit acts
ADDRESSES = (OFFSET, BANK, CROSS_TRACK, RATE)
CASES = (  # two designs that share nothing: what is the same in both is fixed
    DesignCase(0.2, 1.0, 50.0, k1=1e-3, k2=1e-2, cross_track_limit=300.0),
    DesignCase(0.3, 3.0, 90.0, k1=7e-3, k2=9e-2, cross_track_limit=900.0),
)


class Prediction(NamedTuple):
    """Theory of some cells, one value for each."""

    contact: Array  # how far the capture without limits would go, over the first limit; above 1 one acts
    at_limits: Array  # s, during which any limit acts
    ratio: Array | None  # of the first contrast, across the track; None where theory has none


def needs(scenario: Scenario) -> str:
    """What the theory of limits lacks in a scenario; "" where it has all."""
    if not isinstance(scenario.route, LegsTable) or len(scenario.route.legs) != 1:
        return 'a route of one leg, [route] kind = "legs"'
    try:
        laws = _laws(scenario)
    except ValueError:
        return ""  # faults of its own numbers are reported when it is designed
    if laws is None:
        return f"a law of the cross-track and its rate, such as 'lateral_navigation', not '{scenario.mode}'"
    one, other = laws
    chosen = {axis.address for axis in scenario.study.varied} if scenario.study else set()
    open_ = [name for name in ("k1", "k2") if getattr(one, name) != getattr(other, name)]
    open_ += (
        ["cross_track_limit"] if one.cross_track_limit != other.cross_track_limit and CROSS_TRACK not in chosen else []
    )
    if open_ or scenario.autopilot.frequency_share is not None or scenario.autopilot.estimate_lag > 0.0:
        return "one law in all cells: k1, k2 and cross_track_limit in [autopilot.law]"
    wind = scenario.wind
    if wind.strength > 0.0 or wind.intensity > 0.0 or wind.events:
        return "still air, without [wind]"
    if scenario.departures or scenario.autopilot.navigation != "truth":
        return "a law that is flown all the time, on the truth"
    return ""


def stranger(addresses: Sequence[str]) -> str:
    """The first axis that the theory of limits does not know, "" = none."""
    return next((address for address in addresses if address not in ADDRESSES), "")


def predict(scenario: Scenario, values: Mapping[str, Array]) -> Prediction:
    """Theory of cells whose axes have ``values``, in the units of their addresses, arrays that broadcast."""
    assert isinstance(scenario.route, LegsTable)
    given = dict(zip(values, np.broadcast_arrays(*values.values()), strict=True)) if values else {}
    bank = _si(given, BANK, scenario.autopilot.bank_limit)
    offset = np.abs(_si(given, OFFSET, scenario.start.cross_track))
    fixed, _ = _laws(scenario) or CASES
    limits = {"cross_track_limit": CROSS_TRACK, "cross_track_rate_limit": RATE}
    told = {name: _si(given, address, math.nan) for name, address in limits.items() if address in given}
    case = DesignCase(bank, 1.0, 50.0, fixed.k1, fixed.k2, fixed.cross_track_limit)
    law = scenario.modes[scenario.mode].designed({**scenario.law, **told}, case)
    flown = LateralNavigation.of(law)
    assert flown is not None
    (leg,) = scenario.route.legs
    length = math.dist(leg.from_, leg.to) if scenario.start.distance is None else scenario.start.distance
    speed = leg.speed if scenario.start.speed is None else scenario.start.speed
    seconds = min(math.inf if scenario.until is None else scenario.until, length / speed)
    filters, inverse = _filters(scenario)
    found: Capture = capture(flown, offset, speed, seconds, filters)
    ratio = found.ratio if found.ratio is None or not inverse else 1.0 / found.ratio
    return Prediction(np.broadcast_to(contact(flown, offset, seconds), offset.shape), found.at_limits, ratio)


def cell_figures(scenario: Scenario, cells: Sequence[Mapping[str, Any]]) -> dict[str, list[float | None]]:
    """Theory of cells by the names of metrics.json, a column for each figure."""
    found = predict(scenario, {address: np.array([float(cell[address]) for cell in cells]) for address in cells[0]})
    columns: dict[str, list[float | None]] = {AT_LIMITS: found.at_limits.tolist()}
    if found.ratio is not None:
        columns[f"contrasts.{scenario.contrasts[0].pair}.overall.cross_track_m.ratio"] = found.ratio.tolist()
    return columns


def _laws(scenario: Scenario) -> tuple[LateralNavigation, LateralNavigation] | None:
    """The law by two designs; what the file sets is the same in both. None = it is no such law."""
    one, other = (LateralNavigation.of(scenario.modes[scenario.mode].designed(scenario.law, case)) for case in CASES)
    return None if one is None or other is None else (one, other)


def _si(given: Mapping[str, Array], address: str, otherwise: float) -> Array:
    """The values of an axis in SI, or what the scenario has."""
    if address not in given:
        shape = next((np.shape(value) for value in given.values()), ())
        return np.full(shape, otherwise)
    suffix = max((one for one in SUFFIXES if address.endswith(f"_{one}")), key=len)
    return np.asarray(given[address], float) * SUFFIXES[suffix][1]


def _filters(scenario: Scenario) -> tuple[Filters | None, bool]:
    """What both filters of the first contrast are given, and whether it is saturated over linear.

    None where they are not the two of the theory under the law that flies, on one radar of positions: then theory
    has no ratio. Both say their density, because what is not said is the best that was found, not the paper's.
    """
    if not scenario.contrasts:
        return None, False
    first = scenario.contrasts[0]
    both = scenario.trackers[first.of], scenario.trackers[first.against]
    kinds = [choice.kind for choice in both]
    if sorted(kinds) != ["linear_feedback", "saturated_control"]:
        return None, False
    densities = {choice.kind: _density(choice) for choice in both}
    sensors = {choice.sensors for choice in both}
    name, *more = both[0].sensors
    if len(sensors) > 1 or more or scenario.tables["sensors"][name]["kind"] != "surveillance_radar":
        return None, False
    radar, linear, saturated = scenario.sensors[name], densities["linear_feedback"], densities["saturated_control"]
    if radar.position_sigma is None or linear is None or saturated is None:
        return None, False
    filters = Filters(radar.period, radar.position_sigma, (PRIOR_POSITION, PRIOR_RATE), linear, saturated)
    return filters, kinds[0] == "saturated_control"


def _density(choice: TrackerChoice) -> float | None:
    """m2/s3, of a filter as published; None where it is another one."""
    given = given_values(choice.cls, choice.table)
    plain = not choice.law and choice.association is None and choice.handover is None
    return given.get("acceleration_density") if plain and given.get("covariance", "paper") == "paper" else None
