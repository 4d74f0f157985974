"""The autopilot's own navigation with its errors: what it believes of its place, its drift and its height on a beam."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

from aircraft.state import AircraftState
from sim.flight.preparation import Prepared
from sim.randomness import Rows, Streams
from sim.scenario.arrivals.navigation import NavigationErrors
from sim.scenario.tables import Runway

STREAM = "navigation"
BENT_EVERY = 0.05  # of the correlation length: so often a beam is drawn, and straight between
ON_THE_PATH = 30.0  # m below the glide path, from where on it leads; farther below, a barometric height is held


class Beam(NamedTuple):
    """A bend of a beam along the way to its antenna: two points of it, and the stream of those that follow."""

    noise: Rows
    near: float  # standard deviations, at the point ahead
    far: float  # at the one behind
    at: float  # m to the antenna, of the point ahead

    def seen_at(self, distance: float, length: float) -> tuple[Beam, float]:
        """The beam and its bend, standard deviations, so far (m) from the antenna; it is drawn on the way there.

        A first-order Gauss-Markov process over the distance, with its ``length`` (m) of correlation. Whoever flies away
        from the antenna, in a go-around, sees what it saw last.
        """
        step = BENT_EVERY * length
        kept = math.exp(-BENT_EVERY)
        noise, near, far, at = self
        while distance < at:
            far, at = near, at - step
            near = kept * near + math.sqrt(1.0 - kept * kept) * float(noise.row()[0, 0])
        share = min(max((distance - at) / step, 0.0), 1.0)
        return Beam(noise, near, far, at), near + share * (far - near)


class Sight(NamedTuple):
    """What the aircraft believes from record to record."""

    localiser: Beam
    glide_path: Beam
    cross_track: float  # m, of its filter
    wind: float  # m/s across the final, to the right, as it has worked it out: of the air, or what the platform lacks
    height_error: float  # m, of the height that it believes on the glide path


@dataclass(frozen=True)
class ErringNavigator:
    """Steps the errors along the flight; it has ``begin`` and ``step`` of a navigator.

    The filter is z' = u + w + 2 (m - z) / T, w' = (m - z) / T^2 for the measured cross-track m, the velocity u across
    the final that the aircraft knows and what it lacks, w: through the air, by heading and airspeed, and the wind, or
    over the ground and the drift of an inertial platform. The rate that the autopilot believes is u + w.
    On the glide path the height follows the beam with the lag T, its own rate being known. In level flight it is right.
    """

    errors: NavigationErrors
    runway: Runway
    streams: Streams

    def begin(self, state: AircraftState) -> tuple[Sight, AircraftState]:
        """The aircraft knows its place, and its motion but for its first error."""
        wrong = self.errors.wind * float(self.streams.generator("wind").standard_normal())
        _, across = self.runway.from_local(state.velocity_north, state.velocity_east)
        past, z = self.runway.from_local(state.north, state.east)
        sight = Sight(
            self._beam("localiser", self._to_antenna(past)),
            self._beam("glide_path", self._to_aiming_point(past)),
            float(z),
            float(across) - self._known(state) + wrong,
            0.0,
        )
        return self._seen(sight, state, float(z))

    def step(self, sight: Sight, before: AircraftState, after: AircraftState) -> tuple[Sight, AircraftState]:
        """The belief one record later, and what the autopilot sees then."""
        past, z = self.runway.from_local(after.north, after.east)
        distance = self._to_antenna(past)
        beam, bend = sight.localiser.seen_at(distance, self.errors.bend_length)
        measured = float(z) - distance * (self.errors.localiser_bias + self.errors.localiser_bend * bend)
        dt, time = after.time - before.time, self.errors.smoothing
        wrong = measured - sight.cross_track
        believed = sight.cross_track + (self._known(after) + sight.wind + 2.0 * wrong / time) * dt
        wind = sight.wind + wrong / (time * time) * dt
        to_go = self._to_aiming_point(past)
        path, bend = sight.glide_path.seen_at(to_go, self.errors.bend_length)
        bent = to_go * self.errors.glide_path_bend * bend
        if to_go * math.tan(self.runway.glide_path) > after.height + ON_THE_PATH:
            bent = 0.0
        height_error = sight.height_error + (bent - sight.height_error) / time * dt
        return self._seen(Sight(beam, path, believed, wind, height_error), after, float(z))

    def _seen(self, sight: Sight, state: AircraftState, z: float) -> tuple[Sight, AircraftState]:
        """The state with the place and the velocity that the aircraft believes across the final, and its height."""
        _, across = self.runway.from_local(state.velocity_north, state.velocity_east)
        north, east = self.runway.to_local(0.0, sight.cross_track - z)
        rate_north, rate_east = self.runway.to_local(0.0, self._known(state) + sight.wind - across)
        seen = state._replace(
            north=state.north + float(north),
            east=state.east + float(east),
            velocity_north=state.velocity_north + float(rate_north),
            velocity_east=state.velocity_east + float(rate_east),
            height=state.height + sight.height_error,
        )
        return sight, seen

    def _known(self, state: AircraftState) -> float:
        """Velocity to the right of the final that the aircraft knows, m/s: over the ground, or by heading and airspeed
        through the air."""
        if self.errors.motion == "inertial":
            return float(self.runway.from_local(state.velocity_north, state.velocity_east)[1])
        return float(state.airspeed * math.sin(state.heading + state.sideslip - self.runway.heading))

    def _to_antenna(self, past: Any) -> float:
        return max(self.errors.localiser_past - float(past), 0.0)

    def _to_aiming_point(self, past: Any) -> float:
        return max(self.runway.aiming_point - float(past), 0.0)

    def _beam(self, name: str, distance: float) -> Beam:
        noise = self.streams.normal(name, 1)
        first = float(noise.row()[0, 0])
        return Beam(noise, first, first, distance)


def erring_navigator(prepared: Prepared, flight: int) -> ErringNavigator | None:
    """The navigation that a scenario's ``[navigation_errors]`` make of the truth; None = it has none."""
    scenario = prepared.scenario
    if scenario.navigation_errors is None:
        return None
    streams = Streams(scenario.seed, flight, 1, STREAM)
    return ErringNavigator(scenario.navigation_errors, scenario.runway, streams)
