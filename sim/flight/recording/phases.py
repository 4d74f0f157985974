"""How a recorded approach was flown, read off its motion and the line of the runway.

- vectors: all before the capture, and a flight that never gets onto the line.
- capture: from the end of the last straight stretch that led to the line, a bank (mean over `CALM` seconds) within
  `LEVEL` for `STRAIGHT` seconds at more than `ON_COURSE` from the runway's course, until it is established. A flight
  that was on the course from the beginning has none.
- established: on the line to the end, from when it is first within `NEAR` metres of it and `ON_COURSE` of its course
  and leaves `LEFT` and `OFF_COURSE` no more before the threshold.
- glide: established, sinking at half the slope of the glide path or more, and near it to the end: within half its
  needle, `HALF_SCALE`, and `LEAST` metres.
- ground: past the threshold on the runway, from where it sinks no more, `LEVELLED`, unless it climbs away again.
  Heights are not trusted to a few metres, so it is the end of the sink that counts.
"""

from __future__ import annotations

import math

import numpy as np

from autopilot.last_turn import bank_of_turn
from sim.flight.recording.smoothing import Path
from sim.scenario.tables import Runway
from tracking.measurement import wrap

PHASES = ("vectors", "capture", "established", "glide", "ground")
VECTORS, CAPTURE, ESTABLISHED, GLIDE, GROUND = range(len(PHASES))
LEVEL, STRAIGHT, CALM = math.radians(3.0), 10.0, 5.0  # rad, s, s; a bank read off jittering places is 1 deg wrong
NEAR, ON_COURSE = 100.0, math.radians(5.0)  # m, rad: as the autopilot of this program calls itself established
LEFT, OFF_COURSE = 300.0, math.radians(15.0)
HALF_SCALE, LEAST = math.radians(0.35), 30.0  # rad at the foot of the glide path, m
SINKING = 0.5  # of the slope of the glide path
ASIDE, LOW = 60.0, 60.0  # m from the centreline, and above or below the threshold: what an altimeter may be off
LEVELLED, AGAIN = 0.5, 15.0  # m/s of sink or climb, m of height that a landed aircraft does not regain


def bank_of(path: Path) -> np.ndarray:
    """(k,) rad, + right, of a coordinated turn in still air: ``tan(bank) = V (turn rate) / g``, over the ground.

    That is the acceleration across the track over gravity. In a steady wind W it is off by up to W/V of itself, since
    speed and turn rate are then those over the ground; see docs/recordings.md for what is left of a known bank.
    """
    (north, east, _), (pushed_north, pushed_east, _) = path.velocity, path.acceleration
    speed = np.maximum(np.hypot(north, east), 1.0)
    return np.asarray(bank_of_turn(speed, (north * pushed_east - east * pushed_north) / speed**2))


def phases_of(path: Path, runway: Runway) -> np.ndarray:
    """(k,) index into `PHASES` at instants of one step."""
    past, right = runway.from_local(path.position[0], path.position[1])
    off_course = np.abs(wrap(np.arctan2(path.velocity[1], path.velocity[0]) - runway.heading))
    found = np.full(len(past), VECTORS)
    before = past < 0.0
    lost = before & ((np.abs(right) > LEFT) | (off_course > OFF_COURSE))
    on_line = (np.abs(right) <= NEAR) & (off_course <= ON_COURSE) & before
    since = _first(on_line, after=_last(lost))
    if since is None:
        return found
    found[since:] = ESTABLISHED
    found[_intercept(path, off_course, since) : since] = CAPTURE
    foot = runway.aiming_point - past
    high = np.abs(path.position[2] - foot * math.tan(runway.glide_path))
    allowed = np.maximum(np.maximum(foot, 0.0) * math.tan(HALF_SCALE), LEAST)
    sinking = -path.velocity[2] >= SINKING * math.tan(runway.glide_path) * np.hypot(path.velocity[0], path.velocity[1])
    on_path = (high <= allowed) & sinking & (np.arange(len(past)) >= since) & before
    glide = _first(on_path, after=_last(before & (high > 2.0 * allowed)))
    if glide is not None:
        found[glide:] = GLIDE
    height, climb = path.position[2], path.velocity[2]
    over_runway = (past >= 0.0) & (np.abs(right) <= ASIDE) & (np.abs(height) <= LOW)
    touched = _first(over_runway & (np.abs(climb) <= LEVELLED), after=since)
    if touched is not None and height[touched:].max() <= height[touched] + AGAIN:
        found[touched:] = GROUND
    return found


def _intercept(path: Path, off_course: np.ndarray, since: int) -> int:
    """Where the last straight stretch before ``since`` ends that led to the line; ``since`` where there is none."""
    if not (off_course[:since] > ON_COURSE).any():
        return since
    step = path.time[1] - path.time[0]
    width, mean = (max(1, round(span / step)) for span in (STRAIGHT, CALM))
    bank = np.convolve(bank_of(path), np.full(mean, 1.0 / mean), mode="same")
    turning = np.concatenate(([0], np.cumsum(np.abs(bank) > LEVEL)))
    ends = np.arange(width, since)
    straight = ends[(turning[ends] == turning[ends - width]) & (off_course[ends - 1] > ON_COURSE)]
    return int(straight[-1]) if straight.size else 0


def _last(condition: np.ndarray) -> int:
    """Index of the last instant at which it holds; -1 = never."""
    found = np.flatnonzero(condition)
    return int(found[-1]) if found.size else -1


def _first(condition: np.ndarray, after: int) -> int | None:
    """Index of the first later instant at which it holds; None = never."""
    found = np.flatnonzero(condition[after + 1 :])
    return after + 1 + int(found[0]) if found.size else None
