"""The gains of a flight as they travel in ``[designed]``: with the inputs of their design, or frozen without them.

A table with ``[designed.inputs]`` is used for exactly these inputs; with any other value the aircraft is designed
anew, and a remark says why. A table without inputs is frozen: its gains fly whatever the scenario says, as those of a
study's cell fly all its samples, because what a sample draws is what the designer did not know.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from aircraft.data import FlapSetting
from aircraft.identity import identity
from aircraft.slowest import flap_settings
from autopilot.design import Designed
from sim.cache.user_cache import remembered

INPUTS = "inputs"


class Gains(NamedTuple):
    """A design, what it was made for, and what is to be said of it."""

    designed: Designed
    inputs: dict[str, Any] | None  # plain values; None = frozen
    remarks: tuple[str, ...] = ()

    def to_table(self) -> dict[str, Any]:
        """As ``[designed]`` of a scenario file."""
        return self.designed.to_table() | ({} if self.inputs is None else {INPUTS: self.inputs})


def gains_for(table: dict[str, Any] | None, inputs: dict[str, Any], design: Callable[[], Designed]) -> Gains:
    """Those of a ``[designed]`` table where they are for these inputs or frozen, else what ``design`` gives.

    Raises ``ValueError`` for a table that cannot be used.
    """
    if table is None:
        return Gains(design(), inputs)
    before = table.get(INPUTS)
    if before is None:
        return Gains(_read(table), None)
    if not isinstance(before, dict):
        raise ValueError("[designed] inputs must be a table; take [designed] out to design anew")
    old, new = _flat(before), _flat(inputs)
    changed = sorted(name for name in old.keys() | new.keys() if old.get(name) != new.get(name))
    if not changed:
        return Gains(_read(table), inputs)
    remark = f"the gains of [designed] were made for other inputs ({', '.join(changed)}): designed anew"
    return Gains(design(), inputs, (remark,))


def known_design(inputs: dict[str, Any], model: str, design: Callable[[], Designed]) -> Designed:
    """The design for these inputs, made once for all commands; ``model`` names the aircraft, whose files decide too."""
    decides = [inputs, identity(model)]
    return Designed.from_table(remembered("design", decides, lambda: design().to_table()))


def known_flap_settings(model: str | Path, repaired: bool) -> tuple[FlapSetting, ...]:
    """The slowest level flight of an aircraft that no table has, measured once for all commands."""
    found = remembered(
        "slowest", [identity(str(model)), repaired], lambda: [*map(dataclasses.astuple, flap_settings(model, repaired))]
    )
    return tuple(FlapSetting(*row) for row in found)


def _read(table: dict[str, Any]) -> Designed:
    try:
        return Designed.from_table(table)
    except KeyError as error:
        raise ValueError(f"[designed] lacks {error}; take the table out to design anew") from None
    except (TypeError, ValueError, AttributeError, IndexError):
        raise ValueError("[designed] cannot be used; take the table out to design anew") from None


def plain(value: Any) -> Any:
    """Arguments of a design as a file can hold them: tables of numbers and texts, without what is not set."""
    if isinstance(value, tuple) and (names := getattr(value, "_fields", ())):
        value = dict(zip(names, value, strict=True))
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(name): plain(one) for name, one in value.items() if one is not None}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return float(value)  # one of numpy's has another text
    return str(value) if isinstance(value, Path) else value


def _flat(value: Any, path: str = "") -> dict[str, Any]:
    """Leaves by their dotted names; of a list, its items by their numbers."""
    if isinstance(value, Mapping):
        items = [(str(name), one) for name, one in value.items()]
    elif isinstance(value, list):
        items = [(str(number), one) for number, one in enumerate(value)]
    else:
        return {path: value}
    found: dict[str, Any] = {}
    for name, one in items:
        found |= _flat(one, f"{path}.{name}" if path else name)
    return found
