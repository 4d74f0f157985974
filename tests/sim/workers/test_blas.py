"""The command has one BLAS thread, unless its user wants more."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

PROBE = """
import os, sys
from sim.cli import commands
assert "numpy" not in sys.modules, "too late for the setting"
commands.app = lambda **_: print(os.environ["OPENBLAS_NUM_THREADS"])
commands.main()
"""


@pytest.mark.parametrize(("wanted", "found"), [(None, "1"), ("2", "2")])
def test_the_command_sets_what_its_user_has_not_set(wanted, found):
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    if wanted is not None:
        environment["OPENBLAS_NUM_THREADS"] = wanted
    done = subprocess.run([sys.executable, "-c", PROBE], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == found
