"""The gains of the inner loops and of the route law: carried by the scenario, or designed for its aircraft."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from aircraft.model_files import digest, read
from aircraft.runway import Runway as Place
from autopilot.design import Designed
from autopilot.estimate_lag import softened
from autopilot.landing import Landing
from autopilot.route import Route
from sim.flight.airspeeds import extremes
from sim.flight.gains import Gains, gains_for, known_design, plain
from sim.flight.preparing.aircraft import airframe_of
from sim.flight.vehicles import Configuration, designed, designed_point_mass
from sim.scenario.model import Scenario


def gains_of(scenario: Scenario, route: Route, flaps: float, landing: Landing | None) -> Gains:
    """The gains: those that travel in the scenario, or a design on the linear model.

    The inputs are the very arguments of the design, the model by its content: whatever else a design comes to depend on
    becomes an argument of it, and is then noticed when it changes.
    """
    slowest, fastest = extremes(scenario)
    limits = {"bank_limit": scenario.autopilot.bank_limit, "roll_rate_limit": scenario.autopilot.roll_rate_limit}
    arguments: dict[str, Any] = {"speed": fastest, **limits}
    design: Callable[..., Designed] = designed_point_mass
    aircraft = {"model": "point_mass"}
    if scenario.aircraft.model != "point_mass":
        design = designed
        if landing is None:
            wanted = [Configuration(flaps, 0.0, 0.96 * slowest, 1.04 * fastest)]
        else:
            final = landing.approach_speed
            wanted = [
                Configuration(flaps, 0.0, 1.03 * final, 1.02 * fastest),
                Configuration(landing.flaps, 1.0, 0.97 * final, 1.02 * slowest, -landing.glide_path),
            ]
        arguments |= {"configurations": wanted, "height": max(leg.height for leg in route.legs)}
        choice = airframe_of(scenario)._replace(
            runway=Place(elevation=scenario.runway.elevation)
        )  # all of it that acts
        arguments["choice"] = choice
        aircraft = plain(choice) | {"model": digest(read(choice.model))}
    lag = scenario.autopilot.estimate_lag
    inputs = plain(arguments) | {"estimate_lag": lag, "choice": aircraft}

    def made() -> Designed:
        return softened(design(**arguments), fastest, lag)

    return gains_for(scenario.designed, inputs, lambda: known_design(inputs, scenario.aircraft.model, made))
