"""Bends scenarios with hypothesis and says what the program answers to each; runs under watch."""

from __future__ import annotations

import json
import os
import sys
import tomllib
import traceback
from pathlib import Path
from typing import Any

from batch import answer
from hypothesis import HealthCheck, Phase, given, seed, settings

SHORT = ("--set", "until_s=1", "--draws", "1", "--flights", "1")
BUNDLED = ("an26_pattern", "an26_mls_anomalies", "beacon_homing", "orbit_map")


def originals() -> list[dict[str, Any]]:
    """What is bent: the shortest scenario often, some bundled ones."""
    from sim.scenario.catalogue import bundled
    from tests.hostile.scenario_base import CAPTURE

    short = tomllib.loads(CAPTURE)
    jsbsim = {**short, "aircraft": {"model": "an26", "mass_kg": 20000.0, "factors": {"drag": 1.1}}}
    return [short, short, jsbsim, *(tomllib.loads(bundled(name).read_text()) for name in BUNDLED)]


def said(text: str, number: int, folder: Path, every: int) -> dict[str, object]:
    """The answer to one scenario; those that are good are flown, and of them every so many is run with its report."""
    file = folder / "bent.toml"
    file.write_text(text, encoding="utf-8", errors="replace")
    first = answer(["validate", "bent.toml"], str(folder))
    if first["code"] != 0:
        return first
    if number % every == 0:
        return answer(["run", "bent.toml", *SHORT, "-o", f"out/{number}"], str(folder))
    import sim

    try:
        sim.run(file, draws=1, flights=1, overrides={"until_s": 1.0})
    except sim.ScenarioError as error:
        return {"code": 2, "out": "", "err": f"shortfinal: {error}\n", "trace": ""}
    except Exception:  # the traceback that no user may see: the judge of the corpus counts it
        return {"code": -1, "out": "", "err": "", "trace": traceback.format_exc()}
    return first


def main(told: Path, folder: Path, examples: int, every: int) -> None:
    """One line for each scenario: its text and the answer."""
    from tests.hostile.mutations import bent

    file = told.open("w")
    count = 0

    @seed(1)
    @settings(
        max_examples=examples,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(text=bent(originals()))
    def each(text: str) -> None:
        nonlocal count
        count += 1
        print(json.dumps([text, said(text, count, folder, every)]), file=file, flush=True)

    each()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(os.getcwd()), int(sys.argv[2]), int(sys.argv[3]))
