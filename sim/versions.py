"""Versions of what decides the numbers of a run."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import platform

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


def versions() -> dict[str, str]:
    """Versions of what decides the numbers of a run."""
    found = {name: importlib.metadata.version(name) for name in ("jsbsim", "numpy", "scipy")}
    from sim import __version__

    return {"shortfinal": __version__, "python": platform.python_version(), "platform": platform.platform(), **found}
