"""The table of signals: quantities of a flight over time, which checks, figures and metrics read."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sim.flight.record import Flight
from sim.scenario.tables import Runway
from tracking.measurement import wrap

DOT = 0.35  # deg, of a glide-path needle [full scale 0.7 deg at 3 deg]


def height_error(flight: Flight, runway: Runway) -> np.ndarray:
    """Height above what the phase asks for, m: glide path or leg height, NaN in flare, roll-out and go-around.

    NaN too where no height is held, or nobody knows which.
    """
    state = flight.state
    wanted = np.array([leg.height for leg in flight.route.legs])[flight.leg]
    wanted = np.where(np.isnan(flight.command.height), np.nan, wanted)
    past, _ = runway.from_local(state.north, state.east)
    glide = (runway.aiming_point - past) * np.tan(runway.glide_path)
    wanted = np.where(flight.during("glide"), glide, wanted)
    wanted = np.where(flight.during(("flare", "ground", "go_around", "rollout")), np.nan, wanted)
    return np.asarray(state.height - wanted)


def bank_rate(flight: Flight) -> np.ndarray:
    """Rate of the bank angle, rad/s, from the body rates."""
    s = flight.state
    return np.asarray(
        s.roll_rate + np.tan(s.pitch) * (s.pitch_rate * np.sin(s.bank) + s.yaw_rate * np.cos(s.bank)),
    )


def crab(flight: Flight) -> np.ndarray:
    """Heading minus ground track, rad, -pi..pi."""
    s = flight.state
    return np.asarray(wrap(s.heading - s.course))


def glide_dots(flight: Flight, runway: Runway) -> np.ndarray:
    """Angle off the glide path seen from its foot, in dots of 0.35 deg."""
    past, _ = runway.from_local(flight.state.north, flight.state.east)
    distance = np.maximum(runway.aiming_point - past, 1.0)
    angle = np.arctan2(flight.state.height, distance) - runway.glide_path
    return np.where(flight.during("glide"), np.degrees(angle) / DOT, np.nan)


class Signal(NamedTuple):
    """One quantity of a flight over time: what ``[[checks]]`` accept and reports call by its label."""

    name: str
    """Key in checks; ends in ``_UNIT``."""

    unit: str
    """Unit suffix of the values, of their limits and of the name."""

    label: str
    """What reports call it, in words and without the unit."""

    of: Callable[[Flight, Runway], np.ndarray]
    """(k,) values in ``unit`` at the instants of the record; NaN where there is nothing to judge."""

    magnitude: bool = False
    """Whether a single upper limit is meant for its magnitude."""


SIGNALS: tuple[Signal, ...] = (
    Signal("bank_deg", "deg", "bank", lambda flight, runway: np.degrees(flight.state.bank), True),
    Signal("bank_rate_degps", "degps", "bank rate", lambda flight, runway: np.degrees(bank_rate(flight)), True),
    Signal("cross_track_m", "m", "cross-track", lambda flight, runway: flight.deviation.cross_track, True),
    Signal("height_error_m", "m", "height error", height_error, True),
    Signal("glide_dots", "dots", "off the glide path", glide_dots, True),
    Signal("airspeed_mps", "mps", "true airspeed", lambda flight, runway: flight.state.airspeed),
    Signal(
        "equivalent_airspeed_mps",
        "mps",
        "equivalent airspeed",
        lambda flight, runway: flight.state.equivalent_airspeed,
    ),
    Signal(
        "airspeed_error_mps",
        "mps",
        "true airspeed error",
        lambda flight, runway: flight.state.airspeed - flight.command.airspeed,
    ),
    Signal("sink_mps", "mps", "sink", lambda flight, runway: -flight.state.velocity_up),
    Signal("crab_deg", "deg", "crab", lambda flight, runway: np.degrees(crab(flight)), True),
)


def find(name: str) -> Signal | None:
    """The row of a name."""
    return next((row for row in SIGNALS if row.name == name), None)


def names() -> tuple[str, ...]:
    """Names of all signals, in the order of the table."""
    return tuple(row.name for row in SIGNALS)
