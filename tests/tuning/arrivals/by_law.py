"""Arrivals under the law of the route mode, which is engaged late on a heading that a controller gave.

Bank ``c{-k1 c1{z} - k2 c2{z'}}`` [Vasylyev 2003, eq. (4)] with gains and limits drawn for each aircraft from what was
fitted to recorded captures, through a limit of the roll rate and a lag of first order. Gains are drawn as frequency and
damping: of the fits these are the quantities that vary little, while k1 and k2 vary together. A law is drawn again that
could not hold the heading's closing speed, whose lag would make it swing, or whose bank limit needs more room for the
turn than the law asks for: no crew would engage it there.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from tests.tuning.arrivals.record import Arrivals, between, by_distance, drawn

FINAL_COURSE = np.radians(260.0)
DEPARTURES = ("offset", "bank", "beacon")
STEP = 0.25  # s, of the integration
ROLL_RATE = np.radians(5.0)  # rad/s
KNOT = 1852.0 / 3600.0  # m/s
LONGEST = 1300.0  # s
LEFT_AFTER = 120.0  # s behind the engagement, when an established aircraft leaves its law

# p5, 25, 50, 75, 95 of the laws fitted to recorded captures
K1 = (0.014, 0.037, 0.055, 0.079, 0.127)  # deg/m
DAMPING = (0.58, 0.74, 0.82, 0.89, 1.33)
POSITION_LIMIT = (93.0, 769.0, 976.0, 1323.0, 2222.0)  # m
BANK_LIMIT = (11.0, 17.0, 24.0, 28.0, 33.0)  # deg
LAG = (0.2, 0.6, 2.5, 5.7, 8.0)  # s


class Laws:
    """Laws of n aircraft of given airspeeds (n,), m/s, in winds, m/s, that have to turn by so much, rad."""

    def __init__(self, generator: np.random.Generator, airspeed: Any, wind: Any, turn: Any) -> None:
        count, closing = len(turn), airspeed * np.sin(turn)
        self.k1, self.k2, self.limit, self.bank_limit, self.lag = (np.full(count, np.nan) for _ in range(5))
        while (again := np.isnan(self.k1)).any():
            k1 = np.radians(drawn(generator, count, K1))
            frequency, damping = np.sqrt(STANDARD_GRAVITY * k1), drawn(generator, count, DAMPING)
            k2 = 2.0 * damping * frequency / STANDARD_GRAVITY
            limit, lag = drawn(generator, count, POSITION_LIMIT), drawn(generator, count, LAG)
            bank = np.radians(drawn(generator, count, BANK_LIMIT))
            # the loop s^2 (lag s + 1) + 2 d w s + w^2 is stable below a lag of 2 d / w
            good = again & (lag <= damping / frequency)
            good &= (0.8 * closing <= k1 * limit / k2) & (k1 * limit / k2 <= 0.95 * (airspeed - wind))
            good &= airspeed**2 / (STANDARD_GRAVITY * np.tan(bank)) * (1.0 - np.cos(turn)) <= k2 * closing / k1
            own = (self.k1, self.k2, self.limit, self.bank_limit, self.lag)
            for values, new in zip(own, (k1, k2, limit, bank, lag), strict=True):
                values[good] = new[good]

    def __call__(self, across: Any, rate: Any) -> Any:
        """Bank, rad."""
        position = self.k1 * np.clip(across, -self.limit, self.limit)
        return np.clip(-position - self.k2 * rate, -self.bank_limit, self.bank_limit)


def arrivals(generator: np.random.Generator, count: int, departure: str | None = None) -> Arrivals:
    """``count`` arrivals; ``departure``, 120 s behind the engagement, is one of `DEPARTURES`.

    ``offset`` flies on beside the line by 300 m, ``bank`` banks by 10 deg for 10 s and levels the wings, ``beacon`` has
    homed on the threshold from the engagement on.
    """
    side = generator.choice((-1.0, 1.0), count)
    headings, lengths = _vectors(generator, count)
    turn = np.abs(headings[-1])
    speeds, knots = _speeds(generator, count)
    wind, blows = between(generator, count, 0.0, 12.0), between(generator, count, 0.0, 2.0 * np.pi)
    wind_along, wind_across = wind * np.cos(blows), wind * np.sin(blows)
    distance = between(generator, count, 14e3, 28e3)  # m, on final at the engagement
    knots = knots + np.array((0.0, 0.0, 1.0, 1.0))[:, None] * distance
    fast = by_distance(distance, knots, speeds)
    law = Laws(generator, fast, wind, turn)
    late = between(generator, count, 0.0, 5.0)
    level = np.exp(generator.normal(np.log(1442.0), 0.45, count))  # m
    glide = np.radians(3.0)
    bends = _Bends(generator, count)

    ends = np.cumsum(lengths, axis=0)  # (headings, n) m, flown at the end of each
    total = ends[-1]
    along, across, flown = np.zeros(count), np.zeros(count), np.zeros(count)
    heading, bank = side * headings[0], np.zeros(count)
    engaged, arrived = np.full(count, np.nan), np.full(count, np.nan)
    departed, flying = np.full(count, np.nan), np.ones(count, bool)
    moved_along, moved_across = np.full(count, np.nan), np.full(count, np.nan)
    kept = np.exp(-STEP / law.lag)
    rows: list[tuple[Any, ...]] = []
    each = round(1.0 / STEP)
    for number in range(round(LONGEST / STEP)):
        time = number * STEP
        there = np.isfinite(arrived)
        to_go = np.where(there, -along, distance + total - flown)
        airspeed = by_distance(to_go, knots, speeds)
        rate_along = airspeed * np.cos(heading) + wind_along
        rate_across = airspeed * np.sin(heading) + wind_across
        # the last heading has led to where the law asks for a turn onto the line: there the line is
        closing = np.abs(rate_across)
        new = ~there & (flown >= total) & (side * rate_across < 0.0)
        if new.any():
            moved_along = np.where(new, -distance - along, moved_along)
            moved_across = np.where(new, side * law.k2 * closing / law.k1 - across, moved_across)
            along, across = np.where(new, -distance, along), np.where(new, across + moved_across, across)
            arrived = np.where(new, time, arrived)
        engaged = np.where(np.isnan(engaged) & (time >= arrived + late), time, engaged)
        if number % each == 0:
            height = np.minimum(np.maximum(to_go, 0.0) * np.tan(glide), level)
            flying = flying & (to_go > 1500.0)
            rows.append((along, across, height, bank, heading, airspeed, rate_along, rate_across, flying))
            if not flying.any():
                break
        # what is asked for
        which = np.minimum((flown >= ends).sum(axis=0), len(headings) - 1)
        asked = side * headings[which, np.arange(count)]
        vectored = np.clip(1.2 * _wrapped(asked - heading), -law.bank_limit, law.bank_limit)
        error, slope = bends(along)
        followed = law(across + error, rate_across + slope * rate_along)
        if departure is not None:
            since = time - engaged
            left = since >= (0.0 if departure == "beacon" else LEFT_AFTER)
            departed = np.where(left & np.isnan(departed), time, departed)
            if departure == "offset":
                followed = np.where(left, law(across + error - 300.0 * side, rate_across), followed)
            elif departure == "bank":
                hard, on = since < LEFT_AFTER + 10.0, side * np.radians(10.0)
                followed = np.where(left, np.where(hard, on, 0.0), followed)
            else:
                bearing = np.clip(np.arctan2(across, -along), -0.5, 0.5)
                homing = -law.k1 * 12e3 * bearing - law.k2 * airspeed * np.arctan2(rate_across, rate_along)
                followed = np.where(left, np.clip(homing, -law.bank_limit, law.bank_limit), followed)
        command = np.where(time >= engaged, followed, vectored)
        change = (command - bank) * (1.0 - kept)
        bank = bank + np.clip(change, -ROLL_RATE * STEP, ROLL_RATE * STEP)
        turned = STEP * STANDARD_GRAVITY * np.tan(bank) / airspeed
        middle, heading = heading + 0.5 * turned, heading + turned
        along = along + STEP * (airspeed * np.cos(middle) + wind_along)
        across = across + STEP * (airspeed * np.sin(middle) + wind_across)
        flown = flown + STEP * np.hypot(rate_along, rate_across)
    columns = [np.stack(column) for column in zip(*rows, strict=True)]
    before = np.arange(len(rows))[:, None] < arrived  # these rows are not yet in their place
    columns[0] = np.where(before, columns[0] + moved_along, columns[0])
    columns[1] = np.where(before, columns[1] + moved_across, columns[1])
    return Arrivals(*columns, engaged, departed)


def _vectors(generator: np.random.Generator, count: int) -> tuple[Any, Any]:
    """Headings relative to final on the right-hand side of the line (3, count), rad, and how far each is flown, m.

    The last is the intercept. Most are on it for half a minute or longer; some from a base leg, and some from downwind,
    are still turning when the law takes over, so that their last turn is one sweep onto final.
    """
    kind = generator.random(count)
    intercept = between(generator, count, 15.0, 50.0)
    base, downwind = kind < 0.29, kind < 0.15
    before = np.minimum(intercept + between(generator, count, 20.0, 90.0), 175.0)
    before = np.where(downwind, 180.0, np.where(base, between(generator, count, 60.0, 115.0), before))
    first = np.minimum(before + between(generator, count, 0.0, 60.0), 185.0)
    last = between(generator, count, 2500.0, 18e3) + np.where(generator.random(count) < 0.29, 22e3, 0.0)
    last = np.where(base, 30.0 * (before - intercept) + between(generator, count, 0.0, 500.0), last)
    angles = -np.radians(np.stack((first, before, intercept)))  # to the left, towards the line
    return angles, np.stack((between(generator, count, 9e3, 16e3), between(generator, count, 4e3, 14e3), last))


def _speeds(generator: np.random.Generator, count: int) -> tuple[Any, Any]:
    """True airspeeds (4, count) and the distances to the threshold at which they are flown (4, count), ascending.

    The last two distances count from the engagement.
    """
    approach = between(generator, count, 64.0, 78.0)
    drop = np.clip(generator.normal(35.0, 20.0, count), 0.0, 90.0) * KNOT
    captured = np.maximum(between(generator, count, 82.0, 100.0), approach + 2.0)
    knots = np.stack((np.full(count, 6e3), np.full(count, 9e3), np.full(count, -4.5e3), np.full(count, 1e3)))
    return np.stack((approach, captured, captured, captured + drop)), knots


class _Bends:
    """Errors of the course line along it, as of a localiser: three waves, drawn for each aircraft."""

    def __init__(self, generator: np.random.Generator, count: int) -> None:
        size = np.exp(generator.normal(np.log(3.0), 0.5, count)) / np.sqrt(3.0)  # m
        self.amplitude = np.sqrt(2.0) * size * np.ones((3, 1))
        self.wave = generator.uniform(3000.0, 12e3, (3, count))
        self.phase = generator.uniform(0.0, 2.0 * np.pi, (3, count))

    def __call__(self, along: Any) -> tuple[Any, Any]:
        """Error, m, and its slope."""
        angle = 2.0 * np.pi * along / self.wave + self.phase
        slope = self.amplitude * np.cos(angle) * 2.0 * np.pi / self.wave
        return (self.amplitude * np.sin(angle)).sum(axis=0), slope.sum(axis=0)


def _wrapped(angle: Any) -> Any:
    return (angle + np.pi) % (2.0 * np.pi) - np.pi
