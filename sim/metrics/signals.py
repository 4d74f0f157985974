"""What can be asked of a flight at every instant, in the units of its name; checks, figures and metrics read these."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sim.flight.record import Flight
from sim.scenario.tables import Runway

# A single upper limit on one of these is meant for its magnitude.
MAGNITUDES = {"bank_deg", "bank_rate_degps", "cross_track_m", "height_error_m", "crab_deg", "glide_dots"}
DOT = 0.35  # deg, of a glide-path needle [full scale 0.7 deg at 3 deg]


def height_error(flight: Flight, runway: Runway) -> np.ndarray:
    """Height above what the phase asks for, m: glide path or leg height, NaN in flare, roll-out and go-around."""
    state = flight.state
    wanted = np.array([leg.height for leg in flight.route.legs])[flight.leg]
    past, _ = runway.from_local(state.north, state.east)
    glide = (runway.aiming_point - past) * np.tan(runway.glide_path)
    wanted = np.where(flight.during("glide"), glide, wanted)
    wanted = np.where(flight.during(("flare", "ground", "go_around")), np.nan, wanted)
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
    return np.asarray(np.remainder(s.heading - s.course + np.pi, 2 * np.pi) - np.pi)


def glide_dots(flight: Flight, runway: Runway) -> np.ndarray:
    """Angle off the glide path seen from its foot, in dots of 0.35 deg."""
    past, _ = runway.from_local(flight.state.north, flight.state.east)
    distance = np.maximum(runway.aiming_point - past, 1.0)
    angle = np.arctan2(flight.state.height, distance) - runway.glide_path
    return np.where(flight.during("glide"), np.degrees(angle) / DOT, np.nan)


SIGNALS: dict[str, Callable[[Flight, Runway], np.ndarray]] = {
    "bank_deg": lambda flight, runway: np.degrees(flight.state.bank),
    "bank_rate_degps": lambda flight, runway: np.degrees(bank_rate(flight)),
    "cross_track_m": lambda flight, runway: flight.deviation.cross_track,
    "height_error_m": height_error,
    "glide_dots": glide_dots,
    "airspeed_error_mps": lambda flight, runway: flight.state.airspeed - flight.command.airspeed,
    "sink_mps": lambda flight, runway: -flight.state.velocity_up,
    "crab_deg": lambda flight, runway: np.degrees(crab(flight)),
}
