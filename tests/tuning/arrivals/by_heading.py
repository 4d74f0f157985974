"""Arrivals of another structure: an autopilot that commands courses, and a bank with a lag of second order.

Bank ``c{K (course wanted - course)}``, the course wanted being towards a point on the line so many seconds ahead and
limited by the intercept; the bank follows as a second-order lag, with no limit of its rate. The capture begins near the
deviation at which another course is asked for, or when the beam is alive, whichever is later; speeds fall in steps at
distances, at a constant deceleration; the wind grows with height. Nothing of it was fitted to recordings.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from tests.tuning.arrivals.record import Arrivals, between

FINAL_COURSE = np.radians(73.0)
DEPARTURES = ("offset", "bank")
STEP = 0.25  # s
KNOT = 1852.0 / 3600.0  # m/s
LONGEST = 1300.0  # s
LEFT_AFTER = 120.0  # s behind the engagement
ANTENNA = 3500.0  # m past the threshold, of the localiser
GLIDE = np.radians(3.0)


def arrivals(generator: np.random.Generator, count: int, departure: str | None = None) -> Arrivals:
    """``count`` arrivals; ``departure``, 120 s behind the engagement, is one of `DEPARTURES`."""
    side = generator.choice((-1.0, 1.0), count)
    limit = np.radians(between(generator, count, 20.0, 30.0))
    gain = between(generator, count, 1.0, 1.8)
    # course and deviation are a loop of second order with the time constants V / (g K) and this one, s
    look_ahead = 4.0 * between(generator, count, 0.7, 1.0) ** 2 * 85.0 / (STANDARD_GRAVITY * gain)
    frequency, damping = between(generator, count, 0.5, 1.6), between(generator, count, 0.6, 1.0)  # rad/s, -
    room = between(generator, count, 0.7, 1.1)  # of the deviation at which another course is asked for
    alive = np.radians(between(generator, count, 2.0, 3.0))  # of the beam
    intercept = np.radians(between(generator, count, 20.0, 45.0))
    first = intercept + np.radians(between(generator, count, 30.0, 90.0)) * (generator.random(count) < 0.75)
    base = generator.random(count) < 0.2  # and turned to the intercept late
    first = np.where(base, 0.5 * np.pi, first)
    turned_at = np.where(
        base, between(generator, count, 30.0, 40.0), between(generator, count, 40.0, 220.0)
    )  # s before
    distance = between(generator, count, 12e3, 25e3)  # m, on final where the heading meets the line
    level = between(generator, count, 600.0, 2200.0)
    wind, blows = between(generator, count, 0.0, 8.0), between(generator, count, 0.0, 2.0 * np.pi)  # m/s at 300 m
    steps = np.stack([between(generator, count, *speeds) for speeds in ((125.0, 140.0), (100.0, 120.0), (84.0, 96.0))])
    steps = np.concatenate((steps, [between(generator, count, 66.0, 76.0)]))  # m/s
    at = np.stack([distance + between(generator, count, 1e3, 12e3), distance + between(generator, count, -4e3, 4e3)])
    at = np.concatenate((at, [between(generator, count, 7e3, 10e3)]))  # m along the line, where each step ends
    slowing = between(generator, count, 0.3, 0.7)  # m/s2
    beam, bend = np.zeros(count), np.radians(between(generator, count, 0.005, 0.02))  # rad, a wandering course line
    # where the flight begins: back from the line along the two headings
    back = turned_at * steps[1], between(generator, count, 8e3, 14e3)
    along = -distance - back[0] * np.cos(intercept) - back[1] * np.cos(first)
    across = side * (back[0] * np.sin(intercept) + back[1] * np.sin(first))
    heading, bank, roll = -side * first, np.zeros(count), np.zeros(count)
    airspeed, flown = steps[0].copy(), np.zeros(count)
    engaged, departed, flying = np.full(count, np.nan), np.full(count, np.nan), np.ones(count, bool)
    rows: list[tuple[Any, ...]] = []
    each = round(1.0 / STEP)
    for number in range(round(LONGEST / STEP)):
        time = number * STEP
        height = np.minimum(np.maximum(300.0 - along, 0.0) * np.tan(GLIDE), level)
        blowing = wind * (np.maximum(height, 10.0) / 300.0) ** 0.2
        rate_along = airspeed * np.cos(heading) + blowing * np.cos(blows)
        rate_across = airspeed * np.sin(heading) + blowing * np.sin(blows)
        if number % each == 0:
            flying = flying & (along < -1500.0)
            rows.append((along, across, height, bank, heading, airspeed, rate_along, rate_across, flying))
            if not flying.any():
                break
        course, speed = np.arctan2(rate_across, rate_along), np.hypot(rate_along, rate_across)
        near = np.abs(across) < room * look_ahead * speed * intercept
        seen = np.abs(np.arctan2(across, ANTENNA - along)) < alive
        captured = np.isnan(engaged) & near & seen & (flown > back[1])
        engaged = np.where(captured, time, engaged)
        error = beam * (ANTENNA - along)
        wanted = -np.clip((across + error) / (look_ahead * speed), -intercept, intercept)
        on = np.isfinite(engaged)
        since = time - engaged
        if departure is not None:
            left = since >= LEFT_AFTER
            departed = np.where(left & np.isnan(departed), time, departed)
            if departure == "offset":
                beside = -np.clip((across + error - 300.0 * side) / (look_ahead * speed), -intercept, intercept)
                wanted = np.where(left, beside, wanted)
        given = -side * np.where(flown < back[1], first, intercept)
        command = np.clip(gain * np.where(on, wanted - course, _wrapped(given - heading)), -limit, limit)
        if departure == "bank":
            command = np.where(
                since >= LEFT_AFTER, np.where(since < LEFT_AFTER + 10.0, side * np.radians(10.0), 0.0), command
            )
        roll = roll + STEP * (frequency**2 * (command - bank) - 2.0 * damping * frequency * roll)
        bank = bank + STEP * roll
        turned = STEP * STANDARD_GRAVITY * np.tan(bank) / airspeed
        middle, heading = heading + 0.5 * turned, heading + turned
        target = steps[0]
        for speed_of, ends in zip(steps[1:], at, strict=True):
            target = np.where(-along < ends, speed_of, target)
        airspeed = np.maximum(airspeed - slowing * STEP * (airspeed > target), np.minimum(target, airspeed))
        along = along + STEP * (airspeed * np.cos(middle) + blowing * np.cos(blows))
        across = across + STEP * (airspeed * np.sin(middle) + blowing * np.sin(blows))
        flown = flown + STEP * speed
        kept = np.exp(-STEP * speed / 1500.0)
        beam = kept * beam + bend * np.sqrt(1.0 - kept**2) * generator.standard_normal(count)
    return Arrivals(*(np.stack(column) for column in zip(*rows, strict=True)), engaged, departed)


def _wrapped(angle: Any) -> Any:
    return (angle + np.pi) % (2.0 * np.pi) - np.pi
