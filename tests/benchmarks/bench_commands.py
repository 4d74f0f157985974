"""What the start of a command costs, what a helper process gains, and what is known from the command before."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from aircraft.model_files import stock_root
from sim.cache.user_cache import OFF, SWITCH

RUN = "import sim.cli.commands, sim.experiment"
STUDY = ["study", "bank_limit_map"]
FOREIGN = "c172x"  # a stock aircraft, taken for that of a user: nothing is known of its speeds
LEG = "[route]\nkind = 'legs'\n[[route.legs]]\nfrom_m = [0, 0]\nto_m = [20000, 0]\nspeed_mps = 45\nheight_m = 500\n"


def cost(command: list[str], **environment: str) -> tuple[float, float]:
    """CPU and wall seconds of a process with all that it starts; raises where it fails otherwise than by a check."""
    before, began = os.times(), time.perf_counter()
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, check=False)
    elapsed, after = time.perf_counter() - began, os.times()
    if done.returncode not in (0, 1):
        raise RuntimeError(done.stderr.decode())
    own = after.children_user + after.children_system - before.children_user - before.children_system
    return own, elapsed


def least(call: Callable[[], tuple[float, float]], times: int = 3) -> float:
    """Least CPU seconds of several."""
    return min(call()[0] for _ in range(times))


def shortfinal(*arguments: str) -> list[str]:
    """The command line in this interpreter."""
    return [sys.executable, "-m", "sim", *arguments]


def main() -> list[tuple[str, str, str]]:
    """Rows: what, measured, asked."""
    numpy = least(lambda: cost([sys.executable, "-c", "import numpy"]))
    imports = least(lambda: cost([sys.executable, "-c", RUN]))
    with tempfile.TemporaryDirectory() as place:
        home = Path(place)
        cached = {SWITCH: "on", "XDG_CACHE_HOME": str(home)}
        first = cost(shortfinal(*STUDY, "-o", str(home / "map")), **cached)[0]
        again = least(lambda: cost(shortfinal(*STUDY, "-o", str(home / "map")), **cached))
        drawn = cost(shortfinal(*STUDY, "-o", str(home / "map")), **{SWITCH: OFF})[0]

        shutil.copytree(stock_root() / "aircraft" / FOREIGN, home / FOREIGN)
        scenario = home / "theirs.toml"
        scenario.write_text(f"aircraft.model = '{home / FOREIGN}'\n{LEG}")
        validate = shortfinal("validate", str(scenario))
        unknown = cost(validate, **{SWITCH: OFF})[0]
        cost(validate, **cached)
        known = least(lambda: cost(validate, **cached))

        default = shortfinal("run", "-o", str(home / "run"))
        one = ["taskset", "-c", "0", *default]
        pairs = (
            [(cost(one, **cached)[1], cost(default, **cached)[1]) for _ in range(3)] if shutil.which("taskset") else []
        )
    gain = min(alone for alone, _ in pairs) / min(both for _, both in pairs) - 1.0 if pairs else float("nan")
    return [
        ("imports of a run over those of numpy, CPU", f"{imports / numpy:.1f}", "-"),
        ("study that is done / drawn again, CPU", f"{again / drawn:.3f}", "<= 0.15"),
        ("study that is done, s of CPU", f"{again:.2f}", "<= 1.5"),
        ("flown and drawn, s of CPU", f"{first:.0f}", "-"),
        (f"{FOREIGN} of a user: known / unknown, CPU", f"{known / unknown:.2f}", "-"),
        ("default run: gain of the helper process, wall", f"{100 * gain:.0f} %", ">= 15 %"),
    ]


if __name__ == "__main__":
    for row in main():
        print("  ".join(row))
