"""Glistin, Panasyuk: load factors from the aircraft against a tuned azimuth filter without them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from sim.claims.ledger import Claim, Reading
from sim.claims.plots import Curve, Plot
from sim.claims.verdict import above
from sim.randomness import stream
from sim.truths.base_turn import BaseTurn
from sim.truths.near_pass import NearPass
from sim.truths.s_turn import STurn
from tracking.gaussian import Gaussian
from tracking.intervals import Interval, gain
from tracking.track import Measurements, follow
from tracking.trackers.load_factor import DOWNLINK, LoadFactor

DEGREE = math.pi / 180.0
RADAR = ("range", "azimuth", "elevation")
MEASURED = (*(f"radar.{name}" for name in RADAR), *(f"link.{name}" for name in DOWNLINK))
FLIGHTS: dict[str, Any] = {"base turn": BaseTurn(), "S-turn": STurn(), "near pass": NearPass()}
CONDITIONS = {"0.7 s, 1 deg": (0.7, DEGREE), "0.5 s, 0.15 deg": (0.5, 0.15 * DEGREE)}  # scan, sigma of the azimuth
SIGMA_RANGE = 30.0  # m
SIGMAS_LINK = np.array([0.01, 0.01, 0.01, 0.5 * DEGREE, 0.25 * DEGREE, 0.5 * DEGREE])
FINEST = 0.1  # s, of the truth's record; every scan and every latency is a multiple
SETTLED = 15  # scans
TUNING_SEED, TUNING_RUNS = 1, 30  # no row is reported on this seed
KINDS = ("kinematic", "published", "intended", "corrected", "corrected_residual")


class Case(NamedTuple):
    """What radar and downlink say of one flight."""

    measurements: Measurements
    azimuth: Any  # (k,) rad, true
    turning: Any  # (k,)
    prior: Gaussian


@lru_cache(maxsize=16)
def case(seed: int, runs: int, flight: str, condition: str, latency: float = 0.0) -> Case:
    """Scans of one flight, and the state at its start with a draw from the prior."""
    period, sigma = CONDITIONS[condition]
    state = FLIGHTS[flight].fly(step=FINEST).state
    stride, late = round(period / FINEST), round(latency / FINEST)
    rows = np.arange(stride, len(state.time), stride)
    level = np.hypot(state.north, state.east)
    azimuth = np.unwrap(np.arctan2(state.east, state.north))
    radar = np.stack([np.hypot(level, state.height), azimuth, np.arctan2(state.height, level)])
    forward, right, up = state.load_factor
    link = np.stack([forward, up, right, state.aerodynamic_bank, state.flight_path_angle, np.unwrap(state.air_course)])
    exact = np.concatenate([radar[:, rows], link[:, np.maximum(rows - late, 0)]]).T[..., None]
    sigmas = np.array([SIGMA_RANGE, sigma, sigma, *SIGMAS_LINK])
    generator = stream(seed, 0, 0, f"glistin.{flight}.{condition}")
    z = exact + sigmas[:, None] * generator.standard_normal((*exact.shape[:2], runs))
    R = np.broadcast_to(np.diag(sigmas**2), (len(rows), 9, 9))
    rates = np.gradient(radar, state.time, axis=1, edge_order=2)[:, 0]
    start = np.stack([radar[:, 0], rates], axis=1).ravel()
    spread = np.array([100.0, 5.0, 2.0 * sigma, 0.002, 2.0 * sigma, 5e-4])
    prior = Gaussian(start[:, None] + spread[:, None] * generator.standard_normal((6, runs)), np.diag(spread**2))
    turning = np.abs(state.bank[rows]) > DEGREE
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


def candidates(kind: str) -> list[dict[str, float]]:
    """The grid over which a filter is tuned; the range's noise belongs to it where the Coriolis term does."""
    if kind == "kinematic":
        grid = product((1e-7, 3e-7, 1e-6, 3e-6, 1e-5, 3e-5), (10.0, 40.0))
        return [{"kinematic_density": q, "kinematic_correlation_time": t} for q, t in grid]
    if kind in ("published", "intended"):
        return [{"azimuth_density": q} for q in (1e-8, 1e-7, 1e-6, 1e-5)]
    if kind == "corrected":
        return [{"azimuth_density": q, "range_density": r} for q, r in product((3e-10, 3e-9, 3e-8, 1e-7), (1e2, 1e4))]
    grid3 = product((1e-10, 1e-9, 1e-8), (5.0, 20.0), (1e2, 1e4))
    return [{"azimuth_density": q, "azimuth_correlation_time": t, "range_density": r} for q, t, r in grid3]


