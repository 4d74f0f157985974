"""Wind shear: the F-factor of a flight or a path, and the aircraft's reserve of climb against it."""

from __future__ import annotations

import math

import numpy as np

from aircraft.errors import TrimError
from aircraft.state import STANDARD_GRAVITY
from aircraft.trim import trim
from aircraft.wind_event import WindEvent
from sim.flight.preparation import MODEL_TIME_LIMIT, Prepared
from sim.flight.record import Flight
from sim.flight.weather import kind_in_words
from sim.scenario.tables import Runway
from sim.workers.isolation import run_isolated

AVERAGED = 1000.0  # m of flight through the air; shorter shears pass before they cost energy
STEP = 20.0  # m, between two looks at a path
STEEPEST = math.radians(20.0)
TOLERANCE = 5e-4  # rad, of the steepest climb


def f_factor(flight: Flight) -> np.ndarray:
    """(k,) rate of climb over airspeed that the air takes away: F = W' . v / g - w / V [Bowles 1990, AIAA-90-0568].

    The energy height h + V^2 / 2g through the air changes by V ((thrust - drag) / weight - F) a second. W' is the rate
    of the horizontal wind met, v the direction of flight through the air, w the wind upwards, V the airspeed.
    """
    north, east, up = flight.wind
    air_north, air_east, _ = flight.state.air_velocity
    speed = flight.state.airspeed
    tail = (np.gradient(north, flight.time) * air_north + np.gradient(east, flight.time) * air_east) / speed
    return np.asarray(tail / STANDARD_GRAVITY - up / speed)


def averaged(values: np.ndarray, distance: np.ndarray, length: float = AVERAGED) -> np.ndarray:
    """(k,) mean over the last ``length`` m of ``distance`` (k, increasing); NaN before so much has been flown."""
    total = np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(distance))))
    before = np.interp(distance - length, distance, total)
    return np.where(distance - distance[0] >= length, (total - before) / length, np.nan)


def averaged_f_factor(flight: Flight) -> np.ndarray:
    """(k,) F-factor over the last kilometre through the air, by which windshear systems are judged; NaN at first."""
    flown = np.concatenate(([0.0], np.cumsum(flight.state.airspeed[1:] * np.diff(flight.time))))
    return averaged(f_factor(flight), flown)


def worst_on_the_glide_path(event: WindEvent, runway: Runway, airspeed: float, height: float) -> float:
    """Greatest F-factor over a kilometre of the glide path below ``height`` (m) due to a stationary event.

    The wind is taken small beside the airspeed, so the result is proportional to the strength of the event.
    """
    slope = math.tan(runway.glide_path)
    past = np.arange(runway.aiming_point - height / slope - AVERAGED, runway.aiming_point, STEP)
    along = runway.to_local(1.0, 0.0)
    wind = []
    for x in past:
        north, east = runway.to_local(float(x), 0.0)
        wind.append(event.velocity(0.0, (north, east, (runway.aiming_point - x) * slope), airspeed))
    north, east, up = np.array(wind).T
    tail = north * along[0] + east * along[1]
    distance = (past - past[0]) / math.cos(runway.glide_path)
    factor = airspeed * np.gradient(tail, distance) / STANDARD_GRAVITY - up / airspeed
    return float(np.nanmax(averaged(factor, distance)))


def outlook(prepared: Prepared) -> list[str]:
    """A sentence for each event along the approach: its F-factor, and the reserve of climb at full power."""
    scenario, landing = prepared.scenario, prepared.autopilot.landing
    standing = {name: event.standing() for name, event in scenario.wind.events.items()}
    if landing is None or all(event is None for event in standing.values()):
        return []
    try:
        climb = run_isolated(scenario, MODEL_TIME_LIMIT, steepest_climb, prepared)
    except TrimError as error:
        return [f"energy against wind events: {error}"]
    reserve, said = climb + math.sin(scenario.runway.glide_path), []
    for name, event in standing.items():
        if event is None:
            continue
        worst = worst_on_the_glide_path(event, scenario.runway, landing.approach_speed, landing.gate.height)
        said.append(
            f"{kind_in_words(scenario, name)} '{name}': F-factor up to {worst:.3f} over a kilometre of the glide path "
            f"below {landing.gate.height:.0f} m; full power with landing flaps, and the descent, bear {reserve:.3f}"
        )
    return said


def steepest_climb(prepared: Prepared) -> float:
    """Sine of the steepest steady climb at approach speed with landing flaps and gear down: (thrust - drag) / weight.

    Raises ``TrimError`` where the aircraft has no steady state on its glide path.
    """
    landing = prepared.autopilot.landing
    assert landing is not None
    airframe = prepared.airframe.load()

    def within(angle: float) -> bool:
        try:
            steady = trim(airframe, landing.approach_speed, angle, 100.0, landing.flaps, 1.0)
        except TrimError:
            return False
        return bool(steady.controls.throttle <= 1.0)

    low, high = -landing.glide_path, STEEPEST
    if not within(low):
        raise TrimError("the aircraft cannot hold its glide path at approach speed")
    while high - low > TOLERANCE:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if within(middle) else (low, middle)
    return math.sin(low)
