"""Flights whose crew leaves the autopilot's law at stated times: what is flown instead, and from when."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

from autopilot.approach import Approach
from autopilot.departure import Departing, Displaced, HeldBank
from sim.flight.record import Event, Flight
from sim.scenario.tables import Departure


def controller(
    autopilot: Approach, law_called: Callable[[str], Any], departures: tuple[Departure, ...]
) -> Approach | Departing:
    """The autopilot, as long as it is not left; ``law_called`` gives the law of a mode by its name."""
    if not departures:
        return autopilot
    later = []
    for one in sorted(departures, key=lambda departure: departure.at):
        if one.bank is not None:
            law: Any = HeldBank(one.bank, autopilot.law.bank_limit)
        elif one.offset is not None:
            law = Displaced(autopilot.law, one.offset)
        else:
            law = law_called(one.flies)
        later.append((one.at, dataclasses.replace(autopilot, law=law)))
    return Departing(autopilot, tuple(later))


def with_departure_events(flight: Flight, departures: tuple[Departure, ...]) -> Flight:
    """The flight with its departures among the events."""
    if not departures:
        return flight
    left = [Event(one.at, "departure", in_words(one)) for one in departures if one.at <= flight.time[-1]]
    return dataclasses.replace(flight, events=tuple(sorted((*flight.events, *left), key=lambda event: event.time)))


def in_words(departure: Departure) -> str:
    """What is flown from then on."""
    if departure.bank is not None:
        side = "right" if departure.bank > 0.0 else "left"
        held = "wings level" if departure.bank == 0.0 else f"{math.degrees(abs(departure.bank)):.0f} deg to the {side}"
        return f"flown by hand, {held}"
    if departure.offset is not None:
        return f"the law flies {abs(departure.offset):.0f} m {'right' if departure.offset > 0.0 else 'left'} of the leg"
    return f"the {departure.flies.replace('_', ' ')} law flies"
