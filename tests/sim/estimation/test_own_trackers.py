"""Trackers that the caller brings: what they listen to, what they are given, in a run, a study and the fixture."""

from __future__ import annotations

import sys
import types

import pytest

import sim
from sim.errors import ScenarioError
from sim.estimation.own_trackers import packed, set_up, unpacked
from sim.flight.preparation import prepare
from sim.studies.study import resume
from sim.workers.executors import LocalExecutor
from tests.capture import capture_tables
from tests.sim.estimation.own import Mine

TABLES = {
    **capture_tables(name="own", until_s=12.0, draws=2),
    "aircraft": {"model": "point_mass"},
    "sensors": {
        "far": {"kind": "surveillance_radar", "period_s": 4.0, "position_m": [-3000, 2000, 10]},
        "near": {"kind": "surveillance_radar", "period_s": 1.0, "position_m": [-3000, 2000, 10]},
    },
}


def test_it_listens_to_the_sensors_that_it_names_and_else_to_all():
    result = sim.run(TABLES, trackers={"one": sim.tracker(Mine, sensors=["far"]), "all": Mine()})
    assert {*result.tracks["one"].measurements.channels} == {"far.range", "far.azimuth"}
    assert len(result.tracks["all"].measurements.channels) == 4
    assert [*result.tracks["one"].track.time] == [4.0, 8.0]


def test_it_is_given_the_law_that_flies_or_a_changed_one_and_the_route():
    prepared = prepare(sim.read(TABLES))
    plain = set_up(prepared, "mine", sim.tracker(Mine))
    assert (plain.tracker, plain.law_from) == (Mine(), None)
    told = set_up(prepared, "mine", sim.tracker(Mine, law="autopilot", route=True, drift=2.0))
    assert told.tracker.law == prepared.law
    assert told.law_from == "autopilot"
    assert told.tracker.route.legs == prepared.route.legs
    assert told.tracker.drift == 2.0
    wrong = set_up(prepared, "mine", sim.tracker(Mine(drift=2.0), law={"cross_track_limit_factor": 0.5}))
    assert wrong.tracker.law.cross_track_limit == 0.5 * prepared.law.cross_track_limit
    assert wrong.tracker.drift == 2.0
    assert wrong.law_from not in (None, "autopilot")


@pytest.mark.parametrize(
    ("mine", "said"),
    [
        (lambda: sim.tracker(Mine, sensors=["fur"]), "tracker 'mine' sensors: 'fur' is no sensor of the scenario; did"),
        (lambda: sim.tracker(Mine, sensors="far"), "sensors are a list of names, such as ['far'], not one word"),
        (lambda: sim.tracker(Mine, sensors=[]), "sensors: must name one at least"),
        (lambda: sim.tracker(Mine, law="pilot"), "law must be 'autopilot' or a dict of changes to it, not 'pilot'"),
        (lambda: sim.tracker(Mine, law={"k9_factor": 2.0}), "tracker 'mine' law: k9_factor: no such key; allowed: "),
        (lambda: sim.tracker(Mine, drifts=1.0), "tracker 'mine': making it with drifts raises TypeError"),
        (lambda: sim.tracker(object), "tracker 'mine': has no 'channels'"),
        (lambda: sim.tracker(object(), route=True), "is made already and no dataclass, so it cannot be given route"),
    ],
)
def test_one_that_cannot_be_set_up_is_answered_before_anything_flies(mine, said, monkeypatch):
    monkeypatch.setattr("sim.experiment.fly", lambda *given: pytest.fail("it flew"))
    with pytest.raises(sim.ScenarioError) as caught:
        sim.run(TABLES, trackers={"mine": mine()})
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_study_has_it_on_every_flight_and_knows_it_from_another(tmp_path):
    study = {**TABLES, "study": {"axes": {"start.cross_track_m": [100, 200]}}}
    checks = [{"metric": "trackers.mine.overall.position_m.rmse", "max": 0.001, "source": "test"}]
    mine = {"mine": sim.tracker(Mine, sensors=["near"], drift=3.0)}
    result = sim.study({**study, "checks": checks}, f"{tmp_path}/s", trackers=mine)
    rows = result.metrics["rows"]
    assert len(rows) == 2
    assert len(result.broken) == 1
    assert "trackers.mine.overall.position_m.rmse" in result.broken[0]
    assert len(repr(result).splitlines()) <= 4
    again = sim.study({**study, "checks": checks}, tmp_path / "s", trackers=mine)  # nothing is left to fly
    assert again.metrics == result.metrics
    with pytest.raises(sim.OutputError, match=r"own\.mine"):
        sim.study({**study, "checks": checks}, tmp_path / "s", trackers={"mine": sim.tracker(Mine, sensors=["far"])})
    with pytest.raises(sim.OutputError, match="was begun from Python with a tracker 'mine'"):
        resume(tmp_path / "s", LocalExecutor(1))


def test_a_study_without_a_folder_leaves_none():
    result = sim.study({**TABLES, "sensors": {}, "study": {"axes": {"start.cross_track_m": [100]}}})
    assert result.folder is None
    assert result.metrics["flights"] == 1


def test_the_fixture_takes_it(shortfinal):
    mine = sim.tracker(Mine, sensors=["near"])
    result = shortfinal(TABLES, trackers={"mine": mine})
    assert {*result.tracks["mine"].measurements.channels} == {"near.range", "near.azimuth"}
    assert shortfinal(TABLES, trackers={"mine": mine}) is result
    assert shortfinal(TABLES) is not result


def test_explain_is_a_text():
    assert "radar" in sim.explain(TABLES, {"wind.speed_mps": 5, "wind.from_deg": 90})
    assert sim.explain(sim.read(TABLES)) == sim.explain(TABLES)


def test_a_worker_that_does_not_find_a_class_says_so(monkeypatch):
    typed = types.ModuleType("typed_at_a_prompt")
    typed.Mine = type("Mine", (), {"__module__": typed.__name__})
    with monkeypatch.context() as here:
        here.setitem(sys.modules, typed.__name__, typed)
        sent = packed({"mine": typed.Mine})
        assert unpacked(sent) == {"mine": typed.Mine}
    with pytest.raises(ScenarioError, match=r"does not find the trackers of the caller .* or take one worker"):
        unpacked(sent)
    with pytest.raises(ScenarioError, match="cannot be sent to a worker"):
        packed({"mine": lambda: None})
