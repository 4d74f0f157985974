"""Equivalent airspeeds of a scenario against stall and placards: which of its speeds is which, and what is beyond."""

from __future__ import annotations

import math

from aircraft.data import AircraftData
from autopilot.approach import Approach
from autopilot.design import SCHEDULED, Designed
from autopilot.landing import REFERENCE_MARGIN
from sim.scenario.model import Scenario

MANOEUVRE_MARGIN = 1.4  # of the speed of a leg over the stall: the least flaps that keep it are set
REFERENCE_ADDITION = 2.5  # m/s over the reference speed, at least
NEGLECTED = 0.005  # of an airspeed: what an indicator may show more than the equivalent one without a word


def level_speeds(scenario: Scenario) -> list[tuple[str, float, float]]:
    """(where, true, equivalent) airspeed of everything flown before a glide path, m/s, in the order of the route."""
    share = scenario.air.equivalent_share
    return [(where, speed, speed * share(height)) for where, speed, height in scenario.route.levels]


def extremes(scenario: Scenario) -> tuple[float, float]:
    """The slowest and the fastest true airspeed before a glide path, m/s."""
    speeds = [speed for _, speed, _ in scenario.route.levels]
    return min(speeds), max(speeds)


def least_approach_speed(aircraft: AircraftData, flaps: float, mass: float) -> float:
    """Equivalent airspeed, m/s, below which the recipe lets no approach be flown."""
    return REFERENCE_MARGIN * aircraft.stall_speed(flaps, mass) + REFERENCE_ADDITION


def landing_stall_speed(scenario: Scenario, aircraft: AircraftData, approach: Approach) -> float | None:
    """Stall speed, m/s equivalent, at the flaps and the mass of the landing; None without a landing or a known one."""
    if approach.landing is None or not aircraft.flap_settings:
        return None
    return aircraft.stall_speed(approach.landing.flaps, scenario.aircraft.mass or aircraft.reference_mass)


def remarks(scenario: Scenario, approach: Approach, aircraft: AircraftData, gains: Designed) -> list[str]:
    """One sentence for each speed that was raised, each margin that is broken and each placard that is exceeded."""
    speeds = level_speeds(scenario)
    told = _beyond_the_model(scenario, speeds)
    if not aircraft.flap_settings:
        return told
    mass, landing = scenario.aircraft.mass or aircraft.reference_mass, approach.landing
    stall = aircraft.stall_speed(approach.flaps, mass)
    told += [
        f"{where} at {equivalent:.1f} m/s equivalent ({true:.1f} true) is {equivalent / stall:.2f} of the stall speed, "
        f"below {MANOEUVRE_MARGIN}"
        for where, true, equivalent in speeds
        if equivalent < (1.0 - 1e-9) * MANOEUVRE_MARGIN * stall
    ]
    told += _above_placard(aircraft, approach.flaps, max(equivalent for _, _, equivalent in speeds))
    asked = scenario.route.approach_speed
    if landing is None or asked is None:
        return told
    flown, share = landing.approach_speed, scenario.air.equivalent_share(scenario.route.levels[-1][2])
    if flown > asked:
        told.append(
            f"the approach speed was raised from {asked:.1f} to {flown:.1f} m/s true, from {share * asked:.1f} to "
            f"{share * flown:.1f} m/s equivalent: {REFERENCE_MARGIN} of the stall speed and {REFERENCE_ADDITION} m/s"
        )
    power = _level_power(gains, share * flown)
    if power > 1.0:
        told.append(
            f"level flight with flaps at {math.degrees(landing.flaps):.0f} deg and gear out would take {power:.2f} of "
            "full power at the approach speed: so it is flown on the glide path only"
        )
    entry = speeds[-1][2]
    told += _above_placard(aircraft, landing.flaps, entry) if landing.flaps != approach.flaps else []
    if entry > aircraft.gear_placard_speed:
        told.append(f"{entry:.1f} m/s equivalent is above {aircraft.gear_placard_speed:.1f} m/s, the limit of the gear")
    return told


def _level_power(gains: Designed, equivalent: float) -> float:
    """Power lever of level flight as the aircraft lands; beyond 1 by the linear model of the descent."""
    if not gains.schedules:
        return 0.0
    lever, last = SCHEDULED.index("throttle"), gains.schedules[-1]
    return last.constant[lever] + last.slope[lever] / equivalent**2


def _above_placard(aircraft: AircraftData, flaps: float, speed: float) -> list[str]:
    setting = aircraft.setting(flaps)
    if not speed > setting.placard_speed:
        return []
    limit = f"the limit of flaps at {math.degrees(setting.flaps):.0f} deg"
    return [f"{speed:.1f} m/s equivalent is above {setting.placard_speed:.1f} m/s, {limit} ({aircraft.title})"]


def _beyond_the_model(scenario: Scenario, speeds: list[tuple[str, float, float]]) -> list[str]:
    """Where indicated airspeeds are not equivalent ones any more."""
    height = max(height for _, _, height in scenario.route.levels)
    fastest = max(true for _, true, _ in speeds)
    more = float(scenario.air.compressibility(fastest, height))
    if more < NEGLECTED:
        return []
    return [
        f"at {fastest:.0f} m/s an indicator shows {100.0 * more:.1f} % more than the equivalent airspeed, for which "
        "indicated speeds are taken here: the compressibility of the air is left out"
    ]
