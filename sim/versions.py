"""Versions of what decides the numbers of a run."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import platform
from collections.abc import Mapping
from typing import Any

__version__ = "0.1.0"
DISTRIBUTIONS = (
    "jsbsim",
    "numpy",
    "scipy",
    "control",
    "filterpy",
    "matplotlib",
    "pydantic",
    "typer",
    "jinja2",
    "pebble",
)


def versions(parts: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Versions of what decides the numbers of a run; ``parts`` from outside have their digests beside them."""
    found = {name: importlib.metadata.version(name) for name in ("jsbsim", "numpy", "scipy")}
    ours = {"shortfinal": __version__, "python": platform.python_version(), "platform": platform.platform(), **found}
    return {**ours, "parts": dict(parts)} if parts else ours


def rows(versions: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(name, version) of everything, parts from outside by their address, as a page or a sentence shows them."""
    ours = {name: version for name, version in versions.items() if name != "parts"}
    return sorted({**ours, **versions.get("parts", {})}.items())
