"""The functions behind the rows of the metric table; None where a figure does not apply to a flight."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import MAIN_WHEEL, STANDARD_GRAVITY, main_wheel_first
from autopilot.landing import SCREEN_HEIGHT
from sim.flight.outcomes import STOPPED
from sim.flight.record import RECORD_STEP, Flight
from sim.metrics.signals import bank_rate, crab, height_error
from sim.scenario.tables import Runway
from tracking.measurement import wrap

SETTLED = 0.02  # of the deviation at the start of the leg
SETTLED_LEAST = 5.0  # m; nothing smaller is asked of a capture that starts close
GLIDE_CAPTURE = 40.0  # s after glide entry that belong to the capture, not to the glide
DECISION_HEIGHT = 60.0  # m
FINAL_WINDOW = 5.0  # s, over which the speed of an approach is judged, as by its gate
LASTING = 60.0  # s; twice at the end of a flight
WATCHED = 180.0  # s, at the end; for periods of up to two minutes
LEAST = math.radians(1.0)  # of bank; less is no oscillation


class Navigation(NamedTuple):
    """How good the estimate was that an aircraft was flown on; None where it is not known."""

    error_rms: float | None = None  # m, across the leg
    rate_lag: float | None = None  # s, of the estimated rate across the leg behind the true one
    rate_lag_tolerated: float | None = None  # s, by the law that flew
    lost_time: float | None = None  # s, when the tracker was lost


class Context(NamedTuple):
    """What is known of a flight besides its record."""

    runway: Runway
    bank_limit: float  # rad, of the law that flew
    navigation: Navigation | None = None  # of the estimate that it was flown on; None = flown on the truth
    stall_speed: float | None = None  # m/s, equivalent, as it lands; None where none is known


def time_saturated(flight: Flight, context: Context) -> float | None:
    """Time at the bank limit, s; None where nobody knows the command."""
    if np.isnan(flight.command.bank).all():
        return None
    saturated = np.abs(flight.command.bank) >= context.bank_limit * (1 - 1e-6)
    return float(saturated.sum() * RECORD_STEP)


def overshoot(flight: Flight, context: Context) -> float | None:
    """How far the aircraft went to the other side of the last leg, m."""
    return _overshoot(flight, int(flight.leg.max()))


def base_overshoot(flight: Flight, context: Context) -> float | None:
    """The same of the leg before the last one."""
    last = int(flight.leg.max())
    return _overshoot(flight, last - 1) if last > 0 and flight.leg.min() < last else None


def _overshoot(flight: Flight, leg: int) -> float | None:
    """How far the aircraft went to the other side of a leg that it came to from one side, m."""
    on = _on_leg(flight, leg)
    if not on.any():
        return None
    z = flight.deviation.cross_track[on]
    return float(max(0.0, (-np.sign(z[0]) * z).max()))


def _on_leg(flight: Flight, leg: int) -> np.ndarray:
    """(k,) bool: where a leg was flown; who is vectored flies none yet, whatever lies ahead."""
    return np.asarray((flight.leg == leg) & ~flight.during("vectors"))


def settling(flight: Flight, context: Context) -> float | None:
    """Seconds from the start of the last leg until the deviation stays small."""
    on, z = np.flatnonzero(_on_leg(flight, int(flight.leg.max()))), flight.deviation.cross_track
    if not on.size:
        return None
    band = max(SETTLED * abs(z[on[0]]), SETTLED_LEAST)
    outside = on[np.abs(z[on]) > band]
    if not outside.size:
        return 0.0
    return float(flight.time[outside[-1]] - flight.time[on[0]]) if outside[-1] != on[-1] else None


def cross_track_rms(flight: Flight, context: Context) -> float | None:
    """RMS of the deviation on the settled glide path, else on the final leg, m."""
    glide = settled_glide(flight)
    if glide.any():
        return _rms(flight.deviation.cross_track[glide])
    several = len(flight.route.legs) > 1 or "established" in flight.phases
    on_final = flight.during(("final", "established", "glide")) if several else flight.leg == flight.leg.max()
    return _rms(flight.deviation.cross_track[on_final])


def settled_glide(flight: Flight) -> np.ndarray:
    """(k,) bool: the glide path without its capture."""
    glide = flight.during("glide")
    return np.asarray(glide & (flight.time >= flight.time[np.argmax(glide)] + GLIDE_CAPTURE))


def on_settled_glide(signal: Callable[[Flight, Context], np.ndarray]) -> Callable[[Flight, Context], float | None]:
    """A figure: the RMS of a signal on the settled glide path."""
    return lambda flight, context: _rms(signal(flight, context)[settled_glide(flight)])


def _rms(values: np.ndarray) -> float | None:
    values = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(values**2))) if values.size else None


def normal_acceleration(flight: Flight, context: Context) -> np.ndarray:
    """Acceleration along the lift in excess of that which carries the weight, m/s2."""
    return np.asarray(STANDARD_GRAVITY * (flight.state.load_factor[2] - 1.0))


def height_errors(flight: Flight, context: Context) -> np.ndarray:
    """Height above what the phase asks for, m."""
    return height_error(flight, context.runway)


def cross_track(flight: Flight, context: Context) -> np.ndarray:
    """Deviation from the leg that was active, m."""
    return np.asarray(flight.deviation.cross_track)


def at_height(
    height: float, signal: Callable[[Flight, Context], np.ndarray]
) -> Callable[[Flight, Context], float | None]:
    """A figure: the value of a signal when the final approach passes a height (m) downwards."""

    def of(flight: Flight, context: Context) -> float | None:
        low = np.flatnonzero((flight.state.height <= height) & flight.during(("glide", "flare")))
        return float(signal(flight, context)[low[0]]) if low.size else None

    return of


class Touchdown(NamedTuple):
    """The first contact with the ground; sink, drift, angles and airspeed are those of the last instant before it."""

    time: float  # s
    past_threshold: float  # m
    cross_track: float  # m right of the centreline
    sink: float  # m/s
    drift: float  # m/s to the right
    crab: float  # rad, heading less the runway's
    bank: float  # rad
    pitch: float  # rad
    airspeed: float  # m/s, true
    equivalent_airspeed: float  # m/s
    first_contact: int  # sum of ``aircraft.state.PARTS`` that touched first
    before: int  # index of that instant


def touchdown(flight: Flight, runway: Runway) -> Touchdown | None:
    """How the aircraft touched down; None where it did not, or was on its wheels from the beginning."""
    contact = np.flatnonzero((flight.state.main_wheels > 0) | (flight.state.first_contact > 0))
    if not contact.size or contact[0] == 0:
        return None
    at, before = contact[0], contact[0] - 1
    s = flight.state
    past, across = runway.from_local(s.north[at], s.east[at])
    along = np.cos(runway.heading), np.sin(runway.heading)
    return Touchdown(
        time=s.time[at],
        past_threshold=past,
        cross_track=across,
        sink=-s.velocity_up[before],
        drift=s.velocity_east[before] * along[0] - s.velocity_north[before] * along[1],
        crab=wrap(s.heading[before] - runway.heading),
        bank=s.bank[before],
        pitch=s.pitch[before],
        airspeed=s.airspeed[before],
        equivalent_airspeed=s.equivalent_airspeed[before],
        first_contact=int(np.broadcast_to(s.first_contact, s.time.shape)[at]) or MAIN_WHEEL,
        before=int(before),
    )


def at_touchdown(value: Callable[[Touchdown], float]) -> Callable[[Flight, Context], float | None]:
    """A figure of the touchdown."""

    def of(flight: Flight, context: Context) -> float | None:
        down = touchdown(flight, context.runway)
        return None if down is None else float(value(down))

    return of


def touchdown_over_stall(flight: Flight, context: Context) -> float | None:
    """Equivalent airspeed at the touchdown over the stall speed."""
    down = touchdown(flight, context.runway)
    return None if down is None or context.stall_speed is None else down.equivalent_airspeed / context.stall_speed


def final_over_stall(flight: Flight, context: Context) -> float | None:
    """Least mean over 5 s of the equivalent airspeed over the stall speed, on the glide path down to 50 ft.

    Below, a landing slows down from the reference speed on purpose.
    """
    window = flight.during("glide") & (flight.state.height > SCREEN_HEIGHT)
    speeds, width = flight.state.equivalent_airspeed[window], round(FINAL_WINDOW / RECORD_STEP)
    if context.stall_speed is None or len(speeds) < width:
        return None
    total = np.concatenate(([0.0], np.cumsum(speeds)))
    return float((total[width:] - total[:-width]).min() / width / context.stall_speed)


def touchdown_main_first(flight: Flight, context: Context) -> float | None:
    """1 where a main wheel touched first, or all three points of a tail-dragger, else 0."""
    down = touchdown(flight, context.runway)
    return None if down is None else float(main_wheel_first(down.first_contact))


def touchdown_track_crab(flight: Flight, context: Context) -> float | None:
    """Heading less the ground track's at the touchdown, deg."""
    down = touchdown(flight, context.runway)
    return None if down is None else float(np.degrees(crab(flight)[down.before]))


