"""The JSON Schema of a scenario file over all kinds, as editors and validators of others take it.

pydantic's own is made plain: TOML has no null, and a table with kinds is judged by the kind that it names, so that a
slip in one key is told as that and not as "matches none of sixteen kinds".
"""

from __future__ import annotations

import types
import typing
from typing import Annotated, Any

from pydantic import BaseModel, Field

from sim.scenario import catalogue as bundled
from sim.scenario.axes import DISTRIBUTIONS, LARGEST_GRID, LARGEST_NUMBER
from sim.scenario.plugins import BUNDLED, Catalogue
from sim.scenario.schema import MODELS, MOST_NAMES, NAME, RESERVED, ROUTES, file_model, route_model, wind_model

DIALECT = "https://json-schema.org/draft/2020-12/schema"
NULL = {"type": "null"}


def schema(catalogue: Catalogue = BUNDLED) -> dict[str, Any]:
    """JSON Schema of a scenario file over all kinds that are bundled or brought; installed ones are not imported."""

    def union(models: list[type[BaseModel]]) -> Any:
        if len(models) == 1:
            return models[0]
        return Annotated[typing.Union[tuple(models)], Field(discriminator="kind")]  # noqa: UP007 (built at run time)

    def models(family: str) -> Any:
        kinds = [*bundled.kinds(family), *(part.kind for part in catalogue.parts if part.family == family)]
        return union([MODELS[family](catalogue.load(family, kind), kind) for kind in sorted(kinds)])

    def named(family: str) -> Any:
        names: dict[str, Any] = {"pattern": f"^{NAME.pattern}$"}
        if family in RESERVED:
            names["not"] = {"enum": [*RESERVED[family]]}
        more: dict[str, Any] = {"propertyNames": names, "maxProperties": MOST_NAMES}
        return Annotated[types.GenericAlias(dict, (str, models(family))), Field(json_schema_extra=more)]

    parts: dict[str, Any] = {
        "route": union([route_model(kind) for kind in ROUTES]),
        "wind": wind_model(named("wind_events")),
        "autopilot": models("modes"),
        "sensors": named("sensors"),
        "trackers": named("trackers"),
    }
    found: dict[str, Any] = file_model(**parts).model_json_schema()
    found["required"] = [key for key in found["required"] if key != "name"]  # what has none is called as its file is
    plain = {"$schema": DIALECT, **_plain(found, found["$defs"])}
    plain["$defs"]["StudyTable"]["properties"]["axes"] |= {"additionalProperties": _axis(), "minProperties": 1}
    return plain


def _axis() -> dict[str, Any]:
    """What an axis of a study may be: a list of values, or one form of values that are counted or drawn."""
    number = {"type": "number", "minimum": -LARGEST_NUMBER, "maximum": LARGEST_NUMBER}

    def numbers(least: int, most: int) -> dict[str, Any]:
        return {"type": "array", "items": number, "minItems": least, "maxItems": most}

    forms = {kind: numbers(2, 2) for kind in DISTRIBUTIONS}
    count = {"type": "integer", "minimum": 1, "maximum": LARGEST_GRID}
    forms |= {"grid": {**numbers(3, 3), "prefixItems": [number, number, count]}, "normal": numbers(2, 4)}
    forms["quantiles"] = {"type": "array", "items": numbers(2, 2), "minItems": 2}
    one = {"minProperties": 1, "maxProperties": 1, "additionalProperties": False, "properties": forms}
    return {"if": {"type": "array"}, "then": {"minItems": 1}, "else": {"type": "object", **one}}


def _plain(node: Any, definitions: dict[str, Any]) -> Any:
    """A part of pydantic's schema without nulls and made-up titles, its tables with kinds judged by their kind."""
    if isinstance(node, list):
        return [_plain(item, definitions) for item in node]
    if not isinstance(node, dict):
        return node
    if "discriminator" in node:
        return _by_kind(node, definitions)
    plain = {
        key: _plain(item, definitions)
        for key, item in node.items()
        if not (key == "title" and isinstance(item, str)) and not (key == "default" and item is None)
    }
    if NULL in plain.get("anyOf", ()):
        left = [one for one in plain.pop("anyOf") if one != NULL]
        plain = {**(left[0] if len(left) == 1 else {"anyOf": left}), **plain}
    return plain


def _by_kind(node: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """A table that is of one of several kinds, each of which is asked alone of a table that names it."""
    kinds = node["discriminator"]["mapping"]
    required = {kind: definitions[place.rpartition("/")[2]].get("required", ()) for kind, place in kinds.items()}
    needed = {kind: "kind" in keys for kind, keys in required.items()}
    branches = [
        {
            "if": {"properties": {"kind": {"const": kind}}, **({"required": ["kind"]} if needed[kind] else {})},
            "then": {"$ref": place},
        }
        for kind, place in kinds.items()
    ]
    # editors that complete keys look into anyOf, and not all of them into then; "true" leaves the judging to the latter
    offered = [True, *({"$ref": place} for place in kinds.values())]
    table = {"type": "object", "properties": {"kind": {"enum": [*kinds]}}, "allOf": branches, "anyOf": offered}
    return table if not all(needed.values()) else {**table, "required": ["kind"]}
