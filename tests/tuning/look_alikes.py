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
TURNING = np.radians(0.4)  # rad/s of course, of a turn
PAUSE = 8.0  # s, so short a pause does not end a turn
NEAR = np.radians(8.0)  # of the final course: within, what changes it is a correction
SETTLING = 20.0  # s after its end that belong to the capture
BROKEN_OFF = 500.0  # m beyond the line
FINAL = 60e3  # m, of the straight that trackers are told


def look_alikes(kind: str, seed: int, count: int, departure: str | None = None) -> list[Flight]:
    """``count`` arrivals of a generator; ``departure`` is one of the generator's ``DEPARTURES``, None = none.

    The route of each is the final approach, 60 km long; phases follow from the motion alone. An event ``engaged`` says
    when the law took over, ``departed`` when the aircraft left it.
    """
    generator, randomness = GENERATORS[kind], np.random.default_rng([seed, *kind.encode()])
    flights: list[Flight] = []
    while len(flights) < count:
        found: Arrivals = generator.arrivals(randomness, count, departure)
        kept = np.flatnonzero(_is_arrival(found))
        flights += [_flight(found, int(number), generator.FINAL_COURSE) for number in kept]
    return flights[:count]


def _is_arrival(found: Arrivals) -> Any:
    """(n,) bool: one that turns onto final; not one that a controller breaks off because it crosses the line by far."""
    time = np.arange(len(found.across))[:, None]
    still = found.flying & (time < _left(found))
    on = still & (time >= found.engaged)
    last = still.sum(axis=0)[None] - 1
    off = np.abs(np.arctan2(found.across_rate, found.along_rate))
    came, ended, at_last = (
        np.take_along_axis(values, row, axis=0)[0]
        for values, row in ((found.across, np.argmax(on, axis=0)[None]), (found.across, last), (off, last))
    )
    beyond = np.where(on, -np.sign(came) * found.across, 0.0).max(axis=0)
    turned = (np.where(still, off, 0.0).max(axis=0) > NEAR) & (at_last <= NEAR)
    return on.any(axis=0) & turned & (beyond <= BROKEN_OFF) & (np.abs(ended) <= BROKEN_OFF)


def _left(found: Arrivals) -> Any:
    """(n,) s until which an aircraft is on final under a law, be it the one that was expected or not."""
    return np.where(found.departed > found.engaged, found.departed, np.inf)


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
    on = time < _left(found)[number]
    phase = _phases(time, _unwrapped((rates[0][on], rates[1][on])), state.velocity_up)
    events = [Event(float(found.engaged[number]), "engaged")]
    if np.isfinite(found.departed[number]):
        events.append(Event(float(found.departed[number]), "departed"))
    nothing = np.zeros(len(time), int)
    command = Command(*(unknown,) * len(Command._fields))
    route = final_route(course)
    return Flight(route, state, command, nothing, phase, PHASES, tuple(events), "completed", "end of the record")


def last_turn(time: Any, off: Any) -> tuple[float, float]:
    """Beginning and end, s, of the turn onto final: that in which the course comes near the final one for good.

    Parameters
    ----------
    time : (k,) s, evenly
    off : (k,) rad, course less that of the final approach, unwrapped

    Raises ``ValueError`` for a record without such a turn.
    """
    outside = np.flatnonzero(np.abs(off) > NEAR)
    if not len(outside) or outside[-1] == len(off) - 1:
        raise ValueError("there is no turn onto final")
    step = float(time[1] - time[0])
    rate = np.convolve(np.pad(np.gradient(off, time), 2, "edge"), np.full(5, 0.2), "valid")
    turning = -np.sign(off[outside[-1]]) * rate > TURNING
    turned = np.flatnonzero(turning[: outside[-1] + 1])
    first = last = int(turned[-1] if len(turned) else outside[-1])
    while (more := np.flatnonzero(turning[max(first - round(PAUSE / step), 0) : first])).size:
        first = max(first - round(PAUSE / step), 0) + int(more[0])
    while last + 1 < len(turning) and turning[last + 1]:
        last += 1
    return float(time[first]), float(time[last])


def _unwrapped(rates: tuple[Any, Any]) -> Any:
    """Course from the rates along and across, counted back from the last one."""
    return np.unwrap(np.arctan2(rates[1], rates[0])[::-1])[::-1]


def _phases(time: Any, off: Any, climb: Any) -> Any:
    """(k,) index into `PHASES`; the courses may end earlier."""
    began, ended = last_turn(time[: len(off)], off)
    phase = np.full(len(time), PHASES.index("established"))
    phase[time < began] = PHASES.index("vectors")
    phase[(time >= began) & (time <= ended + SETTLING)] = PHASES.index("capture")
    phase[(time > ended + SETTLING) & (climb < -1.0)] = PHASES.index("glide")
    return phase
