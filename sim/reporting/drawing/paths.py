"""Points as the paths of SVG: whole tenths of a point, each relative to the one before, without points nobody sees."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

UNIT = 10  # to a point
FARTHEST = 1_000_000  # units; a renderer's numbers are exact to a tenth up to there
STRAIGHT = 0.75  # units that a point must lie beside the line through its neighbours, or it is left out


def whole(values: np.ndarray) -> np.ndarray:
    """Points as units; what is not finite is NaN."""
    with np.errstate(invalid="ignore"):
        units = np.rint(np.clip(values * UNIT, -FARTHEST, FARTHEST))
    return np.where(np.isfinite(values), units, np.nan)


def path(x: np.ndarray, y: np.ndarray, size: tuple[float, float]) -> str:
    """The path through points in a panel of a ``size``, broken where one is not finite; "" for none."""
    return "".join(f"M{part[0, 0]} {part[0, 1]}{_relative(part)}" for part in runs(x, y, size))


def runs(x: np.ndarray, y: np.ndarray, size: tuple[float, float]) -> Iterator[np.ndarray]:
    """(n, 2) integers: the unbroken stretches that can be seen; one point alone is none."""
    points = np.column_stack((whole(x), whole(y)))
    finite = np.isfinite(points).all(axis=1)
    borders = np.flatnonzero(np.diff(np.concatenate(([False], finite, [False])).astype(np.int8)))
    for first, last in borders.reshape(-1, 2).tolist():
        part = unbent(points[first:last])
        if len(part) > 1:
            yield from _cut(part.astype(int), size)


def unbent(points: np.ndarray) -> np.ndarray:
    """Without repeated points and without those on the line through their neighbours.

    Two passes over the points in between, so that no point left out has moved the line by more than 1.5 units.
    """
    moved = np.ones(len(points), bool)
    moved[1:] = (points[1:] != points[:-1]).any(axis=1)
    points = points[moved]
    for first in (1, 2):
        if len(points) <= first + 1:
            break
        before, at, after = points[first - 1 : -1 : 2], points[first::2], points[first + 1 :: 2]
        count = min(len(before), len(at), len(after))
        before, at, after = before[:count], at[:count], after[:count]
        chord, own = after - before, at - before
        length = np.hypot(chord[:, 0], chord[:, 1])
        beside = np.abs(chord[:, 0] * own[:, 1] - chord[:, 1] * own[:, 0])
        along = (chord * own).sum(axis=1)
        flat = (beside <= STRAIGHT * length) & (along >= 0) & (along <= length**2)
        kept = np.ones(len(points), bool)
        kept[first : first + 2 * count : 2] = ~flat
        points = points[kept]
    return points


def _cut(points: np.ndarray, size: tuple[float, float]) -> Iterator[np.ndarray]:
    """Without stretches that lie beyond one side of the panel."""
    x, y = points.T
    room = 200  # units, of wide lines and markers
    width, height = (UNIT * side for side in size)
    sides = np.stack((x < -room, x > width + room, y < -room, y > height + room))
    if not sides.any():
        yield points
        return
    hidden = (sides[:, 1:] & sides[:, :-1]).any(axis=0)  # of each step
    drawn = np.concatenate(([True], hidden, [True]))
    ends = np.flatnonzero(np.diff(drawn.astype(np.int8)))
    for first, last in ends.reshape(-1, 2).tolist():
        yield points[first : last + 1]


def _relative(points: np.ndarray) -> str:
    return "l" + joined(np.diff(points, axis=0).ravel().tolist())


def joined(numbers: list[int]) -> str:
    """Numbers as a path separates them: a minus sign needs no space before it."""
    return " ".join(map(str, numbers)).replace(" -", "-")


def closed(x: np.ndarray, y: np.ndarray) -> str:
    """A ring, closed; "" where a corner is not finite."""
    points = np.column_stack((whole(x), whole(y)))
    if len(points) < 3 or not np.isfinite(points).all():
        return ""
    points = points.astype(int)
    return f"M{points[0, 0]} {points[0, 1]}{_relative(points)}z"


def dots(x: np.ndarray, y: np.ndarray) -> str:
    """A step of no length at each finite point: with round ends, a dot."""
    return each(x, y, "h0")


def each(x: np.ndarray, y: np.ndarray, shape: str) -> str:
    """A shape at each finite point; it begins there, and the next is reached from there."""
    points = np.column_stack((whole(x), whole(y)))
    points = points[np.isfinite(points).all(axis=1)].astype(int)
    if not len(points):
        return ""
    if shape == "h0":
        steps = np.diff(points, axis=0).tolist()
        return f"M{points[0, 0]} {points[0, 1]}h0" + "".join(f"m{dx}{' ' if dy >= 0 else ''}{dy}h0" for dx, dy in steps)
    return "".join(f"M{px} {py}{shape}" for px, py in points.tolist())
