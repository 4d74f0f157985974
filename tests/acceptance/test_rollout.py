"""What the roll-out must show: energy, wind, a published landing run, and other aircraft on their runways."""

from __future__ import annotations

import math
import time
from functools import cache

import numpy as np
import pytest

from aircraft.state import STANDARD_GRAVITY
from sim.experiment import fly
from sim.flight import loop
from sim.flight.outcomes import STOPPED
from sim.flight.preparation import prepare
from sim.metrics.flight import flight_metrics
from sim.scenario.reading import read

pytestmark = pytest.mark.acceptance
AUTOMATIC = 8.2  # m, 27 ft: how far an automatic roll-out may stray to either side [FAA AC 20-57A, from memory]
PUBLISHED = 730.0  # m, landing run of the An-26 at 24 t [Jane's All the World's Aircraft, from memory]
RUNWAY = 80  # deg, of the bundled scenarios
BUNDLED = ("an26_pattern", "c172x", "a320", "b747")


@cache
def flown(name, *changes):
    prepared = prepare(read(name, {"start.phase": "final", **dict(changes)}))
    flight = fly(prepared)
    return flight, flight_metrics(flight, prepared.scenario.runway, prepared.law.bank_limit)


def wind(speed, off):
    """Overrides of a wind that comes from ``off`` deg to the right of where the runway points."""
    return () if not speed else (("wind.speed_mps", float(speed)), ("wind.from_deg", float((RUNWAY + off) % 360)))


def at_the_end(name, flight):
    """How far off the centreline it stopped, m."""
    s = flight.rollout.state
    return abs(prepare(read(name)).scenario.runway.from_local(float(s.north[-1]), float(s.east[-1]))[1])


def from_touchdown(flight, figures):
    """The record from the first contact to the stop."""
    whole = flight.whole
    first = int(np.searchsorted(whole.time, figures["touchdown"]["time_s"] - 1e-9))
    return type(whole.state)(*(np.asarray(column)[first:] for column in whole.state))


@pytest.mark.parametrize("mass", [16000, 20000, 24000])
def test_work_of_the_forward_specific_force(row, mass):
    flight, figures = flown("an26_pattern", ("aircraft.mass_kg", float(mass)))
    s = from_touchdown(flight, figures)
    work = -np.trapezoid(STANDARD_GRAVITY * s.load_factor[0] * s.ground_speed, s.time)
    energy = 0.5 * s.ground_speed[0] ** 2
    off = work / energy - 1.0
    told = f"{work * mass / 1e6:.3f} of {energy * mass / 1e6:.3f} MJ, {100 * off:+.2f} %"
    row(
        f"roll-out of {mass / 1000:.0f} t: work of the forward specific force",
        "kinetic energy +-2 %",
        told,
        abs(off) <= 0.02,
    )
    assert abs(off) <= 0.02


@pytest.mark.parametrize("off", [0, 180])
def test_distance_goes_with_the_square_of_the_ground_speed(row, off):
    speeds, distances = [], []
    for speed in (0, 6):
        flight, figures = flown("an26_pattern", *wind(speed, off))
        speeds.append(from_touchdown(flight, figures).ground_speed[0])
        distances.append(figures["rollout"]["distance_m"])
    ratio, square = distances[1] / distances[0], (speeds[1] / speeds[0]) ** 2
    what = f"roll-out in a {'head' if off == 0 else 'tail'} wind of 6 m/s over that in calm air"
    told = f"{distances[1]:.0f} / {distances[0]:.0f} m = {ratio:.3f}; ground speeds squared {square:.3f}"
    row(what, "as the square of the ground speed at touchdown, +-15 %", told, abs(ratio / square - 1.0) <= 0.15)
    assert abs(ratio / square - 1.0) <= 0.15


def test_beside_a_published_landing_run(row):
    """The published run is that of full brakes with the propellers at no pitch; ours of a medium deceleration."""
    flight, figures = flown("an26_pattern", ("aircraft.mass_kg", 24000.0))
    run, speed = figures["rollout"]["distance_m"], from_touchdown(flight, figures).ground_speed[0]
    held, shortest = speed**2 / 2.0 / (0.2 * STANDARD_GRAVITY), speed**2 / 2.0 / (0.3 * STANDARD_GRAVITY)
    told = f"{run:.0f} m from {speed:.1f} m/s; 0.2 g all the way would take {held:.0f} m, 0.3 g {shortest:.0f} m"
    row(
        "An-26, 24 t: landing run",
        f"beside {PUBLISHED:.0f} m [Jane's, from memory]",
        told,
        abs(run / PUBLISHED - 1) < 0.25,
    )
    assert run == pytest.approx(PUBLISHED, rel=0.25)


@pytest.mark.parametrize(("name", "speed"), [("an26_pattern", 10), *((name, 0) for name in BUNDLED)])
def test_each_stops_near_the_centreline(row, name, speed):
    flight, figures = flown(name, *wind(speed, 90))
    farthest, end = figures["rollout"]["cross_track_max_m"], at_the_end(name, flight)
    good = flight.rollout.outcome == STOPPED and farthest <= AUTOMATIC and end <= 3.0
    told = f"{flight.rollout.reason}; {farthest:.2f} m off at most, {figures['rollout']['distance_m']:.0f} m"
    row(f"{name}, crosswind {speed} m/s: roll-out", f"stops, <= {AUTOMATIC} m off, <= 3 m at the stop", told, good)
    assert good


@pytest.mark.parametrize(("name", "speed"), [("c172x", 6), ("a320", 10), ("b747", 10)])
def test_others_stay_on_the_runway_in_a_crosswind(row, name, speed):
    """Stock models that land fast or without spoilers: at first their tyres carry little and hold them as little."""
    flight, figures = flown(name, *wind(speed, 90))
    farthest, end = figures["rollout"]["cross_track_max_m"], at_the_end(name, flight)
    good = flight.rollout.outcome == STOPPED and end <= 3.0
    told = f"{flight.rollout.reason}; {farthest:.2f} m off at most"
    row(f"{name}, crosswind {speed} m/s: roll-out", "stays on the runway, <= 3 m at the stop", told, good)
    assert good


def test_what_it_costs(row):
    prepared = prepare(read("an26_pattern"))
    spent, rolled = [], loop.roll_out
    times = []

    def timed(*arguments):
        begun = time.process_time()
        flight = rolled(*arguments)
        spent.append(time.process_time() - begun)
        return flight

    loop.roll_out = timed
    try:
        for _ in range(5):
            begun = time.process_time()
            flight = loop.fly(
                prepared.vehicle,
                prepared.controller,
                prepared.initial,
                prepared.wind(0),
                prepared.limits,
                prepared.phases,
            )
            times.append(time.process_time() - begun)
    finally:
        loop.roll_out = rolled
    share = min(spent) / (min(times) - min(spent))
    longer = len(flight.rollout.time) / len(flight.time)
    told = f"{100 * share:.1f} % more CPU for {100 * longer:.1f} % more time"
    row("an26_pattern: cost of the roll-out", "as its time", told, share < 1.5 * longer)
    assert math.isfinite(share)
    assert share < 1.5 * longer  # a second on the wheels costs no more than one in the air, and half again for noise
