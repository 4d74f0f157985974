"""Scenarios bent at random: values of the wrong kind or size, keys lost, renamed and moved, letters changed."""

from __future__ import annotations

import copy
import json
import math
from typing import Any

from hypothesis import strategies as st

ODD = (
    *(0, 1, -1, 7, 10**12, 10**400, 0.0, -0.0, 1e-300, 1e300, -1e300, 1e-3, 0.5, 89.9, 360.0),
    *(math.nan, math.inf, -math.inf, True, False),
    *("", "x", "none", "truth", "nan", "a\nb", "\x1b[31m", "../../x", "/etc/passwd", "\u202e", "x" * 3000),
    *([], [[]], [1, 2], [1.0, 2.0, 3.0], ["radar"], {}, {"x": 1}, {"kind": "mls"}, {"kind": "kalman"}),
)
FACTORS = (-1.0, 0.01, 0.5, 0.9, 1.1, 2.0, 100.0)  # of numbers that were good
NAMES = ("kind", "x", "a b", "", "speed", "speed_mps", "height_ft", "k1", "sensors", "law", "1", "\u00e9", "a\nb")

Path = tuple[str | int, ...]


def paths(value: Any, here: Path = ()) -> list[Path]:
    """Where all values and tables of a scenario are."""
    if isinstance(value, dict):
        inner = list(value.items())
    elif isinstance(value, list):
        inner = list(enumerate(value))
    else:
        inner = []
    return [here] * bool(here) + [path for key, item in inner for path in paths(item, (*here, key))]


def at(value: Any, path: Path) -> Any:
    """What is at a path."""
    for key in path:
        value = value[key]
    return value


@st.composite
def bent(draw: st.DrawFn, scenarios: list[dict[str, Any]]) -> str:
    """The text of a scenario after one to three changes."""
    tables = copy.deepcopy(draw(st.sampled_from(scenarios)))
    for _ in range(draw(st.sampled_from((1, 1, 1, 2, 2, 3)))):
        known = paths(tables)
        if not known:
            break
        *place, key = draw(st.sampled_from(known))
        table = at(tables, tuple(place))
        change = draw(st.sampled_from(("replace", "scale", "scale", "scale", "drop", "drop", "rename", "copy")))
        if change == "replace":
            table[key] = copy.deepcopy(draw(st.sampled_from(ODD)))
        elif change == "scale" and isinstance(table[key], float | int) and not isinstance(table[key], bool):
            factor = draw(st.sampled_from(FACTORS))
            table[key] = float(table[key]) * factor if abs(table[key]) < 1e300 else 1.0
        elif change == "drop":
            del table[key]
        elif change == "rename" and isinstance(table, dict):
            table[draw(st.sampled_from(NAMES))] = table.pop(key)
        elif change == "copy":
            table[key] = copy.deepcopy(at(tables, draw(st.sampled_from(known))))
    text = "\n".join(f"{json.dumps(key)} = {written(value)}" for key, value in tables.items())
    if draw(st.integers(0, 9)) == 0 and text:
        start = draw(st.integers(0, len(text) - 1))
        text = text[:start] + draw(st.text(max_size=3)) + text[start + draw(st.integers(0, 3)) :]
    return text


def written(value: Any) -> str:
    """A value as TOML, tables in one line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {written(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(written, value)) + "]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
