"""What radar and downlink say of the flights of Glistin and Panasyuk, and the errors of a filter on it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.claims.jsbsim_flights import WIND, flights
from sim.claims.ledger import DRAWS
from sim.flight.truths.base_turn import BaseTurn
from sim.flight.truths.near_pass import NearPass
from sim.flight.truths.s_turn import STurn
from sim.randomness import stream
from tracking.gaussian import Gaussian
from tracking.track import Measurements, follow
from tracking.trackers.load_factor import DOWNLINK, LoadFactor

DEGREE = math.pi / 180.0
RADAR = ("range", "azimuth", "elevation")
MEASURED = (*(f"radar.{name}" for name in RADAR), *(f"link.{name}" for name in DOWNLINK))
FLIGHTS: dict[str, BaseTurn | STurn | NearPass] = {"base turn": BaseTurn(), "S-turn": STurn(), "near pass": NearPass()}
JSBSIM, SCENARIO = "turn onto final", "glistin_jsbsim"  # the flight, and who flies it
CONDITIONS = {"0.7 s, 1 deg": (0.7, DEGREE), "0.5 s, 0.15 deg": (0.5, 0.15 * DEGREE)}  # scan, sigma of the azimuth
COARSE, FINE = CONDITIONS
SIGMA_RANGE = 30.0  # m
SIGMAS_LINK = np.array([0.01, 0.01, 0.01, 0.5 * DEGREE, 0.25 * DEGREE, 0.5 * DEGREE])
FINEST = 0.1  # s, of the truth's record; every scan and every latency is a multiple
BEFORE, SINCE = 40.0, 105.0  # s of a JSBSim flight before its turn onto final, and since: a turn takes 38 to 48 s
TURNED = 230.0  # s, by when every turn is over for as long
# rad clockwise from the final leg: directions of the axis X of the formula as published, which depends on it
AXES = {f"published, X at {degrees} deg": degrees * DEGREE for degrees in (45, 90, 135)}
PLACE = (1200.0, 150.0, 3.0)  # m, of the radar of that flight: past the threshold, right, up
SETTLED = 15  # scans


class Spoil(NamedTuple):
    """What is wrong with the downlink, unsaid."""

    flights: tuple[str, ...] = ()  # on which it is looked at
    late: float = 0.0  # s
    quantity: str = ""  # that is biased
    error: float = 0.0  # of it, SI


NOTHING = Spoil()
LATE = {late: Spoil(("base turn", "S-turn"), late) for late in (0.5, 1.0, 2.0, 4.0)}
BIASED = {
    text: Spoil(("base turn",), 0.0, quantity, error)
    for text, quantity, error in (
        ("bank 1 deg", "aerodynamic_bank", DEGREE),
        ("bank 3 deg", "aerodynamic_bank", 3.0 * DEGREE),
        ("load factor up 0.02", "load_factor_up", 0.02),
        ("load factor forward 0.05", "load_factor_forward", 0.05),
        ("load factor right 0.05", "load_factor_right", 0.05),
        ("course 5 deg", "air_course", 5.0 * DEGREE),
    )
}
SPOILS = (*LATE.values(), *BIASED.values())


class Case(NamedTuple):
    """What radar and downlink say of one flight, or of several of one length."""

    measurements: Measurements
    azimuth: Any  # (k, runs) rad, true
    turning: Any  # (k, runs)
    prior: Gaussian


@lru_cache(maxsize=8)
def motions(flight: str, seed: int, count: int) -> tuple[AircraftState, ...]:
    """Records of one length, seen from the radar: a prescribed flight, or ``count`` of JSBSim's in drawn winds."""
    if flight != JSBSIM:
        return (FLIGHTS[flight].fly(step=FINEST).state,)
    north, east, up = PLACE
    found = []
    for whole in flights(SCENARIO, seed, count, WIND, ("until_s", TURNED)):
        time = whole.state.time
        begun = time[np.argmax(whole.during("final_turn"))] - BEFORE
        chosen = np.arange(round((BEFORE + SINCE) / (time[1] - time[0])) + 1) + np.searchsorted(time, begun)
        state = AircraftState(*(column[chosen] for column in whole.state))
        place = {"north": state.north - north, "east": state.east - east, "height": state.height - up}
        found.append(state._replace(time=time[: len(chosen)], **place))
    return tuple(found)


