"""The loop closed through a tracker: the autopilot flies on the position that the tracker estimates."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState, Command
from sim.errors import ScenarioError
from sim.estimation.prior import prior
from sim.estimation.setup import build
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.observation.faults import faulty
from sim.observation.sensor import SensorError, looks_of
from sim.observation.sensor import ask as ask_sensor
from sim.randomness import Streams
from sim.scenario.tables import SensorFault
from tracking.gaussian import Gaussian, Mixture, merge
from tracking.track import TrackerError, ask, believed, stepped, taken

DECISION_HEIGHT = 60.0  # m; below, the height is the radio altimeter's


@contextmanager
def _in_the_loop() -> Iterator[None]:
    """Report a broken contract of the tracker or a sensor as a ``ScenarioError``."""
    try:
        yield
    except SensorError as error:
        raise ScenarioError(f"[autopilot] navigation: a sensor's {error}") from error
    except TrackerError as error:
        raise ScenarioError(f"[autopilot] navigation: its tracker's {error}") from error


class NavigatorState(NamedTuple):
    """The state of the navigator from record to record."""

    sensors: tuple[Any, ...]  # state of each sensor
    tracker: Any  # state after the last measurement
    time: float  # s, of that state
    ahead: Any  # the same carried on to now, record by record
    now: float  # s
    pending: tuple[tuple[float, int, np.ndarray, np.ndarray], ...]  # (arrival, sensor, z, R) not yet known
    range: float  # m, the last of a distance-measuring sensor, NaN = none yet
    altimeter: float  # m, the last of a radio altimeter, NaN = none yet


@dataclass(frozen=True)
class Navigator:
    """Steps the sensors of one tracker and the tracker itself along the flight; one noise draw.

    A cartesian tracker gives position and velocity over the ground. A tracker of an elevation gives the height, through
    the range of a distance-measuring sensor and never through the true one; below decision height the radio altimeter
    takes over where there is one.
    """

    tracker: Any
    route: Any
    true_sensors: dict[str, Any]  # all sensors by name; the prior is an error about the truth at the start
    listened: tuple[tuple[str, Any], ...]  # sensors of the tracker by name, in the order of its z
    elevation: Any = None  # the sensor whose elevation the tracker estimates
    ranging: tuple[str, Any] | None = None
    altimeter: tuple[str, Any] | None = None
    seed: int = 0
    flight: int = 0
    faults: tuple[SensorFault, ...] = ()

    @property
    def sensors(self) -> tuple[tuple[str, Any], ...]:
        """All sensors that are stepped: those of the tracker, then the ones that only complete a height."""
        extra = (one for one in (self.ranging, self.altimeter) if one is not None)
        return (*self.listened, *extra)

    @_in_the_loop()
    def begin(self, state: AircraftState) -> tuple[NavigatorState, AircraftState]:
        """The navigator's state at the start, and the aircraft state that the autopilot sees then."""
        start = prior(
            _straight(state, self.route),
            self.true_sensors,
            self.tracker.channels,
            state.time,
            self.seed,
            self.flight,
            1,
        )
        sensors = tuple(
            ask_sensor(sensor, "begin", state.time, Streams(self.seed, self.flight, 1, name))
            for name, sensor in self.sensors
        )
        tracker = ask(self.tracker, "begin", _batched(start))
        sight = NavigatorState(sensors, tracker, state.time, tracker, state.time, (), math.nan, math.nan)
        return sight, self._seen(sight, state)

    @_in_the_loop()
    def step(
        self, sight: NavigatorState, before: AircraftState, after: AircraftState
    ) -> tuple[NavigatorState, AircraftState]:
        """The navigator's state one record later, and what the autopilot sees then; looks count from their arrival."""
        states, pending = [], list(sight.pending)
        for index, (state, (name, sensor)) in enumerate(zip(sight.sensors, self.sensors, strict=True)):
            state, looks = looks_of(sensor, state, before, after, 1)
            states.append(state)
            own = [one for one in self.faults if one.sensor == name]
            made = (faulty(look, sensor, own, before, after) for look in looks)
            pending += [(look.arrival, index, look.z, look.R) for look in made]
        known = sorted((look for look in pending if look[0] <= after.time), key=lambda look: look[:2])
        late = tuple(look for look in pending if look[0] > after.time)
        sight = sight._replace(sensors=tuple(states), pending=late)
        while known:
            together = [look for look in known if look[0] == known[0][0]]
            known = known[len(together) :]
            sight = self._take(sight, together)
        if after.time > sight.now:
            ahead, _ = stepped(self.tracker, sight.ahead, after.time - sight.now)
            sight = sight._replace(ahead=ahead, now=after.time)
        return sight, self._seen(sight, after)

    def _take(self, sight: NavigatorState, looks: list[tuple[float, int, np.ndarray, np.ndarray]]) -> NavigatorState:
        arrival = looks[0][0]
        rows = sum(len(sensor.channels) for _, sensor in self.listened)
        z, R = np.full((rows, 1), np.nan), np.eye(rows)[..., None]
        for _, index, measured, covariance in looks:
            if index < len(self.listened):
                first = sum(len(sensor.channels) for _, sensor in self.listened[:index])
                part = slice(first, first + len(measured))
                z[part] = measured
                R[part, part] = covariance if covariance.ndim == 3 else covariance[..., None]
            elif self.ranging is not None and index == len(self.listened):
                sight = sight._replace(range=self._last(index, "range", measured, sight.range))
            else:
                sight = sight._replace(altimeter=self._last(index, "height", measured, sight.altimeter))
        if np.isnan(z).all():
            return sight
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a lost track is a result
            tracker = taken(self.tracker, sight.tracker, arrival - sight.time, z, R).state
        return sight._replace(tracker=tracker, time=arrival, ahead=tracker, now=arrival)

    def _last(self, index: int, quantity: str, measured: np.ndarray, before: float) -> float:
        """What a sensor that completes a height measured of its quantity, m; as before where it missed it."""
        value = float(measured[self.sensors[index][1].channels.index(quantity), 0])
        return before if math.isnan(value) else value

    def _seen(self, sight: NavigatorState, state: AircraftState) -> AircraftState:
        """The aircraft's state with the position and velocity of the tracker, predicted to now."""
        estimate = believed(self.tracker, sight.ahead)
        mean = (merge(estimate) if isinstance(estimate, Mixture) else estimate).mean
        values = {name: float(np.ravel(value)[0]) for name, value in zip(self.tracker.channels, mean, strict=True)}
        if "north" in values:
            return state._replace(
                north=values["north"],
                east=values["east"],
                velocity_north=values["north_rate"],
                velocity_east=values["east_rate"],
            )
        return state._replace(height=self._height(sight, state, values))

    def _height(self, sight: NavigatorState, state: AircraftState, believed: dict[str, float]) -> float:
        elevation = next(value for name, value in believed.items() if name.endswith(".elevation"))
        if math.isnan(sight.range):
            return float(state.height)  # not yet coupled: the barometric height of the level leg
        height: float = self.elevation.antenna[2] + sight.range * math.sin(elevation)
        if height < DECISION_HEIGHT and not math.isnan(sight.altimeter):
            return sight.altimeter
        return height


