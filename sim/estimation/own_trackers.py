"""Trackers that the caller brings: what they listen to, and what they are given of law and route."""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import pickle
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from sim.errors import ScenarioError, did_you_mean
from sim.estimation.setup import (
    changed_law,
    charted_route,
    measurement_model,
    reads_places,
    uses_places,
    with_clutter,
)
from sim.flight.preparation import Prepared
from sim.scenario.plugins import said
from sim.scenario.schema import name_faults
from tracking.contract import missing_members
from tracking.track import Tracker

OWN = "own"  # how addresses of such trackers begin
Law = Literal["autopilot"] | Mapping[str, float]


@dataclass(frozen=True)
class OwnTracker:
    """A tracker of the caller with what it is to be given; made by `tracker`."""

    made: Any  # a tracker, or what makes one
    sensors: tuple[str, ...] | None = None  # None = all that it can read
    law: Law | None = None
    route: bool = False
    parameters: dict[str, Any] = field(default_factory=dict)


OwnTrackers = Mapping[str, Tracker | OwnTracker]
"""Trackers of the caller by name."""


def tracker(
    made: Tracker | type[Any],
    *,
    sensors: Iterable[str] | None = None,
    law: Law | None = None,
    route: bool = False,
    **parameters: Any,
) -> OwnTracker:
    """A tracker of one's own for ``sim.run(..., trackers={"mine": sim.tracker(Mine, sensors=["radar"])})``.

    Parameters
    ----------
    made : a tracker (`tracking.track.Tracker`), or the class that makes one
    sensors : names of those that it listens to; None = all that it can read
    law : "autopilot" = it is given ``law``, the control law that flies; with changes, as the table
        ``[trackers.NAME.law]`` has them in SI or as ``<field>_factor``, a law that it wrongly assumes
    route : whether it is given ``route``, with its legs, their speeds and that of the glide path
    parameters : what the class is called with besides
    """
    if isinstance(sensors, str):
        raise ScenarioError(f"tracker: sensors are a list of names, such as ['{sensors}'], not one word")
    names = None if sensors is None else tuple(sensors)
    if names == ():
        raise ScenarioError("tracker: sensors: must name one at least, or be left out for all")
    if isinstance(law, str) and law != "autopilot":
        raise ScenarioError(f"tracker: law must be 'autopilot' or a dict of changes to it, not '{law}'")
    return OwnTracker(made, names, law, route, parameters)


class SetUpOwn(NamedTuple):
    """A tracker of the caller as it runs, where its law comes from, and its sensors."""

    tracker: Any
    law_from: str | None
    sensors: tuple[str, ...]


def set_up(prepared: Prepared, name: str, given: Any) -> SetUpOwn:
    """A caller's tracker with what it is given; one with a ``measurement`` reads this scenario's radars.

    Raises ``ScenarioError`` in one sentence for one that cannot be made, or has nothing to listen to.
    """
    for sentence in name_faults("trackers", name):
        raise ScenarioError(f"tracker '{name}': {sentence}")
    own = given if isinstance(given, OwnTracker) else OwnTracker(given)
    names = _listened(prepared, name, own)
    sensors = {one: prepared.scenario.sensors[one] for one in names}
    cluttered = with_clutter(sensors)
    if cluttered:
        raise ScenarioError(f"a tracker of the caller cannot listen to '{cluttered[0]}', which has clutter")
    supplied: dict[str, Any] = dict(own.parameters)
    law_from = None
    if own.law is not None:
        changes = {} if isinstance(own.law, str) else own.law
        supplied["law"], law_from = changed_law(prepared.law, f"tracker '{name}' law:", changes)
    if own.route:
        supplied["route"] = charted_route(prepared)
    if _reads_places(own.made):
        supplied["measurement"] = measurement_model(prepared, sensors, "own")
    made = _made(name, own.made, supplied)
    for missing in missing_members(made):
        raise ScenarioError(f"tracker '{name}': {missing}")
    return SetUpOwn(made, law_from, names)


