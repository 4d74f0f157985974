"""The experiment of Glistin and Panasyuk: the azimuth with and without load factors, in kinematics and on JSBSim."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from sim.claims.jsbsim_flights import per_flight
from sim.claims.papers.glistin.cases import FINE, SETTLED, SPOILS, Case, Spoil, built, case, errors
from sim.claims.papers.glistin.tuning import TUNED
from tracking.intervals import Interval, gain


@lru_cache(maxsize=64)
def squares(kind: str, seed: int, runs: int, flight: str, condition: str) -> Any:
    """Squared errors (k, runs) of a tuned filter, deg^2."""
    data = case(seed, runs, flight, condition)
    return errors(built(kind, TUNED[flight, condition][kind]), data, kind != "kinematic") ** 2


@lru_cache(maxsize=4)
def spoilt(seed: int, runs: int, flight: str) -> dict[Spoil, Any]:
    """Squared errors (k, runs) of the corrected filter with a residual, deg^2, by what is wrong with the downlink."""
    each = {spoil: case(seed, runs, flight, FINE, spoil) for spoil in SPOILS if flight in spoil.flights}
    first = next(iter(each.values()))
    z = np.concatenate([one.measurements.z for one in each.values()], axis=2)
    mean = np.concatenate([one.prior.mean for one in each.values()], axis=1)
    azimuth = np.concatenate([one.azimuth for one in each.values()], axis=1)
    together = first._replace(
        measurements=replace(first.measurements, z=z), azimuth=azimuth, prior=first.prior._replace(mean=mean)
    )
    kind = "corrected_residual"
    found = errors(built(kind, TUNED[flight, FINE][kind]), together, True) ** 2
    return dict(zip(each, np.split(found, len(each), axis=1), strict=True))


def ratio(data: Case, part: str, plain: Any, aided: Any, runs: int) -> Interval:
    """The RMSE of one filter over that of another in a part of the flight, of runs or flights."""
    turn = data.turning
    scans = np.arange(len(turn))[:, None]
    first, last = turn.argmax(axis=0), len(turn) - 1 - turn[::-1].argmax(axis=0)
    rest = ~turn & (scans >= SETTLED)
    among = {"turn": turn, "before": rest & (scans < first), "behind": rest & (scans > last), "all": turn | rest}[part]
    return gain(*(per_flight(np.nanmean(np.where(among, one, np.nan), axis=0), runs) for one in (plain, aided)))


def gained(kind: str, flight: str, condition: str, part: str = "turn") -> Any:
    """Measure of the azimuth RMSE without aid over that of an aided filter, both tuned."""

    def measured(seed: int, runs: int) -> Interval:
        plain, aided = (squares(name, seed, runs, flight, condition) for name in ("kinematic", kind))
        return ratio(case(seed, runs, flight, condition), part, plain, aided, runs)

    return measured


def gained_still(flight: str, spoil: Spoil, part: str = "turn") -> Any:
    """Measure of the same for the corrected filter with a residual and a downlink that is late or biased."""

    def measured(seed: int, runs: int) -> Interval:
        plain = squares("kinematic", seed, runs, flight, FINE)
        return ratio(case(seed, runs, flight, FINE), part, plain, spoilt(seed, runs, flight)[spoil], runs)

    return measured


def more_in_the_turn(kind: str, flight: str, condition: str, beside: str) -> Any:
    """Measure of the gain in the turn over that on the straight before it or behind it."""

    def measured(seed: int, runs: int) -> Interval:
        turn, straight = (gained(kind, flight, condition, part)(seed, runs) for part in ("turn", beside))
        value = turn.value / straight.value
        spread = math.hypot(math.log(turn.high / turn.value), math.log(straight.high / straight.value))
        return Interval(value, value * math.exp(-spread), value * math.exp(spread), runs)

    return measured
