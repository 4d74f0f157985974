"""What radar and downlink say of the flights of Glistin and Panasyuk, and the errors of a filter on it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from aircraft.state import AircraftState
from sim.claims.jsbsim_flights import flown
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
BEFORE, BEHIND = 40.0, 60.0  # s of the JSBSim flight before its turn onto final and behind it
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
    """What radar and downlink say of one flight."""

    measurements: Measurements
    azimuth: Any  # (k,) rad, true
    turning: Any  # (k,)
    prior: Gaussian


@lru_cache(maxsize=8)
def motion(flight: str) -> AircraftState:
    """The record of a flight, seen from the radar."""
    if flight != JSBSIM:
        return FLIGHTS[flight].fly(step=FINEST).state
    whole = flown(SCENARIO, ("until_s", 185.0))  # the turn is over a minute before
    turn = np.flatnonzero(whole.during("final_turn"))
    time = whole.state.time
    chosen = (time >= time[turn[0]] - BEFORE) & (time <= time[turn[-1]] + BEHIND)
    state = AircraftState(*(column[chosen] for column in whole.state))
    north, east, up = PLACE
    return state._replace(
        time=state.time - state.time[0], north=state.north - north, east=state.east - east, height=state.height - up
    )


@lru_cache(maxsize=16)
def case(seed: int, runs: int, flight: str, condition: str, spoil: Spoil = NOTHING) -> Case:
    """Scans of one flight, and the state at its start with a draw from the prior."""
    period, sigma = CONDITIONS[condition]
    state = motion(flight)
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
    exact = np.concatenate([radar[:, rows], link[:, np.maximum(rows - late, 0)]]).T[..., None]
    sigmas = np.array([SIGMA_RANGE, sigma, sigma, *SIGMAS_LINK])
    generator = stream(seed, 0, 0, f"glistin.{flight}.{condition}")
    z = exact + sigmas[:, None] * generator.standard_normal((*exact.shape[:2], runs))
    R = np.broadcast_to(np.diag(sigmas**2), (len(rows), 9, 9))
    rates = np.gradient(radar[:, :3], state.time[:3], axis=1, edge_order=2)[:, 0]
    start = np.stack([radar[:, 0], rates], axis=1).ravel()
    spread = np.array([100.0, 5.0, 2.0 * sigma, 0.002, 2.0 * sigma, 5e-4])
    prior = Gaussian(start[:, None] + spread[:, None] * generator.standard_normal((6, runs)), np.diag(spread**2))
    turning = np.abs(state.bank[rows]) > (DEGREE if flight != JSBSIM else 3.0 * DEGREE)
    turning[:SETTLED] = False
    return Case(Measurements(MEASURED, state.time[rows], state.time[rows], z, R), azimuth[rows], turning, prior)


def errors(tracker: LoadFactor, data: Case, aided: bool) -> Any:
    """Azimuth errors (k, runs), deg."""
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
    """A filter with some of its parameters."""
    formula: dict[str, Any] = {} if kind == "kinematic" else {"azimuth_acceleration": kind}
    return LoadFactor(MEASURED, 0.0, **formula, **fields)
