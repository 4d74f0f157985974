"""The reference of scenario files, a page made from their JSON Schema: every table, kind and key."""

from __future__ import annotations

import json
from typing import Any

from aircraft.ranges import shown
from sim.scenario import catalogue, tables
from sim.scenario.arrivals import navigation, vectored
from sim.scenario.editors.json_schema import schema
from sim.scenario.messages import stem
from sim.scenario.recording import table as record

HEAD = """# Scenario reference

Every table and key of a scenario file, made from its schema (`shortfinal schema > scenario.schema.json`, which editors
take for completion). [Writing a scenario](scenarios.md) explains how one is put together.

A number with a unit has it in its key. Of several spellings the first is shown and the others follow in small print; a
table has one of them. A *limit* is of the first spelling. What has no default may be left out, or is designed from the
aircraft, unless it is *required*.
"""
FAMILIES = {"autopilot": "modes", "sensors": "sensors", "trackers": "trackers", "events": "wind_events"}
DESCRIBED = (tables, navigation, vectored, record)
HUGE = 1e3  # a limit of this size on both sides only keeps out what nothing real has
LIMITS = (
    ("exclusiveMinimum", "above "),
    ("minimum", "at least "),
    ("exclusiveMaximum", "below "),
    ("maximum", "at most "),
)
TYPES = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false"}

LISTS = {"number": "list of numbers", "integer": "list of whole numbers", "string": "list of names"}

Schema = dict[str, Any]


def reference(root: Schema | None = None) -> str:
    """The whole page as Markdown."""
    root = schema() if root is None else root
    plain = {key: value for key, value in root["properties"].items() if not _inner(root, value)[1]}
    parts = [HEAD, "\n## At the top\n\n", _table(root, plain, root.get("required", []))]
    for key, value in root["properties"].items():
        if key not in plain:
            parts.append(_section(root, key, value, 2))
    return "".join(parts)


def _inner(root: Schema, value: Schema) -> tuple[str, list[str]]:
    """How the tables of a key are written, and the names of their definitions; none where it holds no table."""
    shape = "[{}]"
    if value.get("type") == "array" and isinstance(value.get("items"), dict):
        value, shape = value["items"], "[[{}]]"
    elif isinstance(value.get("additionalProperties"), dict):
        value, shape = value["additionalProperties"], "[{}.NAME]"
    kinds = [one["then"] for one in value.get("allOf", []) if "then" in one]  # a table with kinds
    named = [one["$ref"].rsplit("/", 1)[1] for one in kinds or [value] if "$ref" in one]
    return shape, named


def _section(root: Schema, path: str, value: Schema, level: int) -> str:
    """A table of the file with all its kinds; tables inside of it follow it."""
    shape, names = _inner(root, value)
    heading = shape.format(path)
    text = f"\n{'#' * level} `{heading}`\n\n"
    if "description" in value:
        text += value["description"] + "\n\n"
    kinds = [root["$defs"][name]["properties"].get("kind", {}).get("const") for name in names]
    if len(names) > 1:
        text += "Of one `kind`: " + ", ".join(f"`{kind}`" for kind in kinds) + ".\n"
    shared = _shared([root["$defs"][name]["properties"] for name in names]) if len(names) > 1 else {}
    if shared:
        text += "\nAll kinds have\n\n" + _table(root, shared, [])
    for name, kind in zip(names, kinds, strict=True):
        model = root["$defs"][name]
        if len(names) > 1:
            text += f"\n{'#' * (level + 1)} `{kind}`\n\n"
        text += _said(model, name, path.rsplit(".", 1)[-1], kind)
        own = {key: one for key, one in model["properties"].items() if key not in shared and key != "kind"}
        text += _table(root, own, model.get("required", [])) if own else "No keys of its own.\n"
        for key, one in model["properties"].items():
            if key not in shared and _inner(root, one)[1]:
                text += _section(root, f"{shape.strip('[]').format(path)}.{key}", one, level + (2 if kind else 1))
    return text