class RolledOut(NamedTuple):
    """From the first contact to the stop; what asks for a stop is None where the aircraft did not come to one."""

    distance: float | None  # m, along the runway
    time: float | None  # s
    deceleration: float | None  # m/s2, mean over the time
    cross_track: float  # m, the greatest distance from the centreline on either side


def rolled_out(flight: Flight, runway: Runway) -> RolledOut | None:
    """The roll-out of a flight; None where there was none."""
    down = touchdown(flight, runway)
    if down is None or flight.rollout is None:
        return None
    s = flight.whole.state
    past, across = runway.from_local(s.north, s.east)
    farthest = float(np.abs(across[down.before + 1 :]).max())
    if flight.rollout.outcome != STOPPED:
        return RolledOut(None, None, None, farthest)
    time = float(s.time[-1] - down.time)
    slowed = s.ground_speed[down.before + 1] - s.ground_speed[-1]
    return RolledOut(float(past[-1] - down.past_threshold), time, float(slowed / time), farthest)


def in_rollout(value: Callable[[RolledOut], float | None]) -> Callable[[Flight, Context], float | None]:
    """A figure of the roll-out."""

    def of(flight: Flight, context: Context) -> float | None:
        rolled = rolled_out(flight, context.runway)
        return None if rolled is None else value(rolled)

    return of