def built(kind: str, fields: dict[str, float]) -> LoadFactor:
    """A filter with some of its parameters."""
    base = LoadFactor(MEASURED, 0.0)
    named: Any = base if kind == "kinematic" else replace(base, azimuth_acceleration=kind)  # type: ignore[arg-type]
    return replace(named, **fields)  # type: ignore[arg-type]


def tune(kind: str, flight: str, condition: str) -> dict[str, float]:
    """The best of the grid over the whole flight, on the tuning seed."""
    data = case(TUNING_SEED, TUNING_RUNS, flight, condition)
    return min(
        candidates(kind),
        key=lambda fields: float((errors(built(kind, fields), data, kind != "kinematic")[SETTLED:] ** 2).mean()),
    )


def _long(density: float) -> dict[str, float]:
    return {"kinematic_density": density, "kinematic_correlation_time": 10.0}


def _corrected(density: float, range_density: float = 1e4) -> dict[str, float]:
    return {"azimuth_density": density, "range_density": range_density}


def _residual(density: float, memory: float) -> dict[str, float]:
    return {"azimuth_density": density, "azimuth_correlation_time": memory, "range_density": 1e4}


def _tuned(*fields: dict[str, float]) -> dict[str, dict[str, float]]:
    return dict(zip(KINDS, fields, strict=True))


# what `tune` chose, in the order of KINDS
COARSE, FINE = CONDITIONS
TUNED = {
    ("base turn", COARSE): _tuned(
        _long(3e-7), {"azimuth_density": 1e-7}, {"azimuth_density": 1e-7}, _corrected(3e-10, 1e2), _residual(1e-9, 5.0)
    ),
    ("base turn", FINE): _tuned(
        _long(3e-7), {"azimuth_density": 1e-7}, {"azimuth_density": 1e-7}, _corrected(3e-9), _residual(1e-9, 20.0)
    ),
    ("S-turn", COARSE): _tuned(
        _long(3e-6), {"azimuth_density": 1e-6}, {"azimuth_density": 1e-6}, _corrected(3e-8), _residual(1e-8, 5.0)
    ),
    ("S-turn", FINE): _tuned(
        _long(3e-6), {"azimuth_density": 1e-6}, {"azimuth_density": 1e-6}, _corrected(3e-8), _residual(1e-9, 5.0)
    ),
    ("near pass", COARSE): _tuned(
        _long(3e-5), {"azimuth_density": 1e-5}, {"azimuth_density": 1e-5}, _corrected(1e-7), _residual(1e-8, 5.0)
    ),
    ("near pass", FINE): _tuned(
        _long(1e-5), {"azimuth_density": 1e-5}, {"azimuth_density": 1e-5}, _corrected(1e-7), _residual(1e-8, 5.0)
    ),
}


@lru_cache(maxsize=64)
def squares(kind: str, seed: int, runs: int, flight: str, condition: str, latency: float = 0.0) -> Any:
    """Squared errors (k, runs) of a tuned filter, deg^2."""
    data = case(seed, runs, flight, condition, latency)
    return errors(built(kind, TUNED[flight, condition][kind]), data, kind != "kinematic") ** 2


