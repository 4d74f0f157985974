"""Arrivals that look like recorded ones, by formulas: two generators of different structure behind one function.

``law``      the law of the route mode drawn for each aircraft, engaged late on the heading given by a controller
``heading``  another autopilot: courses commanded by the deviation, the bank by a lag of second order; trackers are
             never tuned on these

Both give flights as a recording gives them: place and motion once a second, what a recording does not know is NaN.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from aircraft.state import AircraftState, Command
from autopilot.route import Leg, Route
from sim.flight.record import Event, Flight
from tests.tuning.arrivals import by_heading, by_law
from tests.tuning.arrivals.record import Arrivals

GENERATORS = {"law": by_law, "heading": by_heading}
PHASES = ("vectors", "capture", "established", "glide")
TURNING = np.radians(0.5)  # rad/s of course, of a turn
PAUSE = 8.0  # s, so short a pause does not end a turn
SETTLING = 20.0  # s after its end that belong to the capture
NOTABLE = np.radians(12.0)  # of course: what changes it by less is a correction, not the turn onto final
FINAL = 60e3  # m, of the straight that trackers are told


def look_alikes(kind: str, seed: int, count: int, departure: str | None = None) -> list[Flight]:
    """``count`` arrivals of a generator; ``departure`` is one of the generator's ``DEPARTURES``, None = none.

    The route of each is the final approach, 60 km long; phases follow from the motion alone. An event ``engaged`` says
    when the law took over, ``departed`` when the aircraft left it.
    """
    generator = GENERATORS[kind]
    found: Arrivals = generator.arrivals(np.random.default_rng([seed, *kind.encode()]), count, departure)
    return [_flight(found, number, generator.FINAL_COURSE) for number in range(count)]


def final_route(course: float) -> Route:
    """The final approach as a chart has it: its line, and no speed that would be held."""
    north, east = np.cos(course), np.sin(course)
    return Route((Leg((float(-FINAL * north), float(-FINAL * east)), (0.0, 0.0), 80.0, 500.0),))


def _flight(found: Arrivals, number: int, course: float) -> Flight:
    rows = found.flying[:, number]
    time = np.arange(len(rows), dtype=float)[rows]

    def own(values: Any) -> Any:
        return values[rows, number]

    c, s = np.cos(course), np.sin(course)
    north, east = own(found.along) * c - own(found.across) * s, own(found.along) * s + own(found.across) * c
    rates = own(found.along_rate), own(found.across_rate)
    unknown = np.full(len(time), np.nan)
    known: dict[str, Any] = dict.fromkeys(AircraftState._fields, unknown)
    height = own(found.height)
    known |= {"time": time, "north": north, "east": east, "height": height, "bank": own(found.bank)}
    known |= {"velocity_north": rates[0] * c - rates[1] * s, "velocity_east": rates[0] * s + rates[1] * c}
    known |= {"velocity_up": np.gradient(height, time), "airspeed": own(found.airspeed)}
    known |= {"heading": (own(found.heading) + course) % (2.0 * np.pi)}
    state = AircraftState(**known)
    phase = _phases(time, np.unwrap(np.arctan2(rates[1], rates[0])), own(found.across), state.velocity_up)
    events = [Event(float(found.engaged[number]), "engaged")]
    if np.isfinite(found.departed[number]):
        events.append(Event(float(found.departed[number]), "departed"))
    nothing = np.zeros(len(time), int)
    command = Command(*(unknown,) * len(Command._fields))
    route = final_route(course)
    return Flight(route, state, command, nothing, phase, PHASES, tuple(events), "completed", "end of the record")


def last_turn(time: Any, course: Any) -> tuple[float, float]:
    """Beginning and end, s, of the last turn: of the last stretch in which the course changes notably.

    Parameters
    ----------
    time : (k,) s, evenly
    course : (k,) rad, unwrapped

    Raises ``ValueError`` for a record without any turn.
    """
    rate = np.gradient(course, time)
    rate = np.convolve(np.pad(rate, 2, "edge"), np.full(5, 0.2), "valid")
    step = float(time[1] - time[0])
    turning = np.concatenate(([0], (np.abs(rate) > TURNING).astype(int), [0]))
    edges = np.flatnonzero(np.diff(turning)).tolist()
    spans = list(zip(edges[::2], edges[1::2], strict=True))
    joined: list[tuple[int, int]] = []
    for first, last in spans:
        same = bool(joined) and np.sign(rate[joined[-1][0]]) == np.sign(rate[first])
        if same and (first - joined[-1][1]) * step <= PAUSE:
            joined[-1] = (joined[-1][0], last)
        else:
            joined.append((first, last))
    for first, last in reversed(joined):
        if abs(course[min(last, len(course) - 1)] - course[first]) >= NOTABLE:
            return float(time[first]), float(time[min(last, len(time) - 1)])
    raise ValueError("the course never changes notably")


def _phases(time: Any, course: Any, across: Any, climb: Any) -> Any:
    """(k,) index into `PHASES`."""
    began, ended = last_turn(time, course)
    phase = np.full(len(time), PHASES.index("established"))
    phase[time < began] = PHASES.index("vectors")
    phase[(time >= began) & (time <= ended + SETTLING)] = PHASES.index("capture")
    phase[(time > ended + SETTLING) & (climb < -1.0)] = PHASES.index("glide")
    return phase
