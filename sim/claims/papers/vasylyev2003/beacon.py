"""Law (5) of Vasylyev 2003 as a tracking case: homing on a radio beacon inside and outside its limits."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from sim.claims.jsbsim_flights import WIND, flights, per_flight
from sim.claims.ledger import DRAWS
from sim.claims.papers.vasylyev2003.experiment import DENSITY, PERIOD, Capture, seen, squares, tracker
from sim.flight.truths.beacon_homing import NOMINAL, BeaconHoming
from sim.randomness import stream
from tracking.intervals import Interval, gain
from tracking.reference_path import Line

Course = Literal["track", "heading"]
SCENARIO, TO_GO, CHARTED = "beacon_homing", 30e3, 72.0  # m at the start and m/s, of the scenario
UNTIL = ("until_s", 330.0)  # 3 km before the beacon in the fastest tail wind; nearer the law is ever stiffer
LASTS, STEP = 360.0, 0.5  # s of the 400 of the point mass
MODEL = BeaconHoming(acceleration_density=DENSITY)
CROSSWIND = 10.0  # m/s


class Start(NamedTuple):
    """Where a homing begins."""

    angle: float  # deg off the course, of the point mass; the law limits it to 5
    beside: tuple[float, float]  # m, between which the flights on JSBSim begin


LIMITED, UNLIMITED = Start(11.3, (5000.0, 7000.0)), Start(1.4, (400.0, 1000.0))
TRACK: Course = "track"
HEADING: Course = "heading"


@lru_cache(maxsize=6)
def homing(seed: int, runs: int, start: Start, course: Course, wind: float) -> Capture:
    """Homings of a point mass, ``wind`` (m/s) from the left; the filters are told the law, and of no wind."""
    law = replace(NOMINAL, course=course)
    motion = replace(MODEL, law=law, bearing=math.radians(start.angle), wind=(0.0, wind))
    generator = stream(seed, 0, 0, f"vasylyev2003.beacon.{start.angle}.{course}.{wind}")
    state = motion.fly(generator, runs, step=STEP).state
    rows = np.arange(0, round(LASTS / STEP) + 1, round(PERIOD / STEP))
    truth = np.stack([state.east[rows], state.velocity_east[rows]], axis=1)
    return seen(truth, runs, generator, PERIOD, law, MODEL.speed)._replace(line=Line(MODEL.speed, MODEL.distance))


@lru_cache(maxsize=4)
def six_degrees(seed: int, count: int, start: Start, course: Course) -> Capture:
    """Homings on JSBSim in drawn winds, each with all draws of its noise."""
    beside = ("start.cross_track_m", *start.beside)
    flown = flights(SCENARIO, seed, count, (beside, *WIND), UNTIL, ("autopilot.law.course", course))
    rows = np.concatenate([[0], flown[0].rows(PERIOD)])
    truth = np.stack([[one.state.east[rows], one.state.velocity_east[rows]] for one in flown], axis=-1)
    runs = np.repeat(truth, DRAWS, axis=-1).swapaxes(0, 1)
    generator = stream(seed, 0, 0, f"{SCENARIO}.{start.beside}.{course}")
    data = seen(runs, count * DRAWS, generator, PERIOD, flown[0].law, CHARTED)
    return data._replace(line=Line(CHARTED, TO_GO))


def homed(start: Start, course: Course = TRACK, wind: float = 0.0) -> Callable[[int, int], Interval]:
    """Measure of the RMSE of linear feedback over that of saturated control on the point mass."""

    def measured(seed: int, runs: int) -> Interval:
        data = homing(seed, runs, start, course, wind)
        return gain(*(squares(tracker(name, data), data) for name in ("linear", "saturated")))

    return measured


def homed_flown(start: Start, course: Course = TRACK) -> Callable[[int, int], Interval]:
    """The same on JSBSim, over flights."""

    def measured(seed: int, count: int) -> Interval:
        data = six_degrees(seed, count, start, course)
        return gain(*(per_flight(squares(tracker(name, data), data), count) for name in ("linear", "saturated")))

    return measured
