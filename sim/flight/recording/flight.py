"""recorded_flight(): a recorded track as the ``Flight`` that sensors watch and trackers follow."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from aircraft.air import Air
from aircraft.state import AircraftState, Command
from autopilot.route import Leg, Route
from sim.errors import ScenarioError
from sim.flight.record import RECORD_STEP, Event, Flight
from sim.flight.recording.cleaning import cleaned
from sim.flight.recording.notes import notes
from sim.flight.recording.phases import ESTABLISHED, GROUND, PHASES, bank_of, phases_of
from sim.flight.recording.places import placed
from sim.flight.recording.smoothing import Path, resampled, smoothed, tamed
from sim.flight.recording.units import contradictions
from sim.interchange.track_record import TrackRecord
from sim.scenario.recording.table import final
from sim.scenario.tables import Runway

LANDED = "landed"
ROLLED = "the record of the roll-out ends here"
REMARK = "remark"  # the event that tells what was done to the record
TAXIING = 15.0  # m/s over the ground; slower, a bank read off the turn means nothing


def recorded_flight(track: TrackRecord, runway: Runway, air: Air | None = None, route: Route | None = None) -> Flight:
    """The smoothed motion of a recorded track in the frame of a runway, at the instants of a flight of ours.

    Time 0 is the first row that was kept, ``utc`` its date. Position and velocity are smoothed; bank follows from the
    turn (`phases.bank_of`). All that no receiver hears is NaN: attitude and rates but the bank, airspeed, load factors,
    controls, wheels, and every command. What was done to the rows is told in events ``remark``. On the ground it is the
    ``rollout``.

    Parameters
    ----------
    air : by which pressure altitudes become heights; None = the standard atmosphere, QNH 1013.25 hPa
    route : its deviations are of; None = the final, `final_route`

    Raises ``ScenarioError``, one sentence, for a track that is no flight to this runway.
    """
    air = Air(runway.elevation) if air is None else air
    try:
        odd = contradictions(track)
        rows, assumed = placed(track, runway, air)
        rows, dropped = cleaned(rows)
        rows, wild = tamed(rows)
        path, accuracy = smoothed(rows)
    except ValueError as error:
        raise ScenarioError(f"flight '{track.name}': {error}") from None
    span = path.time[-1] - path.time[0]
    path = resampled(path, RECORD_STEP * np.arange(int(span / RECORD_STEP) + 1))
    phase = phases_of(path, runway)
    stopped = np.flatnonzero((phase == GROUND) & (np.hypot(path.velocity[0], path.velocity[1]) < TAXIING))
    if stopped.size:
        path, phase = Path(*(part[..., : stopped[0]] for part in path)), phase[: stopped[0]]
    route = final_route(runway) if route is None else route
    told = (*track.remarks, *odd, *assumed, *dropped, *wild, *notes(path, phase, runway, air))
    outcome, reason = _ending(path, phase, runway)
    time = path.time
    changes = (0, *(np.flatnonzero(np.diff(phase)) + 1))
    accurate = (
        f"{accuracy.along:.1f} m along the track, {accuracy.across:.1f} m across, {accuracy.height:.1f} m in height"
    )
    events = (
        Event(0.0, "recorded", f"places scattered by {accurate} before they were smoothed"),
        *(Event(0.0, REMARK, sentence) for sentence in told),
        *(Event(float(time[i]), PHASES[phase[i]]) for i in changes),
    )
    leg, utc = _leg(route, path), float(rows.time[0])
    down = int(np.argmax(phase == GROUND)) + 1 if outcome == LANDED else len(time)
    events = tuple(event for event in events if event.time <= time[down - 1])
    flown = _part(route, path, leg, phase, slice(down), utc)
    flown = dataclasses.replace(
        flown, events=(*events, Event(float(time[down - 1]), outcome, reason)), outcome=outcome, reason=reason
    )
    if len(time) - down < 2:
        return flown
    return dataclasses.replace(flown, rollout=_part(route, path, leg, phase, slice(down, None), utc))


def _part(route: Route, path: Path, leg: np.ndarray, phase: np.ndarray, part: slice, utc: float) -> Flight:
    """A stretch of the recording: what is flown, or the roll-out, which ends where the record is cut."""
    path = Path(*(values[..., part] for values in path))
    command = Command(*(np.full(len(path.time), np.nan),) * len(Command._fields))
    return Flight(route, _state(path), command, leg[part], phase[part], PHASES, (), "completed", ROLLED, utc=utc)


def final_route(runway: Runway) -> Route:
    """The extended centreline, as a route."""
    (leg,) = final(runway).legs
    return Route((Leg(leg.from_, leg.to, leg.speed, leg.height),))


def _state(path: Path) -> AircraftState:
    nothing = np.full(len(path.time), np.nan)
    return AircraftState(*(nothing,) * len(AircraftState._fields))._replace(
        time=path.time,
        **dict(zip(("north", "east", "height"), path.position, strict=True)),
        **dict(zip(("velocity_north", "velocity_east", "velocity_up"), path.velocity, strict=True)),
        bank=bank_of(path),
    )


def _leg(route: Route, path: Path) -> np.ndarray:
    """(k,) the leg that is next in the order of the route: one is left where the following one is nearer."""
    legs = np.array([(*leg.end, *leg.direction) for leg in route.legs])
    if len(legs) == 1:
        return np.zeros(len(path.time), int)
    across = np.abs((path.position[1] - legs[:, 1:2]) * legs[:, 2:3] - (path.position[0] - legs[:, :1]) * legs[:, 3:])
    found, current = [], 0
    for number in range(across.shape[1]):
        while current + 1 < len(legs) and across[current + 1, number] < across[current, number]:
            current += 1
        found.append(current)
    return np.array(found)


def _ending(path: Path, phase: np.ndarray, runway: Runway) -> tuple[str, str]:
    """Outcome and reason: landed where it reaches the runway, else completed where the record ends."""
    past, right = runway.from_local(path.position[0, -1], path.position[1, -1])
    if phase[-1] == GROUND:
        over = int(np.argmax(phase == GROUND))
        there = float(runway.from_local(path.position[0, over], path.position[1, over])[0])
        return LANDED, f"on the runway {there:.0f} m past the threshold at the latest, where it sank no more"
    where = f"{math.hypot(past, right) / 1e3:.1f} km from the threshold at {path.position[2, -1]:.0f} m"
    if phase[-1] >= ESTABLISHED:
        return "completed", f"the record ends on the line of the runway, {where}"
    return "completed", f"the record ends {where}, not on the line of the runway"
