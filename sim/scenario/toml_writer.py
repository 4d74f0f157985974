"""Writes the resolved scenario as TOML; Python reads TOML but does not write it."""

from __future__ import annotations

import json
import re
from typing import Any

AXES = ("study", "axes")  # their order says which is drawn across and which up, so lists and grids are not parted
BARE = re.compile(r"[A-Za-z0-9_-]+")


def dumps(table: dict[str, Any]) -> str:
    """TOML text of nested dicts, lists of dicts, lists and scalars, in the order given; None is left out."""
    lines: list[str] = []
    _write(table, (), lines)
    return "\n".join(lines).strip() + "\n"


def _write(table: dict[str, Any], path: tuple[str, ...], lines: list[str]) -> None:
    on_lines = path == AXES
    plain = {k: v for k, v in table.items() if v is not None and (on_lines or not _is_table(v))}
    width = max((len(_key(k)) for k in plain), default=0)
    lines += [f"{_key(key):{width}} = {inline(value)}" for key, value in plain.items()]
    for key, value in table.items():
        if key in plain or not _is_table(value):
            continue
        name = ".".join(_key(part) for part in (*path, key))
        for item in value if isinstance(value, list) else [value]:
            lines += ["", f"[[{name}]]" if isinstance(value, list) else f"[{name}]"]
            _write(item, (*path, key), lines)


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


def _key(key: str) -> str:
    return key if BARE.fullmatch(key) else json.dumps(key)


def inline(value: Any) -> str:
    """A value as it stands behind an equals sign, on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, list | tuple):
        return f"[{', '.join(inline(item) for item in value)}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{_key(key)} = {inline(item)}' for key, item in value.items())} }}"
    return repr(value)
