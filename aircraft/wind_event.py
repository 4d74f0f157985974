"""The contract of a wind event, and what tries a class on it.

A kind of wind event is one file of ``aircraft/wind_events`` with one frozen dataclass that has all members of
`WindEvent`. The file's name is the ``kind`` of ``[wind.events.NAME]``, its fields are the other keys, in SI and with
their unit in the annotation: ``up: Annotated[float, "m/s"]`` is ``up_mps`` or ``up_kt`` in a scenario. Nothing else
knows the kind: it flies, and stands in explain and report, by these members alone.

Two names of fields have a meaning: ``at`` (s) is when it begins, and ``lasts`` (s) how long it takes from there on.
A field ``runway: Annotated[Any, "given"]`` is filled by the simulation: ``runway.to_local(past_threshold, right)``
gives (north, east), m. A kind whose fields have no usable defaults says in ``example: ClassVar[dict[str, Any]]`` what a
scenario would write, without ``kind``; its contract is tried with that.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import typing
from collections.abc import Callable
from typing import Any, Protocol

Velocity = tuple[float, float, float]  # (north, east, up) m/s: the way the air moves
Outline = tuple[tuple[float, float], ...]  # (north, east) m from the threshold, of the points of a closed line

AIRSPEED = 70.0  # m/s, with which a class is tried
PLACES = ((0.0, 0.0, 0.0), (-2000.0, 100.0, 60.0), (-9000.0, -700.0, 400.0), (40_000.0, 30_000.0, 3000.0))
TIMES = (*(float(time) for time in range(0, 301, 20)), 3600.0)  # s


class WindEvent(Protocol):
    """A movement of the air that comes at a time, or lies at a place; two made of the same values are equal.

    A class must have ``velocity``. What else it leaves out is as `DEFAULTS` says: its parameters for words, no outline,
    and nothing that stands.
    """

    def velocity(self, time: float, position: tuple[float, float, float], airspeed: float) -> Velocity:
        """The wind (north, east, up) in m/s at a time, s, and a position (north, east, height), m.

        Three finite floats for three floats: zeros where, before or after it blows. It is asked in any order and
        several times, so it must not remember. ``airspeed`` is that of the aircraft, m/s.
        """
        ...

    def words(self) -> str:
        """How strong it is, and where or when, in one phrase such as "9.0 m/s up, from 60 s for 3 s".

        Whoever asks says the kind before it: "gust of 9.0 m/s up, from 60 s for 3 s".
        """
        ...

    def outline(self) -> Outline:
        """Its edge on the ground, which the plan view fills: three points or more; () where it has no edge."""
        ...

    def standing(self) -> WindEvent | None:
        """The event as it stands at full strength, at all times; None where no approach has to fly through it.

        What stands is weighed against the power of the aircraft along the glide path, and is drawn from beside. None
        for what has no place, and for what is passed before it costs energy: its length is far below a kilometre.
        """
        ...


def _words(event: Any) -> str:
    """Its parameters that are set, and not as they are by default, in SI."""
    hints, parts = typing.get_type_hints(type(event), include_extras=True), []
    for field in dataclasses.fields(event):
        value, notes = getattr(event, field.name), getattr(hints[field.name], "__metadata__", ("",))
        if isinstance(value, int | float) and value != field.default:
            parts.append(f"{field.name.rstrip('_')} {value:g} {notes[0]}".rstrip())
    return ", ".join(parts) or "no parameters"


DEFAULTS: dict[str, Any] = {  # members that a class may leave out, and what they then are
    "words": _words,
    "outline": lambda event: (),
    "standing": lambda event: None,
}
MEMBERS = ("velocity",)  # that a class must have


def circle(north: float, east: float, radius: float, points: int = 72) -> Outline:
    """The outline of a round event, m."""
    turn = [2.0 * math.pi * point / points for point in range(points)]
    return tuple((north + radius * math.cos(angle), east + radius * math.sin(angle)) for angle in turn)


def broken_promises(cls: type, make: Callable[[], Any]) -> list[str]:
    """What a class breaks of the contract, a sentence each; empty for one that keeps it.

    ``make`` gives an instance, the same one of the same values each time. Never raises for a class that is wrong.
    """
    missing = [
        f"has no '{name}': {(inspect.getdoc(getattr(WindEvent, name)) or '').splitlines()[0]}"
        for name in MEMBERS
        if not callable(getattr(cls, name, None))
    ]
    if missing:
        return missing
    broken: list[str] = []

    def asked(what: str, call: Callable[[], Any]) -> Any:
        try:
            return call()
        except Exception as error:
            broken.append(f"{what} raises {type(error).__name__}: {_one_line(str(error))}")
            return None

    event = asked("making one", make)
    if event is None:
        return broken or ["making one gives None"]
    if asked("making one", make) != event:
        broken.append("two that are made of the same values are not equal: make it a frozen dataclass")
    field = asked("velocity", lambda: _sampled(event))
    if isinstance(field, str):
        broken.append(field)
    text = asked("words", event.words)
    if not broken and (not isinstance(text, str) or not text.strip() or len(text.splitlines()) != 1):
        broken.append(f"words gives {_one_line(repr(text))}, not a phrase on one line")
    edge = asked("outline", event.outline)
    if not broken and not _is_outline(edge):
        broken.append(f"outline gives {_one_line(repr(edge))}, not () or three or more points (north, east) in m")
    standing = asked("standing", event.standing)
    if standing is not None and not broken:
        broken += _standing_breaks(standing)
    return broken


def _sampled(event: Any) -> list[Velocity] | str:
    """The wind at many times and places, or what is wrong with it."""
    at, lasts = getattr(event, "at", None), getattr(event, "lasts", None)
    inside = () if at is None else tuple(at + share * (lasts or 1.0) for share in (0.0, 0.25, 0.5, 1.0))
    field: list[Velocity] = []
    for time in (*TIMES, *inside):
        for place in PLACES:
            wind = event.velocity(time, place, AIRSPEED)
            if not (isinstance(wind, tuple) and len(wind) == 3 and all(_finite(part) for part in wind)):
                return f"velocity gives {_one_line(repr(wind))} at {time:g} s, not three finite numbers"
            if at is not None and time < at and any(wind):
                return f"velocity gives wind at {time:g} s, before it begins at {at:g} s"
            field.append(wind)
    if event.velocity(TIMES[0], PLACES[0], AIRSPEED) != field[0]:
        return "velocity gives another wind when it is asked again: it must not remember"
    return field


def _standing_breaks(standing: Any) -> list[str]:
    """What is wrong with an event as it stands."""
    if not callable(getattr(standing, "velocity", None)):
        return [f"standing gives {_one_line(repr(standing))}, not a wind event or None"]
    try:
        winds = [{standing.velocity(time, place, AIRSPEED) for time in TIMES} for place in PLACES]
    except Exception as error:
        return [f"velocity of what standing gives raises {type(error).__name__}: {_one_line(str(error))}"]
    return ["standing gives an event whose wind changes with time"] if any(len(wind) > 1 for wind in winds) else []


def _is_outline(edge: Any) -> bool:
    points = isinstance(edge, tuple) and all(
        isinstance(point, tuple) and len(point) == 2 and all(_finite(part) for part in point) for point in edge
    )
    return points and len(edge) not in (1, 2)


def _finite(value: Any) -> bool:
    return isinstance(value, float | int) and math.isfinite(value)


def _one_line(text: str) -> str:
    return " ".join(text.split())[:120]
