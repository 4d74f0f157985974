"""Versions of what decides the numbers of a run."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import importlib
import importlib.metadata
import importlib.util
import platform
from collections.abc import Mapping
from pathlib import Path
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
EXTRAS = {"cluster": "distributed", "parquet": "pyarrow", "pandas": "pandas", "stonesoup": "stonesoup"}
"""Extra of shortfinal -> the distribution that it brings; not those that build documents or test."""
HOME = Path(__file__).resolve().parents[1]
PACKAGES = ("aircraft", "autopilot", "tracking", "sim")
CORE_NAMES = tuple(f"{prefix}openblas_get_corename{suffix}" for prefix in ("scipy_", "") for suffix in ("64_", ""))


@functools.cache
def processor() -> str:
    """The kind of processor by which the arithmetic is chosen: what OpenBLAS and numpy's own loops run on here.

    Machines of two kinds round the last digit otherwise, with the same versions. ``unknown`` stands for what a
    distribution does not tell.
    """
    kinds = {name: _blas_core(name) for name in ("numpy", "scipy")}
    return ", ".join([*(f"{name} on {kind}" for name, kind in kinds.items()), f"loops of {_loops()}"])


def _blas_core(distribution: str) -> str:
    """What the OpenBLAS in the wheel of a distribution calls the processor."""
    spec = importlib.util.find_spec(distribution)
    home = Path(spec.origin).parent if spec is not None and spec.origin else Path()
    for library in sorted((*home.parent.glob(f"{distribution}.libs/*openblas*"), *home.glob(".dylibs/*openblas*"))):
        try:
            loaded = ctypes.CDLL(str(library))
        except OSError:
            continue
        for name in CORE_NAMES:
            ask = getattr(loaded, name, None)
            if ask is not None:
                ask.restype = ctypes.c_char_p
                return str(ask().decode(errors="replace"))
    return "unknown"


def _loops() -> str:
    """The widest instructions for which numpy has loops that this processor can run."""
    try:
        loops = importlib.import_module("numpy._core._multiarray_umath")
        return next((name for name in reversed(loops.__cpu_dispatch__) if loops.__cpu_features__[name]), "baseline")
    except (ImportError, AttributeError, KeyError):
        return "unknown"


def versions(parts: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Versions of what decides the numbers of a run; ``parts`` from outside have their digests beside them."""
    found = {name: importlib.metadata.version(name) for name in ("jsbsim", "numpy", "scipy")}
    ours = {"shortfinal": __version__, "python": platform.python_version(), "platform": platform.platform(), **found}
    return {**ours, "parts": dict(parts)} if parts else ours


@functools.cache
def program() -> str:
    """Digest of all files of our packages, data and templates too.

    A version tells a release; whoever edits the program must not get what the old one left.
    """
    found = hashlib.sha256()
    for package in PACKAGES:
        for path in sorted((HOME / package).rglob("*")):
            if "__pycache__" not in path.parts and path.is_file():
                content = path.read_bytes()
                found.update(f"{path.relative_to(HOME)} {len(content)}\n".encode() + content)
    return found.hexdigest()


def rows(versions: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(name, version) of everything, parts from outside by their address, as a page or a sentence shows them."""
    ours = {name: version for name, version in versions.items() if name != "parts"}
    return sorted({**ours, **versions.get("parts", {})}.items())