def _batched(start: Gaussian) -> Gaussian:
    """The prior of one run with its axis."""
    return Gaussian(start.mean, start.cov[..., None])


def _straight(state: AircraftState, route: Any) -> Flight:
    """A second of straight flight about a state, from which the true value of any component is computed."""
    times = np.array((-0.5, 0.0, 0.5))
    columns = {name: np.full(3, float(value)) for name, value in state._asdict().items()}
    columns["time"] = state.time + times
    for axis, rate in (("north", "velocity_north"), ("east", "velocity_east"), ("height", "velocity_up")):
        columns[axis] = columns[axis] + times * columns[rate]
    nothing = np.zeros(3, int)
    return Flight(
        route, AircraftState(**columns), Command(*np.zeros((6, 3))), nothing, nothing, ("start",), (), "completed", ""
    )


def navigator(prepared: Prepared, flight: int) -> Navigator | None:
    """What the autopilot flies on; None = the truth. Raises ``ScenarioError`` for a tracker that gives no place."""
    scenario = prepared.scenario
    name = scenario.autopilot.navigation
    if name == "truth":
        return None
    choice = scenario.trackers[name]
    if choice.association is not None:
        raise ScenarioError(f"[autopilot] navigation: tracker '{name}' associates plots, which none does in the loop")
    tracker, _ = build(prepared, name, choice)
    listened = tuple((sensor, scenario.sensors[sensor]) for sensor in choice.sensors)
    others = [(other, sensor) for other, sensor in scenario.sensors.items() if other not in choice.sensors]
    elevation = ranging = altimeter = None
    if "north" not in tracker.channels:
        owner = next((c.rpartition(".")[0] for c in tracker.channels if c.endswith(".elevation")), None)
        ranging = next((one for one in others if "range" in one[1].channels), None)
        aboard = (one for one in others if one[1].antenna is None)  # a radar's height is known on the ground
        altimeter = next((one for one in aboard if "height" in one[1].channels), None)
        if owner is None or ranging is None:
            raise ScenarioError(
                f"[autopilot] navigation: tracker '{name}' gives neither a position nor, with a range, a height"
            )
        elevation = scenario.sensors[owner]
    return Navigator(
        tracker,
        prepared.route,
        scenario.sensors,
        listened,
        elevation,
        ranging,
        altimeter,
        scenario.seed,
        flight,
        scenario.sensor_faults,
    )