class Seen(NamedTuple):
    """What would be measured of one flight without noise, and its state at the start."""

    exact: Any  # (k, 9)
    start: Any  # (6,)
    azimuth: Any  # (k,) rad
    turning: Any  # (k,)


def without_noise(state: AircraftState, period: float, spoil: Spoil, least_bank: float) -> Seen:
    """Scans of a flight, which turns where its bank is more than the least."""
    step = state.time[1] - state.time[0]
    stride, late = round(period / step), round(spoil.late / step)
    rows = np.arange(stride, len(state.time), stride)
    level = np.hypot(state.north, state.east)
    azimuth = np.unwrap(np.arctan2(state.east, state.north))
    radar = np.stack([np.hypot(level, state.height), azimuth, np.arctan2(state.height, level)])
    forward, right, up = state.load_factor
    link = np.stack([forward, up, right, state.aerodynamic_bank, state.flight_path_angle, np.unwrap(state.air_course)])
    if spoil.quantity:
        link[DOWNLINK.index(spoil.quantity)] += spoil.error
    exact = np.concatenate([radar[:, rows], link[:, np.maximum(rows - late, 0)]]).T
    rates = np.gradient(radar[:, :3], state.time[:3], axis=1, edge_order=2)[:, 0]
    turning = np.abs(state.bank[rows]) > least_bank
    turning[:SETTLED] = False
    return Seen(exact, np.stack([radar[:, 0], rates], axis=1).ravel(), azimuth[rows], turning)


@lru_cache(maxsize=16)
def case(seed: int, runs: int, flight: str, condition: str, spoil: Spoil = NOTHING) -> Case:
    """Scans, and the state at the start with a draw from the prior; on JSBSim a run is a flight with all its draws."""
    period, sigma = CONDITIONS[condition]
    least_bank, draws = (3.0 * DEGREE, DRAWS) if flight == JSBSIM else (DEGREE, runs)
    each = [without_noise(state, period, spoil, least_bank) for state in motions(flight, seed, runs)]
    exact, start, azimuth, turning = (
        np.repeat(np.stack(part, axis=-1), draws, axis=-1) for part in zip(*each, strict=True)
    )
    sigmas = np.array([SIGMA_RANGE, sigma, sigma, *SIGMAS_LINK])
    spread = np.array([100.0, 5.0, 2.0 * sigma, 0.002, 2.0 * sigma, 5e-4])
    generator = stream(seed, 0, 0, f"glistin.{flight}.{condition}")
    z = exact + sigmas[:, None] * generator.standard_normal(exact.shape)
    prior = Gaussian(start + spread[:, None] * generator.standard_normal(start.shape), np.diag(spread**2))
    time = period * np.arange(1, len(exact) + 1)
    R = np.broadcast_to(np.diag(sigmas**2), (len(time), 9, 9))
    return Case(Measurements(MEASURED, time, time, z, R), azimuth, turning, prior)


def turned(data: Case, zero: float) -> Case:
    """The same seen by a radar whose azimuths count from ``zero`` (rad, clockwise from north)."""
    z, mean = np.array(data.measurements.z), np.array(data.prior.mean)
    z[:, RADAR.index("azimuth")] -= zero
    mean[2] -= zero
    return data._replace(
        measurements=replace(data.measurements, z=z), azimuth=data.azimuth - zero, prior=data.prior._replace(mean=mean)
    )


def errors(tracker: LoadFactor, data: Case, aided: bool) -> Any:
    """Azimuth errors (k, runs), deg."""
    data = turned(data, tracker.zero_azimuth)
    seen = data.measurements
    if not aided:
        z = np.array(seen.z)
        z[:, len(RADAR) :] = np.nan
        seen = replace(seen, z=z)
    found = np.array(
        [epoch.estimate.mean[2] - data.azimuth[epoch.row] for epoch in follow(tracker, seen, data.prior, start=0.0)]
    )
    return np.degrees(np.angle(np.exp(1j * found)))


def built(kind: str, fields: dict[str, Any]) -> LoadFactor:
    """A filter with some of its parameters; of the formula as published also one for every direction of its axis X."""
    formula, zero = ("published", AXES[kind]) if kind in AXES else (kind, 0.0)
    aid: dict[str, Any] = {} if kind == "kinematic" else {"azimuth_acceleration": formula}
    return LoadFactor(MEASURED, zero, **aid, **fields)
