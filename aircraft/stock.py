"""What was measured of JSBSim's own aircraft: a table that travels with the package, good for one version of JSBSim."""

from __future__ import annotations

import functools
import tomllib
from importlib.metadata import version
from pathlib import Path
from typing import Any

from aircraft.model_files import OWN_MODELS, folder
from aircraft.repairs import is_stock

STOCK_TABLE = OWN_MODELS / "stock.toml"


def stock_row(model: str | Path) -> dict[str, Any]:
    """The row of a stock aircraft; empty where there is none, and of other aircraft."""
    row: dict[str, Any] = _table().get(folder(model).name, {}) if is_stock(model) else {}
    return row


@functools.cache
def _table() -> dict[str, Any]:
    table = tomllib.loads(STOCK_TABLE.read_text(encoding="utf-8")) if STOCK_TABLE.is_file() else {}
    same = table.pop("versions", {}).get("jsbsim") == version("jsbsim")
    return table if same else {}
