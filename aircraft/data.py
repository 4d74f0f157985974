"""What is known of an aircraft besides its equations of motion: speeds, flap schedule, limits, loading range."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_type_hints

from aircraft.errors import ModelError
from aircraft.landing_gear import height_of_wheels, steering, touchdown_bank, touchdown_pitch, wheel_track
from aircraft.loading import total_mass
from aircraft.model_files import Model, folder, is_file, read
from aircraft.safe_xml import confined
from aircraft.stock import stock_row
from aircraft.units import spellings

RATES = (60.0, 120.0, 240.0)  # Hz; whole steps in those of the autopilot
LARGEST_TABLE = 1_000_000  # bytes; the data of an aircraft are a page of text


@dataclass(frozen=True)
class FlapSetting:
    """One detent of the flap lever."""

    flaps: Annotated[float, "rad"]
    placard_speed: Annotated[float, "m/s"]  # indicated, taken as equivalent
    stall_speed: Annotated[float, "m/s"]  # equivalent, at ``AircraftData.reference_mass``

    def __post_init__(self) -> None:
        if not (self.flaps >= 0.0 and self.stall_speed > 0.0):
            raise ModelError("a flap setting needs flaps of 0 or more and a stall_speed above 0")


@dataclass(frozen=True)
class AircraftData:
    """Facts of a type; those without a source limit nothing."""

    title: str
    reference_mass: Annotated[float, "kg"] = 0.0
    mass_min: Annotated[float, "kg"] = 0.0
    mass_max: Annotated[float, "kg"] = math.inf
    mean_chord: Annotated[float, "m"] = 0.0
    chord_leading_edge: Annotated[float, "m"] = 0.0  # aft in the model's structural frame
    centre_of_gravity_min: float = 0.0  # share of the mean chord
    centre_of_gravity_max: float = 1.0
    wheel_track: Annotated[float, "m"] = 0.0
    height_of_wheels: Annotated[float, "m"] = 0.0  # centre of gravity above the main wheels, gear down
    lowest_touchdown_pitch: Annotated[float, "rad"] = -math.pi / 2.0  # at which the nose wheel touches with the mains
    highest_touchdown_pitch: Annotated[float, "rad"] = math.pi / 2.0  # at which the tail does
    highest_touchdown_bank: Annotated[float, "rad"] = math.pi / 2.0  # at which a wing tip does
    gear_placard_speed: Annotated[float, "m/s"] = math.inf
    sink_limit: Annotated[float, "m/s"] = 3.05
    tailwind_limit: Annotated[float, "m/s"] = math.inf
    crosswind_limit: Annotated[float, "m/s"] = math.inf
    wheelbase: Annotated[float, "m"] = 0.0  # from the main wheels forward to the steered wheel
    steering_limit: Annotated[float, "rad"] = 0.0
    rate: Annotated[float, "Hz"] = 120.0  # of the equations of motion, by a convergence test
    flap_settings: tuple[FlapSetting, ...] = ()
    factors: tuple[str, ...] = ()
    sources: tuple[tuple[str, str], ...] = ()  # (value, where it is from)

    def __post_init__(self) -> None:
        if self.flap_settings and not self.reference_mass > 0.0:
            raise ModelError(f"the data of '{self.title}' need a reference_mass above 0 for their stall speeds")
        if self.rate not in RATES:
            raise ModelError(f"the data of '{self.title}' need a rate of 60, 120 or 240 Hz, not {self.rate:g}")
        for name in ("mass", "centre_of_gravity"):
            if not getattr(self, f"{name}_min") <= getattr(self, f"{name}_max"):
                raise ModelError(f"the data of '{self.title}' have {name}_min above {name}_max")

    def setting(self, flaps: float) -> FlapSetting:
        """The flap setting nearest to ``flaps`` (rad); raises ``ModelError`` where none is known."""
        if not self.flap_settings:
            raise ModelError(f"the data of '{self.title}' state no stall speed")
        return min(self.flap_settings, key=lambda setting: abs(setting.flaps - flaps))

    def stall_speed(self, flaps: float, mass: float) -> float:
        """Stall speed, m/s equivalent, of the setting nearest to ``flaps`` (rad), by the root of the mass (kg)."""
        return self.setting(flaps).stall_speed * math.sqrt(mass / self.reference_mass)


def data(model: str | Path) -> AircraftData:
    """The data of an aircraft; raises ``ModelError`` for a broken file."""
    return describe(read(model), model)


def describe(source: Model, model: str | Path) -> AircraftData:
    """Data of a model that is read already: from its TOML, and from its XML the mass and the main wheels."""
    home = folder(model)
    path = home / f"{source.name}.toml"
    lowest, highest = touchdown_pitch(source)
    from_model: dict[str, Any] = {
        "title": source.name,
        "reference_mass": total_mass(source),
        "wheel_track": wheel_track(source),
        "height_of_wheels": height_of_wheels(source),
        "lowest_touchdown_pitch": lowest,
        "highest_touchdown_pitch": highest,
        "highest_touchdown_bank": touchdown_bank(source),
    }
    from_model |= dict(zip(("wheelbase", "steering_limit"), steering(source), strict=True))
    if not is_file(path):
        return AircraftData(**from_model, rate=stock_row(model).get("rate_hz", AircraftData.rate))
    try:
        table = tomllib.loads(confined(path, home, LARGEST_TABLE).decode())
        settings = tuple(_build(FlapSetting, entry, path) for entry in table.pop("flap_settings", []))
        sources = tuple(table.pop("sources", {}).items())
        factors = tuple(table.pop("factors", []))
        ready = from_model | {"flap_settings": settings, "factors": factors, "sources": sources}
        return _build(AircraftData, table, path, **ready)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ModelError(f"'{path.name}' cannot be read: {error}") from None
    except (TypeError, AttributeError):
        raise ModelError(f"'{path.name}' has a value where a table or a list belongs, or the other way round") from None


Built = TypeVar("Built", FlapSetting, AircraftData)


def _build(kind: type[Built], table: dict[str, Any], path: Path, **ready: Any) -> Built:
    """Construct ``kind`` from suffixed keys."""
    hints = get_type_hints(kind, include_extras=True)
    keys: dict[str, tuple[str, float]] = {}
    for field in fields(kind):
        unit = getattr(hints[field.name], "__metadata__", (None,))[0]
        legal = spellings(field.name, unit) if unit else {field.name: 1.0}
        keys |= {key: (field.name, factor) for key, factor in legal.items()}
    values = dict(ready)
    for key, value in table.items():
        if key not in keys:
            raise ModelError(f"'{path.name}' has the unknown key '{key}'")
        name, factor = keys[key]
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if name == "title" and isinstance(value, str):
            values[name] = value
        elif name != "title" and is_number and math.isfinite(value):
            values[name] = value * factor
        else:
            raise ModelError(f"'{path.name}' {key} must be a {'text' if name == 'title' else 'finite number'}")
    return kind(**values)
