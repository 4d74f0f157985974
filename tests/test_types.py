"""What a user's type checker and ``help(sim)`` say of the verbs and the data that pass between them."""

from __future__ import annotations

import dataclasses
import re
import subprocess
import sys
from pathlib import Path

import pytest

import sim

ROOT = Path(__file__).resolve().parent.parent
GOOD = """
import sim

result = sim.run("an26_pattern", seed=1, overrides={"wind.speed_mps": 5})
flight: sim.Flight = result.flight
outcome: str = flight.outcome
sink: float = result.metrics["flight"]["touchdown"]["sink_mps"]
estimates: sim.Track = result.tracks["radar"].track
page: str = sim.report(result, "out").name
again: sim.Result = sim.load("out")
names: dict[str, str] = sim.figures(again)
result.plot("plan").savefig("plan.png")
result.to_dataframe("flight")
rows = sim.study("zmax_mismatch", "out/study", flights=1).metrics["rows"]
text: str = sim.explain("an26_pattern", {"wind.speed_mps": 5})


class Mine:
    channels = ("north", "north_rate", "east", "east_rate")


mine: sim.OwnTracker = sim.tracker(Mine, sensors=["radar"], law="autopilot", route=True)
sim.run("an26_pattern", trackers={"mine": mine})
record: sim.SensorRecord = sim.observe(flight, result.scenario.sensors, seed=2)["radar"]
"""
BAD = """
import sim

sim.run("an26_pattern", seed="one")
sim.rnu("an26_pattern")
outcome: int = sim.run("an26_pattern").flight.outcome
sim.fly(sim.read("an26_pattern"), flight=1.5)
"""
VERBS = [name for name in sim.__all__ if name[0].islower()]
REVEALED = "import sim\n" + "".join(f"reveal_type(sim.{name})\n" for name in VERBS)
DATA = [name for name in sim.__all__ if name[0].isupper() and not name.endswith("Error")]


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What a strict mypy says, by file, to somebody who has programs and packages; its cache is that of lint."""
    pytest.importorskip("mypy")
    folder = tmp_path_factory.mktemp("user")
    files = {name: folder / name for name in ("good.py", "bad.py", "revealed.py")}
    files["good.py"].write_text(GOOD)
    files["bad.py"].write_text(BAD)
    files["revealed.py"].write_text(REVEALED)
    command = [sys.executable, "-m", "mypy", "--strict", *map(str, files.values())]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert "checked 3 source files" in done.stdout, done.stdout + done.stderr
    lines = done.stdout.splitlines()
    return {name: [line for line in lines if Path(line.partition(":")[0]).name == name] for name in files}


def test_a_users_program_passes_mypy(told):
    assert told["good.py"] == []


def test_a_wrong_argument_a_misspelt_verb_and_a_wrong_use_are_told(told):
    kinds = [re.search(r":(\d+): error: .*\[(\S+)\]", line).groups() for line in told["bad.py"]]
    assert kinds == [("4", "arg-type"), ("5", "attr-defined"), ("6", "assignment"), ("7", "arg-type")]


def test_no_verb_is_any_nor_gives_it(told):
    """What an editor completes by: each verb has its parameters, and its value a type."""
    types = [re.search(r'Revealed type is "(.*)"$', line)[1] for line in told["revealed.py"] if "Revealed" in line]
    assert len(types) == len(VERBS)
    for name, kind in zip(VERBS, types, strict=True):
        assert kind.startswith("def "), f"{name}: {kind}"
        assert "->" in kind, f"{name}: {kind}"
        assert kind.rpartition("-> ")[2] != "Any", f"{name}: {kind}"
    (run,) = [kind for name, kind in zip(VERBS, types, strict=True) if name == "run"]
    assert "plugins: Any" not in run
    assert run.endswith("-> sim.results.result.Result")


def sections():
    """Text of ``sim.__doc__`` on each type of data."""
    page = sim.__doc__.partition("\nData\n----\n")[2].partition("\nErrors\n----")[0]
    parts = re.split(r"^- `(\w+)` - ", page, flags=re.M)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def fields(kind):
    return kind._fields if issubclass(kind, tuple) else [field.name for field in dataclasses.fields(kind)]


def test_the_page_of_sim_names_every_type_of_data():
    assert sorted(sections()) == sorted(DATA)


@pytest.mark.parametrize("name", DATA)
def test_the_page_of_sim_names_every_field_and_no_other(name):
    kind = getattr(sim, name)
    named = re.findall(r"``(\w+)``", sections()[name])
    assert set(fields(kind)) <= set(named)
    assert not [word for word in named if word not in fields(kind) and not hasattr(kind, word)]


@pytest.mark.parametrize("name", sim.__all__)
def test_the_page_of_sim_says_where_each_thing_lives(name):
    (line,) = re.findall(rf"^- `{name}` - .*$", sim.__doc__, flags=re.M)
    assert line.endswith(f"({getattr(sim, name).__module__})")
