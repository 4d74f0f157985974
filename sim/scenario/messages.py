"""Faults of a scenario file in the user's own keys and words."""

from __future__ import annotations

import functools
import re
import typing
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from pydantic import BaseModel, ValidationError

from aircraft.errors import FlightError
from aircraft.units import SUFFIXES
from sim.errors import ScenarioError, did_you_mean, printable

MOST_FAULTS = 20  # told at once
MOST_HOMES = 3  # tables that are named for a key that stands in another
LONGEST_VALUE = 60  # characters of a value that is quoted
TOLD = {  # pydantic's kind of error -> what the value must be
    "missing": "is missing",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be text",
    "list_type": "must be a list",
    "tuple_type": "must be a list",
    "dict_type": "must be a table",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "string_pattern_mismatch": "must start with a letter and have at most 64 letters, digits, _ and -",
    "literal_error": "must be {expected}",
    "greater_than": "must be above {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be below {lt}",
    "less_than_equal": "must be at most {le:g}",
    "too_short": "must not be empty: give at least one",
    "too_long": "must have {max_length} values, not {actual_length}",
}

TYPES = ("str", "int", "float", "bool")  # as the end of a place: one of several types of the value
WRAPPED = re.compile(r"(function-|constrained-|list\[|tuple\[|dict\[)")
WRONG_TYPE = re.compile(r"(.*: must be )(text|a list|a number|a whole number|a table)( \(got .*\)|)", re.DOTALL)
MOVED = {("study", "checks"): "write each under [[checks]], with its share and confidence"}  # keys of old files


def report_faults(origin: str, faults: Iterable[str]) -> str:
    """One line for each different fault, and at the end how many more there are."""
    different = list(dict.fromkeys(faults))
    lines = [printable(f"{origin}: {fault}") for fault in different[:MOST_FAULTS]]
    if len(different) > MOST_FAULTS:
        lines.append(f"{origin}: and {len(different) - MOST_FAULTS} more faults")
    return "\n".join(lines)


@contextmanager
def at(origin: str, place: str, in_words: Callable[[str], str] = str) -> Iterator[None]:
    """What fails within is a fault of this place of a scenario; ``in_words`` tells it as its user would."""
    try:
        yield
    except (FlightError, ValueError) as error:
        raise ScenarioError(report_faults(origin, [f"{place} {in_words(str(error))}"])) from None
    except ArithmeticError as error:
        raise ScenarioError(f"{origin}: {place} no design is possible with these numbers: {error}") from None


def faults_of(
    model: type[BaseModel], error: ValidationError, owner: Callable[[list[Any], str], str | None]
) -> list[str]:
    """The faults that were found, the first of them in words; of the others only that they are there.

    ``owner`` says to which other kind a key belongs that a table does not know.
    """
    items = error.errors(include_url=False, include_context=True)
    told = _joined(fault(model, item, owner) for item in items[: 2 * MOST_FAULTS])
    return told + [str(number) for number in range(2 * MOST_FAULTS, len(items))]


def _joined(faults: Iterable[str]) -> list[str]:
    """The faults, with one for a value that is none of several types: ``must be text or a list``."""
    told: list[str] = []
    for one in faults:
        last = WRONG_TYPE.fullmatch(told[-1]) if told else None
        found = WRONG_TYPE.fullmatch(one)
        if last is not None and found is not None and last[1] == found[1]:
            told[-1] = f"{last[1]}{last[2]} or {found[2]}{found[3]}"
        else:
            told.append(one)
    return told


