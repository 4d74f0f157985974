"""The law of a scenario: what it is designed for, and what the file sets of it."""

from __future__ import annotations

import math

from autopilot.design import Designed, law_of_frequency, pull
from autopilot.mode import DesignCase, Mode
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route import Route
from sim.flight.airspeeds import extremes
from sim.scenario.model import Scenario
from sim.scenario.plugins import is_outside, said


def design_case(scenario: Scenario, gains: Designed, route: Route) -> DesignCase:
    """What a law is designed for: the route law of the design, or that of the frequency which the file sets."""
    pilot, (_, speed) = scenario.autopilot, extremes(scenario)
    bank_limit, share = pilot.bank_limit, pilot.frequency_share
    frequency = None if share is None else share * gains.bank_bandwidth
    base = gains.law if frequency is None else law_of_frequency(frequency, speed, bank_limit, gains.turning)
    if pilot.damping is None and pilot.intercept_speed is None:  # the other modes are designed as they always are
        return DesignCase(bank_limit, gains.bank_bandwidth, speed, base.k1, base.k2, base.cross_track_limit)
    k1 = scenario.law.get("k1", base.k1)
    k2 = scenario.law.get(
        "k2", base.k2 if pilot.damping is None else 2.0 * pilot.damping * math.sqrt(k1 / pull(gains.turning))
    )
    limit = base.cross_track_limit if pilot.intercept_speed is None else pilot.intercept_speed * k2 / k1
    return DesignCase(bank_limit, gains.bank_bandwidth, speed, k1, k2, limit)


def law_of(scenario: Scenario, case: DesignCase) -> Mode:
    """The law of the design with what the file sets of it."""
    mode: type[Mode] = scenario.modes[scenario.mode]
    try:
        law = mode.designed(scenario.law, case)
        _ = law.explain(), law.limits()  # what reports will ask: a part that fails there is told before it flies
    except Exception as error:
        if not is_outside(mode) or isinstance(error, ValueError):
            raise
        raise ValueError(f"kind '{scenario.mode}' cannot be designed: {said(error)}") from None
    flown = LateralNavigation.of(law)
    if scenario.autopilot.frequency_share is not None and (
        {"k1", "k2"} & {*scenario.law} or flown is None or (flown.k1, flown.k2) != (case.k1, case.k2)
    ):
        raise ValueError("'frequency_share' sets k1 and k2 of the route law: leave them out, or leave it out")
    for key, field, name in (("damping", "k2", "k2"), ("intercept_speed", "cross_track_limit", "z_max")):
        if getattr(scenario.autopilot, key) is not None and (field in scenario.law or flown is None):
            raise ValueError(f"'{key}' sets {name} of the route law: leave one of them out")
    return law
