"""What theory predicts for a map before anything is flown: limits, drawn as lines over the map."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from aircraft.errors import TrimError
from autopilot.design import law_of_frequency
from autopilot.limit_cycles import LimitedLoop, caught, limited_loop, onset
from autopilot.mode import DesignCase
from autopilot.modes.lateral_navigation import LateralNavigation
from autopilot.route_loop import linear_onset
from sim.errors import ScenarioError
from sim.experiment import read
from sim.scenario.axes import Listed
from sim.scenario.model import Scenario
from sim.scenario.parameters import construct
from sim.scenario.plugins import Part
from sim.scenario.reading import override
from sim.scenario.tables import LegsTable, PatternTable
from sim.studies.limits import prediction


class Line(NamedTuple):
    """A border in the plane of a map, in the units of its axes."""

    label: str
    x: np.ndarray
    y: np.ndarray


Cell = Mapping[str, Any]
"""The chosen values of a cell by the address of their axis."""
Columns = dict[str, list[float | None]]


class Theory(NamedTuple):
    """What is known of a map over chosen axes."""

    unfit: Callable[[Sequence[str]], str]  # why the addresses of chosen axes are not those that it is about, "" = are
    lines: Callable[[Scenario, np.ndarray, np.ndarray], tuple[Line, ...]]  # (scenario, values of x, values of y)
    needs: Callable[[Scenario], str]  # what it is about and a scenario lacks, "" = nothing
    figures: Callable[[Scenario, Sequence[Cell]], Columns] | None = None  # of cells, a column for each figure


def plane(x: str, y: str) -> Callable[[Sequence[str]], str]:
    """Of a theory over two certain axes."""

    def unfit(addresses: Sequence[str]) -> str:
        return "" if [*addresses[:2]] == [x, y] else f'is about the axes "{x}" and "{y}", in this order'

    return unfit


def limits_unfit(addresses: Sequence[str]) -> str:
    """The theory of limits is about any axes that say where a capture begins and what its limits are."""
    known = ", ".join(f'"{address}"' for address in prediction.ADDRESSES)
    strange = prediction.stranger(addresses)
    if strange:
        return f'knows nothing of the axis "{strange}"; it is about {known}'
    return "" if addresses else f"needs an axis of chosen values: {known}"


def no_lines(scenario: Scenario, x: np.ndarray, y: np.ndarray) -> tuple[Line, ...]:
    """Of a theory whose borders are drawn over the ratios of contrasts alone."""
    return ()


def over_x(label: str, border: Callable[[Any, Scenario, np.ndarray], np.ndarray]) -> Any:
    """Lines of a theory that is one value of y for each x."""

    def lines(scenario: Scenario, x: np.ndarray, y: np.ndarray) -> tuple[Line, ...]:
        from sim.flight.preparation import prepare

        return (Line(label, x, border(prepare(scenario).law, scenario, x)),)

    return lines


def orbit_border(law: Any, scenario: Scenario, wind: np.ndarray) -> np.ndarray:
    """The cross-track limit above which the law orbits, m, in a wind that blows away from the line, m/s.

    Far out the bank returns to zero on some course only if k1 min(z_max, offset) < k2 min(zdot_max, closing speed), and
    the closing speed is at most the airspeed less the wind [Vasylyev 2003, eq. (4)].
    """
    route_law, route = LateralNavigation.of(law), scenario.route
    if route_law is None or not isinstance(route, LegsTable):
        return np.full(len(wind), math.inf)
    airspeed = min(leg.speed for leg in route.legs)
    closing = np.minimum(route_law.cross_track_rate_limit, np.maximum(airspeed - wind, 0.0))
    border = route_law.k2 / route_law.k1 * closing
    return np.where(border < abs(scenario.start.cross_track), border, math.inf)


def orbit_needs(scenario: Scenario) -> str:
    """Legs, whose speed is that of the intercept, and the route law."""
    if not isinstance(scenario.route, LegsTable):
        return 'a route of legs, [route] kind = "legs"'
    return _route_law_needed(scenario)


def energy_needs(scenario: Scenario) -> str:
    """A glide path, a microburst on it, and engines."""
    if not isinstance(scenario.route, PatternTable) or "burst" not in scenario.wind.events:
        return "a landing pattern and a [wind.events.burst]"
    return _aircraft_needed(scenario)


def gain_needs(scenario: Scenario) -> str:
    """The route law over inner loops."""
    return _route_law_needed(scenario) or _aircraft_needed(scenario)


def _aircraft_needed(scenario: Scenario) -> str:
    return "a JSBSim aircraft, not the point mass" if scenario.aircraft.model == "point_mass" else ""


def _route_law_needed(scenario: Scenario) -> str:
    """Which inputs a law has is the same whatever it is designed for, so that no aircraft has to be looked at."""
    case = DesignCase(scenario.autopilot.bank_limit, 2.0, 70.0, k1=2e-3, k2=3e-2, cross_track_limit=500.0)
    try:
        law = scenario.modes[scenario.mode].designed(scenario.law, case)
    except ValueError:
        return ""  # faults of its own numbers are reported when it is designed
    if LateralNavigation.of(law) is not None:
        return ""
    return f"a law of the cross-track and its rate, such as 'lateral_navigation', not '{scenario.mode}'"


def energy_border(law: Any, scenario: Scenario, places: np.ndarray) -> np.ndarray:
    """The strength of an event, m/s, above which full power cannot hold speed and glide path, over its place, m.

    Through the air the energy height changes by V ((thrust - drag) / weight - F), and on the glide path it must fall by
    V sin(glide path): no power holds both once F, over a kilometre, exceeds the steepest climb and the glide path.
    """
    from sim.flight.preparation import MODEL_TIME_LIMIT, prepare
    from sim.metrics.windshear import steepest_climb, worst_on_the_glide_path
    from sim.workers.isolation import run_isolated

    prepared = prepare(scenario)
    landing = prepared.autopilot.landing
    assert landing is not None
    try:
        climb = run_isolated(scenario, MODEL_TIME_LIMIT, steepest_climb, prepared)
    except TrimError:
        return np.zeros(len(places))  # it cannot hold its glide path in still air
    reserve = climb + math.sin(scenario.runway.glide_path)
    table = override(scenario.tables["wind"]["events"]["burst"], "peak_mps", 1.0)
    cls = type(scenario.wind.events["burst"])

    def strength(place: float) -> float:
        event = construct(cls, override(table, "past_threshold_m", place), runway=scenario.runway).standing()
        if event is None:  # of a kind that costs no energy
            return math.inf
        worst = worst_on_the_glide_path(event, scenario.runway, landing.approach_speed, landing.gate.height)
        return reserve / worst if worst > 0.0 else math.inf

    return np.array([strength(float(place)) for place in places])


def gain_lines(scenario: Scenario, x: np.ndarray, y: np.ndarray) -> tuple[Line, ...]:
    """Shares of the bank loop's bandwidth at which the linear loop is unstable, and its limits sustain a cycle."""
    offset = abs(scenario.start.cross_track)
    limited = [_limited_loop(scenario, float(bank)) for bank in y]
    bandwidths = np.array([one.loop.bandwidth for one in limited])
    linear = np.array([linear_onset(one.loop, one.bank_limit) for one in limited])
    onsets = np.array([onset(one, offset) for one in limited])
    return (
        Line("theory: linear margin", linear / bandwidths, y),
        Line(f"theory: describing functions, from {offset:.0f} m", onsets / bandwidths, y),
    )


