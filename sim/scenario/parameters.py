"""One parameter mechanism: a frozen dataclass field ``name: Annotated[float, "rad"]`` is a file key ``name_deg``.

From each class comes one pydantic model whose keys are every legal spelling, so that error locations and the JSON
Schema speak the user's own words. Fields marked ``"given"`` are filled by the simulation and absent from files. Fields
marked ``"indicated"`` are true airspeeds; each has a twin, ``indicated_approach_speed_kt`` of ``approach_speed_kt``, in
every unit, which is the airspeed as an indicator shows it and charts give it.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import types
import typing
from collections.abc import Callable, Iterable
from typing import Annotated, Any, ParamSpec, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model, model_validator

from aircraft.ranges import Range, range_of
from aircraft.units import MAGNITUDES, PLAIN, WORDS, spellings
from sim.scenario.messages import stem

P = ParamSpec("P")
R = TypeVar("R")
GIVEN = "given"
NOT_EMPTY = "not empty"  # of several values or tables: at least one
INDICATED = "indicated"  # after the unit of a true airspeed; before an underscore, the beginning of its twin's keys
MOST = 10**9  # of whole numbers, either way
JSON_LIMITS = {"above": "exclusiveMinimum", "least": "minimum", "below": "exclusiveMaximum", "most": "maximum"}


def cached(function: Callable[P, R]) -> Callable[P, R]:
    """The function with its results kept; to type checkers ``functools.cache`` would forget what it takes."""
    return typing.cast(Callable[P, R], functools.cache(function))


@dataclasses.dataclass(frozen=True)
class Parameter:
    """One field of a parameter class as files see it."""

    name: str  # without the underscore that keeps a Python keyword legal
    attribute: str
    unit: str | None  # None = dimensionless or not a number
    kind: Any  # type without unit
    required: bool
    default: Any
    is_airspeed: bool = False  # and has a twin that is indicated
    range: Range | None = None  # None = as far as a number of its unit can be
    least: int = 0  # number of values, of a list or a table

    @functools.cached_property
    def keys(self) -> dict[str, float]:
        """File keys with their factors to SI, the preferred one first."""
        own = {self.name: 1.0} if self.unit is None else spellings(self.name, self.unit)
        return own | self.indicated_keys

    @functools.cached_property
    def indicated_keys(self) -> dict[str, float]:
        """Those of the keys that give an indicated airspeed."""
        return spellings(f"{INDICATED}_{self.name}", self.unit) if self.is_airspeed and self.unit else {}


@cached
def parameters(cls: type) -> tuple[Parameter, ...]:
    """The fields of ``cls`` that a file may set."""
    hints = typing.get_type_hints(cls, include_extras=True)
    found = []
    for field in dataclasses.fields(cls):
        hint, unit, is_airspeed = hints[field.name], None, False
        limited, least = range_of(hint), 0
        if typing.get_origin(hint) is Annotated:
            hint, *notes = typing.get_args(hint)
            if GIVEN in notes:
                continue
            unit = next((note for note in notes if isinstance(note, str) and note not in (INDICATED, NOT_EMPTY)), None)
            is_airspeed = INDICATED in notes
            least = 1 if NOT_EMPTY in notes else 0
        factory = field.default_factory
        required = field.default is dataclasses.MISSING and factory is dataclasses.MISSING
        default = field.default if factory is dataclasses.MISSING else factory()
        found.append(
            Parameter(field.name.rstrip("_"), field.name, unit, hint, required, default, is_airspeed, limited, least)
        )
    return tuple(found)


@cached
def _limited(number: type, unit: str | None, factor: float, limits: Range) -> Any:
    """A strict number of a size that something real has, within its limits; ``factor`` is that of a key to its unit."""
    least, most = (float(f"{size / factor:.3g}") for size in (PLAIN if unit is None else MAGNITUDES[unit]))
    most = MOST if number is int else most
    extra = {JSON_LIMITS[name]: number(limit) for name, _, limit in limits.limits(factor)}

    keeps = limits.keeper(factor)

    def kept(value: float) -> float:
        if not keeps(value):
            raise ValueError(limits.fault(value, factor))
        if -least < value < least and value != 0.0 and number is float:
            raise ValueError(f"must be 0 or at least {least:g} in size")
        return value

    low, high = -most if limits.low is None else None, most if limits.high is None else None
    is_finite = False if number is float else None
    field = Field(strict=True, allow_inf_nan=is_finite, ge=low, le=high, json_schema_extra=extra)
    return Annotated[number, field, AfterValidator(kept)]


def _numbers(hint: Any, one: Parameter, factor: float = 1.0) -> Any:
    """The pydantic type of one key: finite strict numbers, tables for nested parameter classes."""
    if hint is float or (hint is Any and one.unit is not None):
        return _limited(float, one.unit, factor, one.range or Range())
    if hint is int:
        return _limited(int, None, 1.0, one.range or Range())
    if hint is bool:
        return Annotated[bool, Field(strict=True)]
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        return model_of(hint)
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return typing.Union[tuple(_numbers(a, one, factor) for a in arguments)]  # noqa: UP007 (built at run time)
    if origin is tuple and len(arguments) == 2 and arguments[1] is Ellipsis:
        return _counted(types.GenericAlias(list, (_numbers(arguments[0], one, factor),)), one.least)
    if origin is tuple:
        return types.GenericAlias(tuple, tuple(_numbers(a, one, factor) for a in arguments))
    if origin is dict:
        return _counted(types.GenericAlias(dict, (arguments[0], _numbers(arguments[1], one, factor))), one.least)
    return _counted(hint, one.least) if hint is str else hint


def _counted(hint: Any, least: int) -> Any:
    return Annotated[hint, Field(min_length=least)] if least else hint


@cached
def model_of(
    cls: type,
    kind: str | None = None,
    *,
    defaulted_kind: bool = False,
    partial: bool = False,
    without: tuple[str, ...] = (),
) -> type[BaseModel]:
    """The pydantic model of a parameter class.

    ``kind`` adds the table's literal ``kind`` key (absent = this kind where it is the default one), ``partial`` makes
    every field optional, ``without`` leaves fields out.
    """
    fields: dict[str, Any] = {}
    wanted = [parameter for parameter in parameters(cls) if parameter.name not in without]
    for parameter in wanted:
        required = parameter.required and not partial
        if len(parameter.keys) == 1 and required:
            ((key, factor),) = parameter.keys.items()
            described = _in_words(parameter, key, factor)
            fields[key] = (_numbers(parameter.kind, parameter, factor), Field(description=described))
        else:
            for key, factor in parameter.keys.items():
                described = _in_words(parameter, key, factor)
                hint = _numbers(parameter.kind, parameter, factor)
                fields[key] = (hint | None, Field(default=None, description=described))
    if kind is not None:
        fields["kind"] = (typing.Literal[kind], kind if defaulted_kind else ...)

    spelt = [parameter for parameter in wanted if len(parameter.keys) > 1]
    owners = {key: parameter.name for parameter in spelt for key in parameter.keys}
    needed = {parameter.name for parameter in spelt if parameter.required and not partial}

    def one_spelling(table: Any) -> Any:
        if isinstance(table, dict):
            told = [owners[key] for key in table if key in owners]
            if needed.issubset(told) and len(set(told)) == len(told):  # nearly always
                return table
            for parameter in spelt:
                used = [key for key in parameter.keys if key in table]
                if len(used) > 1 and len({key in parameter.indicated_keys for key in used}) > 1:
                    raise ValueError(
                        f"'{used[0]}' is the true airspeed and '{used[-1]}' the indicated one of one speed; keep one"
                    )
                if len(used) > 1:
                    raise ValueError(f"'{used[0]}' and '{used[1]}' are two spellings of one value; keep one")
                if not used and parameter.required and not partial:
                    wrong = [f", '{key}' is no unit of it" for key in table if stem(key) == parameter.name]
                    raise ValueError(f"'{next(iter(parameter.keys))}' is missing{''.join(wrong[:1])}")
        return table

    validators: dict[str, Any] = {"one_spelling": model_validator(mode="before")(one_spelling)}
    told: list[Any] = [_one_of(parameter.keys, parameter.name in needed) for parameter in spelt]
    config = ConfigDict(extra="forbid", json_schema_extra={"allOf": told} if told else None)
    about = (cls.__doc__ or "").partition("\n")[0]
    return create_model(cls.__name__, __config__=config, __doc__=about, __validators__=validators, **fields)


def _one_of(keys: Iterable[str], required: bool) -> dict[str, Any]:
    """As a JSON Schema: that a table has one of the spellings of a value, or one at most."""
    each: list[dict[str, Any]] = [{"required": [key]} for key in keys]
    return {"oneOf": each if required else [*each, {"not": {"anyOf": each}}]}


def _in_words(parameter: Parameter, key: str, factor: float) -> str | None:
    """What an editor says of a key: its unit, and what holds without it."""
    told = [] if parameter.unit is None else [f"in {WORDS[key.removeprefix(f'{stem(key)}_')]}"]
    if parameter.range is not None:
        told.append(parameter.range.words(factor))
    if key in parameter.indicated_keys:
        told.append(f"indicated airspeed, instead of '{parameter.name}', which is true")
    elif (default := _default_in_words(parameter, factor)) is not None:
        told.append(default)
    return "; ".join(told) or None


def _default_in_words(parameter: Parameter, factor: float) -> str | None:
    """What a key is where a file does not have it, in the unit of the key; None where that is nothing."""
    default = parameter.default
    if parameter.required or default is None:
        return None
    if isinstance(default, int | float) and not isinstance(default, bool):
        return f"default {default / factor:.6g}"
    if isinstance(default, tuple) and all(isinstance(one, int | float) for one in default):
        return f"default {[float(f'{one / factor:.6g}') for one in default]}"
    return f"default {default!r}"


TrueShare = Callable[[float | None], float]
"""True over equivalent airspeed at a height, m; None where the table says none."""


def construct(cls: type, table: dict[str, Any], true_share: TrueShare | None = None, **given: Any) -> Any:
    """An instance from a validated table, converted to SI; ``given`` fills what files never say, where it has a field.

    An indicated airspeed becomes the true one at the ``height`` of the same table, by ``true_share``.

    Raises ``ValueError`` in the class's own words when a value is out of its range.
    """
    fields = {field.name for field in dataclasses.fields(cls)} if given else ()
    asked = {name: value for name, value in given.items() if name in fields}
    return cls(**{**asked, **given_values(cls, table, true_share)})


def given_values(cls: type, table: dict[str, Any], true_share: TrueShare | None = None) -> dict[str, Any]:
    """What a validated table sets of the fields of a class, by field, in SI."""
    keys = _keys(cls)
    inherited = true_share and _at_the_height_of(cls, table, true_share)
    found = {}
    for key, value in table.items():
        if value is not None and key in keys:
            one, factor = keys[key]
            found[one.attribute] = (
                value * factor if type(value) is float else _to_si(one.kind, value, factor, inherited)
            )
    indicated = [one for one in _airspeeds(cls) if any(table.get(key) is not None for key in one.indicated_keys)]
    if indicated:
        assert true_share is not None, f"{cls.__name__} has indicated airspeeds, but no air"
        defaults = {one.attribute: one.default for one in parameters(cls) if not one.required}
        share = true_share({**defaults, **found}.get("height"))
        found |= {one.attribute: share * found[one.attribute] for one in indicated}
    return found


def _at_the_height_of(cls: type, table: dict[str, Any], true_share: TrueShare) -> TrueShare:
    """The share for tables within a table, which are at its height where they say none."""
    own = next((one for one in parameters(cls) if one.attribute == "height"), None)
    if own is None:
        return true_share
    said = [float(table[key]) * factor for key, factor in own.keys.items() if table.get(key) is not None]
    height = said[0] if said else own.default
    return lambda within: true_share(height if within is None else within)


@cached
def _keys(cls: type) -> dict[str, tuple[Parameter, float]]:
    """Every key of a class, with what it sets and its factor to SI."""
    return {key: (one, factor) for one in parameters(cls) for key, factor in one.keys.items()}


def spellings_in(cls: type, table: dict[str, Any]) -> dict[str, str]:
    """The key by which a validated table sets each field of a class that it sets, by field."""
    keys = _keys(cls)
    return {keys[key][0].attribute: key for key in table if key in keys}


@cached
def _airspeeds(cls: type) -> tuple[Parameter, ...]:
    return tuple(one for one in parameters(cls) if one.is_airspeed)


def _to_si(hint: Any, value: Any, factor: float, true_share: TrueShare | None) -> Any:
    if isinstance(value, float):
        return value * factor
    if isinstance(value, bool | str) or value is None:
        return value
    nested = _nested(hint)
    if nested is not None and isinstance(value, dict):
        return construct(nested, value, true_share)
    if isinstance(value, list | tuple):
        element = _element(hint)
        return tuple([_to_si(element, item, factor, true_share) for item in value])
    if isinstance(value, dict):
        return value
    if isinstance(value, int) and factor == 1.0 and (hint is int or hint == (int | None)):
        return value
    return float(value) * factor


@cached
def _element(hint: Any) -> Any:
    """The type of what a list holds."""
    arguments = typing.get_args(hint)
    return arguments[0] if arguments else Any


@cached
def _nested(hint: Any) -> type | None:
    for candidate in (hint, *typing.get_args(hint)):
        if dataclasses.is_dataclass(candidate) and isinstance(candidate, type):
            return candidate
    return None


def dump(instance: Any, *chosen: Parameter) -> dict[str, Any]:
    """A table that reads back as ``instance``, in the preferred spellings; what is None is left out.

    Of single parameters, where some are chosen.
    """
    table: dict[str, Any] = {}
    for parameter in chosen or parameters(type(instance)):
        value = getattr(instance, parameter.attribute)
        if value is None:
            continue
        key, factor = next(iter(parameter.keys.items()))
        table[key] = _from_si(value, factor)
    return table


def _from_si(value: Any, factor: float) -> Any:
    if dataclasses.is_dataclass(value):
        return dump(value)
    if isinstance(value, list | tuple):
        return [_from_si(item, factor) for item in value]
    if isinstance(value, dict):
        return dict(value)
    if isinstance(value, bool | str | int):
        return value
    return _shortest(float(value), factor)


@functools.lru_cache(maxsize=4096)
def _shortest(value: float, factor: float) -> float:
    """The shortest decimal that converts back to exactly ``value``."""
    if factor == 1.0:
        return value
    for digits in range(1, 18):
        candidate = float(f"{value / factor:.{digits}g}")
        if candidate * factor == value:
            return candidate
    neighbours = [value / factor]
    for direction in (-math.inf, math.inf):
        neighbours.append(math.nextafter(value / factor, direction))
    return next((n for n in neighbours if n * factor == value), value / factor)