def _made(name: str, made: Any, supplied: dict[str, Any]) -> Any:
    """The tracker that is made with what is supplied; one that is made already takes it as its fields."""
    if not supplied and not isinstance(made, type):
        return made
    if not isinstance(made, type) and not dataclasses.is_dataclass(made):
        raise ScenarioError(
            f"tracker '{name}': is made already and no dataclass, so it cannot be given {', '.join(supplied)}; "
            "give its class"
        )
    try:
        return made(**supplied) if isinstance(made, type) else dataclasses.replace(made, **supplied)
    except Exception as error:  # the class is the caller's: it may raise anything
        with_what = ", ".join(supplied) or "nothing"
        raise ScenarioError(f"tracker '{name}': making it with {with_what} raises {said(error)}") from None


def _reads_places(made: Any) -> bool:
    """Whether it updates with a place on the ground plane."""
    return dataclasses.is_dataclass(made) and (uses_places(made) if isinstance(made, type) else reads_places(made))


def _listened(prepared: Prepared, name: str, own: OwnTracker) -> tuple[str, ...]:
    """The sensors of a caller's tracker: those that it names, else all, or where it reads places those that give one.

    Where none gives a place, it has those that measure an azimuth or a range.
    """
    known, places = prepared.scenario.sensors, _reads_places(own.made)
    for one in own.sensors or ():
        if one not in known:
            raise ScenarioError(
                f"{prepared.scenario.name}: tracker '{name}' sensors: '{one}' is no sensor of the scenario; "
                f"{did_you_mean(one, known)}"
            )
    if own.sensors is not None:
        return own.sensors
    found = tuple(one for one in known if not places or known[one].gives_place)
    found = found or tuple(one for one in known if {"azimuth", "range"} & {*known[one].channels})
    if not found:
        wanted = "no sensor that gives a position" if places else "no sensors"
        raise ScenarioError(
            f"{prepared.scenario.name}: tracker '{name}' has nothing to listen to: the scenario has {wanted}; "
            'add a table [sensors.NAME], such as kind = "surveillance_radar"'
        )
    return found


def check_own(prepared: Prepared, own: Mapping[str, Any] | None) -> None:
    """Set every tracker of the caller up once, so that what cannot be is refused before anything flies."""
    for name, given in (own or {}).items():
        set_up(prepared, name, given)


def packed(own: Mapping[str, Any] | None) -> bytes:
    """The caller's trackers as they travel to a worker; raises ``ScenarioError`` for one that cannot be sent."""
    try:
        return pickle.dumps(dict(own or {}), 4)
    except Exception as error:  # their classes may raise anything
        raise ScenarioError(f"the trackers of the caller cannot be sent to a worker: {error}") from None


def unpacked(content: bytes) -> dict[str, Any]:
    """In a worker: the caller's trackers; raises ``ScenarioError`` where it does not find their classes."""
    try:
        found: dict[str, Any] = pickle.loads(content)  # of this program's own first process, never of a file
    except Exception as error:  # what it imports may raise anything
        raise ScenarioError(
            f"a worker process does not find the trackers of the caller ({error}): put their classes into a file that "
            "it can import, or take one worker"
        ) from None
    return found


def digests_of_own(own: Mapping[str, Any]) -> dict[str, str]:
    """What tells the caller's trackers from others, by their address: their parameters and the file of their class.

    Raises ``ScenarioError`` for one that cannot be sent to another process.
    """
    found = {}
    for name, given in own.items():
        made = given.made if isinstance(given, OwnTracker) else given
        content = packed({name: given})
        try:
            text = inspect.getsource(inspect.getmodule(made if isinstance(made, type) else type(made)) or OwnTracker)
        except (OSError, TypeError):  # typed at a prompt
            text = ""
        found[f"{OWN}.{name}"] = hashlib.sha256(content + text.encode()).hexdigest()[:16]
    return found