def gain_figures(scenario: Scenario, cells: Sequence[Cell]) -> Columns:
    """Amplitude and period of the bank in the limit cycle that an aircraft starting beside the line ends in."""
    found = []
    for share, bank in ([cell[address] for address in GAIN] for cell in cells):
        limited = _limited_loop(scenario, bank)
        law = law_of_frequency(share * limited.loop.bandwidth, limited.loop.speed, limited.bank_limit)
        found.append(caught(limited, law, abs(scenario.start.cross_track)))
    return {
        "bank_cycle_deg": [None if cycle is None else math.degrees(cycle.bank) for cycle in found],
        "bank_cycle_period_s": [None if cycle is None else cycle.period for cycle in found],
    }


def _limited_loop(scenario: Scenario, bank: float) -> LimitedLoop:
    """The route loop of a scenario, designed for a bank limit (deg), with its limits."""
    flown = {key: value for key, value in scenario.tables.items() if key != "study"}
    autopilot = override(flown["autopilot"], "bank_limit_deg", bank)
    return _limited_loop_of(json.dumps({**flown, "autopilot": autopilot}), scenario.parts)


@functools.lru_cache(maxsize=64)
def _limited_loop_of(tables: str, parts: tuple[Part, ...]) -> LimitedLoop:
    from sim.flight.preparation import MODEL_TIME_LIMIT, prepare
    from sim.workers.isolation import run_isolated

    scenario = read({key: value for key, value in json.loads(tables).items() if value is not None}, plugins=parts)
    loop = run_isolated(scenario, MODEL_TIME_LIMIT, prepare(scenario).route_loop)
    return limited_loop(loop, scenario.autopilot.bank_limit, scenario.autopilot.roll_rate_limit)


GAIN = ("autopilot.frequency_share", "autopilot.bank_limit_deg")
THEORIES = {
    "energy": Theory(
        plane("wind.events.burst.past_threshold_m", "wind.events.burst.peak_mps"),
        over_x("theory: F over 1 km = steepest climb + glide path", energy_border),
        energy_needs,
    ),
    "gain": Theory(plane(*GAIN), gain_lines, gain_needs, gain_figures),
    "limits": Theory(limits_unfit, no_lines, prediction.needs, prediction.cell_figures),
    "orbit": Theory(
        plane("wind.speed_mps", "autopilot.law.cross_track_limit_m"),
        over_x("theory: k1 z_max = k2 (V - wind)", orbit_border),
        orbit_needs,
    ),
}


def border(name: str, scenario: Scenario, x: np.ndarray) -> np.ndarray:
    """Values of y on the first border of a theory, over values of x; raises ``ScenarioError`` where it has none."""
    lacking = THEORIES[name].needs(scenario)
    if lacking:
        raise ScenarioError(f'{scenario.name}: theory "{name}" needs {lacking}')
    return THEORIES[name].lines(scenario, x, np.zeros(1))[0].y


def predicted_figures(scenario: Scenario, rows: Sequence[dict[str, Any]]) -> Columns:
    """Columns of figures that the theory of a study predicts for its cells; empty where it predicts none."""
    if scenario.study is None or scenario.study.theory is None or not rows:
        return {}
    figures = THEORIES[scenario.study.theory].figures
    chosen = [one.address for one in scenario.study.varied if isinstance(one, Listed)]
    cells = [{address: row[address] for address in chosen} for row in rows]
    return {} if figures is None else figures(scenario, cells)
