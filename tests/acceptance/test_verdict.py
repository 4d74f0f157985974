"""One verdict whatever the door: known faults, and shares at exactly what is asked."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from sim.metrics.ensemble.verdict import failures_allowed, verdicts
from sim.scenario.tables import Check
from sim.studies import study as studies
from sim.workers.executors import LocalExecutor
from tests.sim.known_faults import files

pytestmark = pytest.mark.acceptance
ROOT = Path(__file__).resolve().parents[2]
EACH = 20  # files with a fault, and as many without
FIXTURE = """
import json, pathlib, pytest
HERE = pathlib.Path(__file__).parent
@pytest.mark.parametrize("name", sorted(path.name for path in HERE.glob("*.scenario.toml")))
def test_file(shortfinal, name):
    checks = shortfinal(name).metrics["checks"]
    (HERE / f"{name}.fixture.json").write_text(json.dumps(checks))
"""


def called(*arguments: object, folder: Path) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", *map(str, arguments)]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def by_pytest(folder: Path) -> dict[str, tuple[bool, str]]:
    """Whether the item of each file passed, and what it said."""
    called("pytest", "-q", "-p", "no:cacheprovider", "--rootdir", folder, "--junitxml=found.xml", folder=folder)
    found = {}
    for case in ElementTree.parse(folder / "found.xml").iter("testcase"):
        failure = case.find("failure")
        text = "" if failure is None else f"{failure.get('message')}\n{failure.text}"
        name = case.get("classname", "").rpartition(".scenario")[0] or case.get("classname", "")
        found[f"{name} {case.get('name')}"] = (failure is None, text)
    return found


def test_one_file_five_doors(row, tmp_path):
    """Six flights of two legs in moderate turbulence; the limits lie between what the flights are measured to do."""
    known = list(files(EACH))
    numbers, wrong = [], []
    for file in known:
        (tmp_path / f"{file.name}.scenario.toml").write_text(file.text)
    (tmp_path / "test_fixture.py").write_text(FIXTURE)
    items = by_pytest(tmp_path)
    for file in known:
        place = tmp_path / f"{file.name}.scenario.toml"
        done = called("sim", "run", place, "--json", "-o", tmp_path / "run", folder=tmp_path)
        doors = {"run": json.loads(done.stdout)["checks"]}
        for workers in (1, 2):
            more = {} if "[study]" in file.text else {"study.samples": 1}
            out = tmp_path / f"{file.name}-{workers}"
            doors[f"study -j {workers}"] = studies.study(place, out, LocalExecutor(workers), more)["checks"]
        doors["fixture"] = json.loads((tmp_path / f"{place.name}.fixture.json").read_text())
        passed, said = next(item for name, item in items.items() if f"{file.name} " in name or file.name == name)
        good = file.faulty is None
        (check,) = doors["run"]
        told = [(door, found[0]["passed"], found[0]["flight"]) for door, found in doors.items()]
        wrong += [f"{file.name} {door}" for door, verdict, flight in told if verdict is not good]
        wrong += [
            f"{file.name} {door}: flight {flight}" for door, _, flight in told if not good and flight != file.faulty
        ]
        wrong += [f"{file.name} pytest"] if passed is not good else []
        wrong += [f"{file.name} exit {done.returncode}"] if done.returncode != (0 if good else 1) else []
        numbers += [found == doors["run"] for found in doors.values()]
        sentence = f"= {check['value']:.4g}"
        numbers.append(good or (sentence in said and f"flight {file.faulty}, seed" in said and "--flight" in said))
    told = f"{len(known)} files, {len(wrong)} wrong verdicts{': ' if wrong else ''}{', '.join(wrong)}; " + (
        "all numbers equal" if all(numbers) else f"{numbers.count(False)} numbers differ"
    )
    row(
        "one file, five doors: 20 files with a fault in a flight after the first, 20 without",
        "equal verdicts and numbers; 0 false passes, 0 false failures", told, not wrong and all(numbers),
    )  # fmt: skip
    assert not wrong
    assert all(numbers)


def test_share_at_exactly_what_is_asked(row):
    """400 repeats of 200 flights, each of which keeps the check with exactly the stated share."""
    share, confidence, flights = 0.95, 0.9, 200
    generator = np.random.default_rng(15)
    check = Check("bank_deg", max=10.0, share=share, confidence=confidence)

    def record(number: int, margin: float) -> dict:
        result = {"limit": 10.0, "value": 10.0 - margin, "margin": margin, "time_s": 0.0, "passed": margin >= 0}
        return {"flight": number, "metrics": {"outcome": "completed"}, "checks": [result]}

    passed = 0
    for _ in range(400):
        margins = np.where(generator.random(flights) < share, 1.0, -1.0)
        (found,) = verdicts([check], [record(k, float(margin)) for k, margin in enumerate(margins)])
        passed += found["passed"]
    fewest = flights - failures_allowed(flights, share, confidence)
    sums = [
        sum(math.comb(flights, k) * share**k * (1 - share) ** (flights - k) for k in range(kept, flights + 1))
        for kept in range(flights + 1)
    ]
    by_hand = next(kept for kept, tail in enumerate(sums) if tail <= 1 - confidence)
    told = (
        f"{100 * passed / 400:.1f} % of 400 pass, {100 * sums[fewest]:.2f} % by the binomial sum; "
        f"at least {fewest} of 200 kept, {by_hand} by hand"
    )
    met = passed / 400 <= 0.13 and fewest == by_hand
    row("share 0.95 with confidence 0.9 where the share is exactly 0.95", "<= 10 % + 3 points pass", told, met)
    assert met