def fault(model: type[BaseModel], item: Any, owner: Callable[[list[Any], str], str | None]) -> str:
    """One fault: where it is, what is wrong, what is allowed."""
    location = list(item["loc"])
    if item["type"] == "extra_forbidden":
        place, key = location[:-1], str(location[-1])
        if (*place, key) in MOVED:
            return f"{_place(place)}{key}: no such key; {MOVED[*place, key]}"
        allowed = _keys(model, place)
        same = [name for name in allowed if stem(name) == stem(key)]
        hint = f"write it as {' or '.join(same[:3])}" if same and stem(key) != key else did_you_mean(key, allowed)
        if same and stem(key) == key and key not in allowed:
            hint = f"it needs its unit: {' or '.join(same[:3])}"
        elif key not in allowed and (homes := _homes(model, key)):
            hint = f"it belongs to another table: {' or '.join(homes)}"
        elif hint.startswith("allowed"):  # nothing near
            hint = owner(place, key) or hint
        return f"{_place(place)}{key}: no such key; {hint}"
    message = item["msg"].removeprefix("Value error, ")
    plain = TOLD.get(item["type"], message[0].lower() + message[1:]).format(**item.get("ctx", {}))
    keys = [part for part in location if not (isinstance(part, str) and WRAPPED.match(part))]
    if keys and keys[-1] in TYPES and item["type"] != "missing":
        keys.pop()
    if item["type"] == "value_error" and isinstance(item.get("input"), dict):  # about a whole table
        return f"{_place(keys)}{plain}"
    if item["type"] == "missing" and keys and isinstance(keys[-1], int):
        keys, plain = keys[:-1], f"must have more than {keys[-1]} values"
    if keys and isinstance(keys[-1], int):
        what = f"{plain}{_shown(item.get('input'))}"
        of_tables = item["type"] in ("model_type", "model_attributes_type", "dict_type") or len(keys) < 2
        return f"{_place(keys)}{what}" if of_tables else f"{_place(keys[:-2])}{keys[-2]}: entry {keys[-1]} {what}"
    return f"{_place(keys[:-1])}{keys[-1] if keys else ''}: {plain}{_shown(item.get('input'))}"


def stem(key: str) -> str:
    """A key without its unit suffix."""
    endings = [suffix for suffix in SUFFIXES if key.endswith(f"_{suffix}")]
    return key[: -len(max(endings, key=len)) - 1] if endings else key


@functools.lru_cache(maxsize=1024)
def quantity(key: str) -> str:
    """What a key sets, whatever its unit, and whether as a true or as an indicated airspeed."""
    return stem(key).removeprefix("indicated_")


def _shown(value: Any) -> str:
    if not isinstance(value, str | int | float | bool):
        return ""
    text = str(value).lower() if isinstance(value, bool) else repr(value)
    return f" (got {text})" if len(text) <= LONGEST_VALUE else f" (got {text[:LONGEST_VALUE]}...)"


def _place(location: list[Any]) -> str:
    if not location:
        return ""
    tables = [str(part) for part in location if isinstance(part, str) and "[" not in part]
    numbers = [f" entry {part}" for part in location if isinstance(part, int)]
    address = f"[[{'.'.join(tables)}]]" if numbers else f"[{'.'.join(tables)}]"
    return f"{address}{''.join(numbers)} "


def _keys(model: Any, place: list[Any]) -> list[str]:
    """Legal keys of the table at ``place``."""
    for part in place:
        if isinstance(part, int):
            continue
        fields = getattr(model, "model_fields", {})
        if part not in fields:
            return []
        model = _model_in(fields[part].annotation)
    return [key for key in getattr(model, "model_fields", {}) if not key.startswith("_")]


def _homes(model: Any, key: str) -> list[str]:
    """Where else in a file a key is at home, ``table.key``; none for keys that most tables have."""
    tables = {name: _model_in(field.annotation) for name, field in model.model_fields.items()}
    for name, table in tables.items():  # wind_speed_kt
        if (own := key.removeprefix(f"{name}_")) != key and own in getattr(table, "model_fields", ()):
            return [f"{name}.{own}"]
    homes = [f"{name}.{key}" for name, table in tables.items() if key in getattr(table, "model_fields", ())]
    return homes if len(homes) <= MOST_HOMES else []


def _model_in(annotation: Any) -> Any:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in typing.get_args(annotation):
        found = _model_in(argument)
        if found is not None:
            return found
    return None