def of_navigation(value: Callable[[Navigation], float | None]) -> Callable[[Flight, Context], float | None]:
    """A figure of the estimate that the aircraft was flown on."""
    return lambda flight, context: None if context.navigation is None else value(context.navigation)


def bank_cycle(flight: Flight) -> tuple[float, float | None]:
    """Amplitude (rad) of the bank that persisted for the last minute, and its period (s), None without an oscillation.

    The amplitude is half the way from peak to peak, the smaller of those of the last two minutes, so that an
    oscillation that dies out does not count.
    """
    left, bank = flight.time[-1] - flight.time, flight.state.bank
    minutes = [bank[left < LASTING], bank[(left >= LASTING) & (left <= 2.0 * LASTING)]]
    amplitude = min(0.5 * float(np.ptp(minute)) if minute.size else 0.0 for minute in minutes)
    last = left <= WATCHED
    return amplitude, _period(flight.time[last], bank[last]) if amplitude >= LEAST else None


def _period(time: Any, bank: Any) -> float | None:
    """Mean time between every other passage through the middle; None with less than three of them."""
    level = bank - 0.5 * (bank.max() + bank.min())
    at = np.flatnonzero((level[:-1] < 0.0) != (level[1:] < 0.0))
    if len(at) < 3:
        return None
    passed = time[at] + (time[at + 1] - time[at]) * level[at] / (level[at] - level[at + 1])
    return float((passed[2:] - passed[:-2]).mean())


def rates_on_bank(flight: Flight, context: Context) -> np.ndarray:
    """Rate of the bank angle, deg/s."""
    return np.asarray(np.degrees(bank_rate(flight)))
