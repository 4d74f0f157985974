"""The landing patterns that the radar of Volovyk 2022 sees: of a point mass, from any direction, and of JSBSim."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sim.claims.jsbsim_flights import Flown, Ranges, flights
from sim.claims.ledger import DRAWS
from sim.flight.truths.landing_pattern import BASE, FINAL, FINAL_TURN, GLIDE, GROUND, LandingPattern
from sim.flight.truths.madap import Madap
from sim.randomness import stream

SCAN, STEP = 0.7, 0.35  # s
SCENARIO = "volovyk2022_jsbsim"
PHASES = {"base": BASE, "final_turn": FINAL_TURN, "final": FINAL, "glide": GLIDE, "flare": GLIDE}
LEFT, RIGHT, ALL_ENTRIES, JSBSIM, JSBSIM_RIGHT = "left", "right", "entries", "jsbsim", "jsbsim right"
TURNS = (0, 30, 60, 90, 120, 150, 180)  # deg onto final
SHARPEST = 120  # deg that the law turns onto one leg; more are flown as a turn onto the base leg before
BEFORE, BANK = 5000.0, math.radians(15.0)  # m straight before that turn, rad
FINER = 7  # records of that turn within a scan
ENTRIES = [(LEFT, turn) for turn in TURNS] + [(RIGHT, turn) for turn in TURNS[1:]]
EACH = 20  # runs of an entry: entries are many, and what they show is large
FLIGHTS: Ranges = (  # the runway points to 80 deg, and one lands into the wind
    ("start.distance_m", 5000.0, 9000.0),
    ("wind.from_deg", -10.0, 170.0),
    ("wind.speed_mps", 0.0, 10.0),
)


class Path(NamedTuple):
    """What is flown, at every scan."""

    time: Any  # (k,)
    place: Any  # (k, 2, runs) north, east
    phase: Any  # (k, runs)
    start: Any  # (4,) or (4, runs): north, its rate, east, its rate


@lru_cache(maxsize=4)
def pattern(seed: int, runs: int, turn: int = 90) -> Path:
    """The left-hand landing pattern; ``turn`` is the change of course onto final, deg."""
    if turn > SHARPEST:
        return preceded(pattern(seed, runs), turn)
    motion = LandingPattern(turn=math.radians(turn))
    flight = motion.fly(stream(seed, 0, 0, f"volovyk2022.air.{turn}"), runs, step=STEP)
    stride = round(SCAN / STEP)
    rows = np.arange(stride, len(flight.time), stride)
    state = flight.state
    start = [np.ravel(value[0])[0] for value in (state.north, state.velocity_north, state.east, state.velocity_east)]
    place = np.stack([state.north[rows], state.east[rows]], axis=1)
    return Path(flight.time[rows], place, flight.phase[rows], np.array(start))


def preceded(path: Path, turn: int) -> Path:
    """The pattern after a straight and a turn onto its base leg, so that course changes by ``turn`` (deg) in all."""
    north, north_rate, east, east_rate = path.start
    speed, course = math.hypot(north_rate, east_rate), math.atan2(east_rate, north_rate)
    change = math.radians(turn) - 0.5 * math.pi
    leg = Madap(speed, BANK, straight=BEFORE, turn=-change, after=1.0, course=course + change)
    joined = leg.fly(step=SCAN / FINER).state
    first = (len(joined.time) - 1) % FINER
    rows = np.arange(first, len(joined.time), FINER)  # every scan, the last where the pattern begins
    moved = (joined.north - joined.north[-1] + north)[rows], (joined.east - joined.east[-1] + east)[rows]
    before = np.stack(moved, axis=1)[..., None]
    return Path(
        SCAN * np.arange(1, len(rows) + len(path.time)),
        np.concatenate([np.broadcast_to(before[1:], (len(rows) - 1, *path.place.shape[1:])), path.place]),
        np.concatenate([np.full((len(rows) - 1, path.phase.shape[1]), BASE), path.phase]),
        np.array([before[0, 0, 0], joined.velocity_north[first], before[0, 1, 0], joined.velocity_east[first]]),
    )


def mirrored(path: Path) -> Path:
    """The same on the other side of the centreline."""
    return path._replace(place=path.place * [[1.0], [-1.0]], start=path.start * [1.0, 1.0, -1.0, -1.0])


def six_degrees(seed: int, count: int, truth: str) -> Path:
    """Patterns that JSBSim flies, DRAWS runs of each flight; a flight begins on the base leg, in a steady wind."""
    side = LEFT if truth == JSBSIM else RIGHT
    paths = [flown_path(flight) for flight in flights(SCENARIO, seed, count, FLIGHTS, ("route.side", side))]
    return together(paths, DRAWS)


def flown_path(flight: Flown) -> Path:
    """One flight."""
    rows, s = flight.rows(SCAN), flight.state
    names = np.array([PHASES.get(name, GROUND) for name in flight.flight.phases])
    place = np.stack([s.north[rows], s.east[rows]], axis=1)[..., None]
    start = np.array([s.north[0], s.velocity_north[0], s.east[0], s.velocity_east[0]])
    return Path(s.time[rows], place, names[flight.flight.phase[rows]][:, None], start)


def entered(seed: int) -> Path:
    """All entries side by side, EACH runs of each."""
    paths = {turn: pattern(seed, EACH, turn) for turn in TURNS}
    return together([paths[turn] if side == LEFT else mirrored(paths[turn]) for side, turn in ENTRIES])


def together(paths: Sequence[Path], times: int = 1) -> Path:
    """Paths as one, every run of each ``times`` times; those that have landed stand still."""
    longest = max(paths, key=lambda path: len(path.time))
    k = len(longest.time)

    def padded(values: Any, after: Any) -> Any:
        behind = np.repeat(after, k - len(values), axis=0)
        return np.repeat(np.concatenate([values, behind]), times, axis=-1)

    place = np.concatenate([padded(path.place, path.place[-1:]) for path in paths], axis=2)
    phase = [padded(path.phase, np.full((1, path.phase.shape[1]), GROUND)) for path in paths]
    start = [np.repeat(path.start[:, None], path.place.shape[2] * times, axis=1) for path in paths]
    return Path(longest.time, place, np.concatenate(phase, axis=1), np.concatenate(start, axis=1))
