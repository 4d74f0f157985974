"""The same bytes hold on one kind of processor: a study knows which, a resume says so, a cluster refuses others."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from sim.studies import folder as folders
from sim.studies import study as studies
from sim.versions import processor
from sim.workers import cluster
from tests.capture import CAPTURE
from tests.sim.studies.test_study import Inline

TABLES = {**CAPTURE, "name": "short", "until_s": 2.0, "study": {"axes": {"start.cross_track_m": [0, 10]}}}
ANOTHER = "numpy on Haswell, scipy on Haswell, loops of AVX2"


@pytest.fixture
def begun(tmp_path):
    studies.study(TABLES, tmp_path, Inline())
    return tmp_path


def test_a_study_keeps_the_kind_and_a_resume_on_it_says_nothing(begun):
    assert json.loads((begun / folders.IDENTITY).read_text(encoding="utf-8"))["processor"] == processor()
    said = []
    studies.resume(begun, Inline(), remark=said.append)
    assert said == []


def test_another_kind_is_a_remark_and_the_study_goes_on(begun, monkeypatch):
    before = (begun / "metrics.json").read_bytes()
    monkeypatch.setattr(folders, "processor", lambda: ANOTHER)
    said = []
    studies.resume(begun, Inline(), remark=said.append)
    studies.study(TABLES, begun, Inline(), remark=said.append)
    first, second = said
    assert first == second
    assert f"was begun on another kind of processor ({processor()}; here {ANOTHER})" in first
    assert (begun / "metrics.json").read_bytes() == before  # nothing was flown again, and the remark is no figure


def test_a_study_of_before_says_nothing(begun):
    place = begun / folders.IDENTITY
    identity = json.loads(place.read_text(encoding="utf-8"))
    del identity["processor"]
    place.write_text(json.dumps(identity), encoding="utf-8")
    said = []
    studies.resume(begun, Inline(), remark=said.append)
    assert said == []


def test_a_worker_of_another_kind_is_refused(monkeypatch):
    client = {**cluster.numerics(), "processor": ANOTHER}
    answer = cluster._run(client, lambda: pytest.fail("it flew"))
    assert f"processor {processor()}, not {ANOTHER}" in answer.reason


def test_the_kind_follows_what_openblas_is_told():
    """Where numpy brings its OpenBLAS, the name is that of the kernels in use and not of the machine."""
    if "numpy on unknown" in processor():
        pytest.skip("this numpy does not tell what its BLAS runs on")
    asked = {"OPENBLAS_CORETYPE": "Nehalem"}  # which every processor of this family can be
    code = "from sim.versions import processor; print(processor())"
    if "numpy on arm" in processor().lower() or "numpy on neo" in processor().lower():
        pytest.skip("the name of another family")
    told = subprocess.run([sys.executable, "-c", code], env={**os.environ, **asked}, capture_output=True)
    assert told.stdout.decode().startswith("numpy on Nehalem, ")
