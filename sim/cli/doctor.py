"""Checks the installation: versions, shadowed names, JSBSim, a place to write."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from sim.versions import DISTRIBUTIONS

PROBE = "import jsbsim; jsbsim.FGJSBBase().debug_lvl = 0; f = jsbsim.FGFDMExec(None); print(f.get_version())"


def examine() -> tuple[list[str], bool]:
    """Lines to show, and whether all is well."""
    rows: list[tuple[bool, str, str]] = [(sys.version_info >= (3, 11), "python", platform.python_version())]
    for name in DISTRIBUTIONS:
        try:
            rows.append((True, name, importlib.metadata.version(name)))
        except importlib.metadata.PackageNotFoundError:
            rows.append((False, name, "missing; install shortfinal again"))
    home = Path(__file__).resolve().parents[2]
    for name in ("aircraft", "autopilot", "tracking"):
        spec = importlib.util.find_spec(name)
        place = Path(spec.origin).resolve().parent if spec is not None and spec.origin else None
        good = place is not None and place.parent == home
        rows.append((good, f"package {name}", str(place) if good else f"shadowed by {place}; remove that distribution"))
    probe = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, timeout=60, check=False)
    rows.append((probe.returncode == 0, "JSBSim runs", probe.stdout.strip() or probe.stderr.strip().splitlines()[-1]))
    rows.append((os.access(tempfile.gettempdir(), os.W_OK), "temporary folder", tempfile.gettempdir()))
    rows.append(
        (os.access(".", os.W_OK), "this folder", "can be written" if os.access(".", os.W_OK) else "read-only: use -o")
    )
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    width = max(len(name) for _, name, _ in rows)
    lines = [f"{'good' if good else 'BAD ':4}  {name:{width}}  {text}" for good, name, text in rows]
    lines.append(f"note  {'browser':{width}}  {chromium or 'none on the PATH: report tests are skipped'}")
    return lines, all(good for good, _, _ in rows)