def _shared(each: list[Schema]) -> Schema:
    """The keys that all kinds have alike."""
    first, *others = each
    return {k: v for k, v in first.items() if k != "kind" and all(one.get(k) == v for one in others)}


def _said(model: Schema, name: str, path: str, kind: str | None) -> str:
    """What a table is: in the words of its schema, else in the first ones of its class."""
    text = model.get("description")
    family = FAMILIES.get(path)
    if text is None and kind is not None and family is not None:
        text = catalogue.load(family, kind).__doc__
    if text is None:
        classes = (getattr(module, name, None) for module in DESCRIBED)
        text = next((found.__doc__ for found in classes if found is not None and "model_" not in str(found)), None)
    return " ".join(text.split("\n\n")[0].split()) + "\n\n" if text else ""


def _table(root: Schema, properties: Schema, required: list[str]) -> str:
    """Keys with all their spellings in one row each."""
    groups: dict[str, list[str]] = {}
    for key in properties:
        groups.setdefault(stem(key), []).append(key)
    rows = ["| key | what it takes | default | limit |\n|---|---|---|---|\n"]
    for keys in groups.values():
        first, value = keys[0], properties[keys[0]]
        also = " ".join(f"`{key}`" for key in keys[1:])
        small = f"<br><small>{also}</small>" if also else ""
        words = value.get("description", "").split("; ")
        default = next((f"`{one.removeprefix('default ')}`" for one in words if one.startswith("default ")), "")
        limit = next((one for one in words if one.startswith(tuple(sign for _, sign in LIMITS))), "")
        note = "required" if first in required else ""
        told = (one for one in words if one != limit and not one.startswith("default "))
        notes = "; ".join(filter(None, (note, *told, _extra(value))))
        takes = "; ".join(filter(None, (_takes(root, first, value), notes)))
        cells = [f"`{first}`{small}", takes, default or _default(value), limit or _limit(value)]
        rows.append("| " + " | ".join(cell.replace("|", "/").replace("\n", " ") for cell in cells) + " |\n")
    return "".join(rows)


def _default(value: Schema) -> str:
    found = value.get("default")
    return "" if found is None else f"`{json.dumps(found)}`"


def _bare(value: Schema) -> list[Schema]:
    """The alternatives of a value but null."""
    return [one for one in value.get("anyOf", [value]) if one.get("type") != "null"]


def _takes(root: Schema, key: str, value: Schema) -> str:
    if _inner(root, value)[1]:
        return "table, see below"
    words = []
    for one in _bare(value):
        if "enum" in one or "const" in one:
            words.append(", ".join(f"`{choice}`" for choice in one.get("enum", [one.get("const")])))
        elif one.get("type") == "array" and "prefixItems" in one:
            words.append(f"{len(one['prefixItems'])} numbers")
        elif one.get("type") == "array":
            words.append(
                f"list of {TYPES.get(one.get('items', {}).get('type', ''), 'value')}s".replace("texts", "names")
            )
        elif one.get("type") == "object":
            words.append("table")
        else:
            words.append(TYPES.get(one.get("type", ""), "any value"))
    return " or ".join(dict.fromkeys(words))


def _limit(value: Schema) -> str:
    found = []
    for one in _bare(value):
        low, high = one.get("minimum"), one.get("maximum")
        if low is not None and high is not None and low == -high and high >= HUGE:
            continue
        found += [f"{sign}{shown(one[name])}" for name, sign in LIMITS if name in one]
        if "pattern" in one:
            found.append(f"`{one['pattern']}`")
    return ", ".join(found)


def _extra(value: Schema) -> str:
    """What the schema says beyond the standard: a unit, an example."""
    said = [f"{key.removeprefix('x-')}: {one}" for key, one in value.items() if key in ("unit", "units", "examples")]
    return "; ".join(said + [f"{key[2:]}: {one}" for key, one in value.items() if key.startswith("x-")])


if __name__ == "__main__":
    print(reference())
