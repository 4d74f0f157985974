"""judge: a file of tracks beside the trackers of a run, from tables and from ASTERIX, and what cannot be judged."""

from __future__ import annotations

import json

import pytest

NAME = "route_capture_point_mass"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    import sim

    place = tmp_path_factory.mktemp("judge") / "run"
    sim.report(sim.run(NAME, draws=3, overrides={"until_s": 60.0, "checks": []}), place)
    return place


def figures(folder, name):
    return json.loads((folder / "metrics.json").read_text())["trackers"][name]


def test_the_tracks_of_a_run_come_back_as_asterix(command, folder, tmp_path):
    """Half the last bit of CAT062 is .25 m: so far an error of each estimate may move, and no farther its RMSE."""
    assert command("export", folder, "--asterix").returncode == 0
    file = folder / "tracks.constant_velocity.ast"
    done = command("judge", folder, "--tracks", file, "--name", "back", "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    own, back = (figures(tmp_path / "out", name) for name in ("constant_velocity", "back"))
    assert own == figures(folder, "constant_velocity")
    for channel in ("position_m", "cross_track_m"):
        assert back["overall"][channel]["rmse"] == pytest.approx(own["overall"][channel]["rmse"], abs=0.25 * 2**0.5)
        assert back["overall"][channel]["raw"] == own["overall"][channel]["raw"]
    assert back["track"]["completeness"] == 1.0
    assert "back" in (tmp_path / "out" / "report.html").read_text()


def test_what_cannot_be_judged_is_one_sentence(command, folder, tmp_path):
    file = tmp_path / "mine.csv"
    file.write_text("time_s,north_m,east_m\n4,0,3000\n")
    (tmp_path / "empty").mkdir()
    cut = tmp_path / "cut.ast"
    cut.write_bytes(bytes([62, 0, 40, 1]))
    for arguments, said in (
        ((folder, "--tracks", tmp_path / "none.csv"), "cannot be read: No such file"),
        ((folder, "--tracks", file, "--name", "constant_velocity"), "the run has a tracker of that name"),
        ((folder, "--tracks", file, "--sensors", "rader"), "no sensor 'rader'; did you mean 'radar'?"),
        ((tmp_path / "empty", "--tracks", file), "not a run folder"),
        ((folder, "--tracks", cut), "cut off|ends within|octets"),
    ):
        done = command("judge", *arguments, "-o", tmp_path / "out")
        assert done.returncode == 2, arguments
        assert len(done.stderr.splitlines()) == 1
        assert any(one in done.stderr for one in said.split("|")), done.stderr
        assert not (tmp_path / "out").exists()
