"""What wind events share: the smooth shape of their coming and going, their time or place, and the words for it."""

from __future__ import annotations

import math
from typing import Any

from aircraft.ranges import Range, check_ranges, within

FASTEST = 100.0  # m/s
SPEED = Range(least=0.0, most=FASTEST)
UP = within(FASTEST)


def one_minus_cosine(share: float) -> float:
    """Half of one minus the cosine, once around: 0 at 0, 1 at 1/2, 0 at 1 and outside."""
    return 0.5 - 0.5 * math.cos(2.0 * math.pi * share) if 0.0 < share < 1.0 else 0.0


def amplitude(speed: float, from_direction: float, up: float) -> tuple[float, float, float]:
    """(north, east, up), m/s, of a wind that blows from a direction, rad."""
    return -speed * math.cos(from_direction), -speed * math.sin(from_direction), up


def scaled(share: float, full: tuple[float, float, float]) -> tuple[float, float, float]:
    """A share of (north, east, up)."""
    return (share * full[0], share * full[1], share * full[2]) if share else (0.0, 0.0, 0.0)


def phrase(event: Any, where: str = "") -> str:
    """How much blows, from where, and when; ``where`` begins with a comma."""
    parts = []
    if event.up:
        parts.append(f"{abs(event.up):.1f} m/s {'up' if event.up > 0.0 else 'down'}")
    if event.speed:
        parts.append(f"{event.speed:.1f} m/s from {math.degrees(event.from_) % 360:03.0f} deg")
    return f"{' and '.join(parts) or 'no strength'}{where}{time_in_words(event.at, event.lasts)}"


def place_in_words(past_threshold: float, right: float = 0.0) -> str:
    """Where it is, by the runway."""
    along = f"{abs(past_threshold):.0f} m {'past' if past_threshold > 0.0 else 'before'} the threshold"
    return along + (f", {abs(right):.0f} m {'right' if right > 0.0 else 'left'} of the centreline" if right else "")


def time_in_words(at: float | None, lasts: float | None) -> str:
    """When it comes, as the end of a phrase; nothing for what is always there."""
    return "" if at is None else f", from {at:.0f} s for {lasts:.3g} s"


def check(event: Any, called: str) -> None:
    """Refuse an event without a sensible strength, or that has not exactly one of a time and a place."""
    check_ranges(event)
    for name in ("at", "lasts", "past_threshold", "length"):
        value = getattr(event, name)
        if value is not None and not math.isfinite(value):
            raise ValueError(f"{name} of {called} must be a finite number")
    in_time = event.at is not None and event.lasts is not None
    in_space = event.past_threshold is not None and event.length is not None
    whole = (event.at is None) == (event.lasts is None) and (event.past_threshold is None) == (event.length is None)
    if in_time == in_space or not whole:
        raise ValueError(
            f"{called} comes at a time (at, lasts) or at a place (past_threshold, length): say one of them"
        )
