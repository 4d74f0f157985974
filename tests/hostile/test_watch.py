"""The watch itself: it must see what it is there for, or nothing that it reports means anything."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tests.hostile.models import MODELS
from tests.hostile.watched import Sandbox

RAW = """
import sys, jsbsim
jsbsim.FGJSBBase().debug_lvl = 0
executive = jsbsim.FGFDMExec(sys.argv[1])
executive.load_model(sys.argv[2])
executive.run_ic()
"""


@pytest.fixture
def sandbox(tmp_path):
    return Sandbox(tmp_path)


def python(sandbox, text, *arguments):
    """A watched process."""
    return subprocess.run(
        [sys.executable, "-c", text, *map(str, arguments)],
        env=sandbox.environment(),
        cwd=sandbox.place("cwd"),
        capture_output=True,
        check=False,
        timeout=60,
    )


def raw(sandbox, name):
    """JSBSim given a hostile model as it is, with nothing between."""
    root = sandbox.place("raw")
    for folder in ("aircraft", "engine", "systems"):
        (root / folder).mkdir()
    MODELS[name].write(root / "aircraft" / name, sandbox.place("target"))
    return python(sandbox, RAW, root, name)


def test_what_python_writes_outside_is_seen(sandbox):
    target = sandbox.place("target") / "x"
    python(sandbox, "import os, sys; open(sys.argv[1], 'w'); os.rename(sys.argv[1], sys.argv[1] + 'y')", target)
    assert {act[0] for act in sandbox.acts()} == {"open", "os.rename"}
    assert len(sandbox.offences()) == 2


def test_a_process_of_others_is_seen(sandbox):
    python(sandbox, "import subprocess; subprocess.run(['true'])")
    assert sandbox.offences() == ["subprocess.Popen true"]


def test_what_jsbsim_writes_by_itself_is_seen(sandbox):
    before = sandbox.files()
    raw(sandbox, "writes_a_file")
    assert set(sandbox.files()) - set(before) == {"target/out.csv"}


@pytest.mark.parametrize("name", ["sends", "listens"])
def test_a_socket_of_jsbsim_ends_the_process(sandbox, name):
    probe = "import json, sitecustomize; print(json.dumps(sitecustomize.bar_sockets()))"
    if not json.loads(python(sandbox, probe).stdout):
        pytest.skip("this system cannot bar sockets")
    assert raw(sandbox, name).returncode < 0