def gained(kind: str, flight: str, condition: str, part: str = "turn", latency: float = 0.0) -> Any:
    """Measure of the azimuth RMSE without aid over that of an aided filter, both tuned."""

    def measured(seed: int, runs: int) -> Interval:
        data = case(seed, runs, flight, condition)
        rest = ~data.turning
        rest[:SETTLED] = False
        among = {"turn": data.turning, "straight": rest, "all": data.turning | rest}[part]
        plain = squares("kinematic", seed, runs, flight, condition)[among].mean(axis=0)
        return gain(plain, squares(kind, seed, runs, flight, condition, latency)[among].mean(axis=0))

    return measured


def more_in_the_turn(kind: str, flight: str, condition: str) -> Any:
    """Measure of the gain in the turn over that on the straights beside it."""

    def measured(seed: int, runs: int) -> Interval:
        turn, straight = (gained(kind, flight, condition, part)(seed, runs) for part in ("turn", "straight"))
        value = turn.value / straight.value
        spread = math.hypot(math.log(turn.high / turn.value), math.log(straight.high / straight.value))
        return Interval(value, value * math.exp(-spread), value * math.exp(spread), runs)

    return measured


CASES = [(flight, condition) for flight in FLIGHTS for condition in CONDITIONS]
TURNS = [(flight, condition) for flight, condition in CASES if flight != "near pass"]


def cases(kind: str, chosen: list[tuple[str, str]]) -> tuple[Reading, ...]:
    """A reading for each flight and condition."""
    return tuple(Reading(f"{flight}, {condition}", gained(kind, flight, condition)) for flight, condition in chosen)


ORDER = above(1.0)
OURS = "ours"
CLAIMS: tuple[Claim, ...] = (
    Claim(
        "smaller_error",
        "azimuth error is smaller than without the load factors",
        "fig. 1",
        ORDER,
        tuple(
            Reading(f"{flight}, {condition}, {part}", gained("published", flight, condition, part))
            for flight, condition in CASES
            for part in ("turn", "straight")
        ),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=100,
        note="The formula as published; both filters tuned on another seed. Over whole flights it helps in no case.",
    ),
    Claim(
        "smaller_error_corrected",
        "azimuth error is smaller than without the load factors, formula corrected",
        "fig. 1",
        ORDER,
        cases("corrected", TURNS),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=100,
        note="In the turn; with the printed step of delay.",
    ),
    Claim(
        "smaller_error_corrected_residual",
        "azimuth error is smaller than without the load factors, corrected and with a residual of its own",
        "fig. 1",
        ORDER,
        cases("corrected_residual", TURNS),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=100,
        note="In the turn; the residual is ours.",
    ),
    Claim(
        "most_in_manoeuvre",
        "above all in a manoeuvre",
        "fig. 1",
        ORDER,
        tuple(
            Reading(f"{kind}, {flight}, {condition}", more_in_the_turn(kind, flight, condition))
            for kind in ("published", "corrected")
            for flight, condition in TURNS
        ),
        "gain in the turn over gain beside it",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=100,
    ),
    Claim("airspace_capacity", "higher capacity of the airspace", "conclusions", None, (), note="No traffic is flown."),
    Claim(
        "latency",
        "gain in the turn with a downlink that is late, corrected and with a residual",
        "not said",
        None,
        tuple(
            Reading(f"{flight}, {late:g} s late", gained("corrected_residual", flight, FINE, "turn", late))
            for flight, late in (("base turn", 0.5), ("base turn", 4.0), ("S-turn", 0.5), ("S-turn", 1.0))
        ),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=100,
        overlooked=True,
    ),
)


def plots(seed: int) -> Iterator[Plot]:
    """Figure 1."""
    time = case(seed, 100, "base turn", FINE).measurements.time
    names = {
        "kinematic": "without load factors",
        "published": "formula as published",
        "corrected": "corrected",
        "corrected_residual": "corrected, with a residual",
    }
    curves = tuple(
        Curve(name, time, np.sqrt(squares(kind, seed, 100, "base turn", FINE).mean(axis=1)))
        for kind, name in names.items()
    )
    yield Plot("fig. 1", "Azimuth error", f"Base turn, {FINE}, 100 runs.", "time, s", "azimuth RMSE, deg", curves)
