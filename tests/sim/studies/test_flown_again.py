"""Every row of a study names the command that flies its flight again, to the last bit, wherever the folder lies."""

from __future__ import annotations

import json
import shlex

import pytest

from sim.cli.run_summary import study_summary
from sim.reporting.text.broken_checks import run_again
from sim.studies import study as studies
from tests.capture import CAPTURE
from tests.sim.studies.test_study import Inline

FOLDER = "an operator's study, {flight}"
TABLES = {
    **CAPTURE, "name": "rows", "until_s": 4.0, "start": {"leg": 0, "cross_track_m": 60.0},
    "checks": [{"metric": "bank_max_deg", "max": 1.0}],
    "study": {"samples": 2, "axes": {
        "wind.turbulence": ["light", "moderate"], "autopilot.roll_rate_limit_degps": [3, 4.5],
        "wind.headwind_kt": {"normal": [7.5, 7.5, -10, 30]}, "autopilot.bank_limit_deg": {"uniform": [6, 12]},
    }},
}  # fmt: skip


@pytest.fixture
def again(command, tmp_path):
    """The metrics of a run as a user types it."""

    def call(typed, **instead):
        words = [instead.get(word.removesuffix(".toml"), word) for word in shlex.split(typed)]
        assert words[0] == "shortfinal"
        command(*words[1:], "-o", "again")
        return json.loads((tmp_path / "again/metrics.json").read_text())["flight"]

    return call


def test_log_rows_page_and_terminal_name_commands_that_fly_the_same_flight(again, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / FOLDER
    metrics = studies.study(TABLES, folder, Inline())
    records = [json.loads(line) for line in (folder / "flights.jsonl").read_text().splitlines()]
    commands = [record["again"] for record in records]
    assert len(set(commands)) == 8
    assert {row["worst"]["again"] for row in metrics["rows"]} <= set(commands)
    page = (folder / "report.html").read_text()
    assert page.count("<code>shortfinal run scenario.toml") == 8
    record = records[5]
    assert again(record["again"], scenario=folder / "scenario.toml") == {**record["metrics"], "navigated": None}
    said = study_summary(metrics, run_again(f"{FOLDER}/scenario.toml")).splitlines()[-1]
    most = max(record["metrics"]["bank_max_deg"] for record in records)
    assert again(said[said.index("shortfinal run") :])["bank_max_deg"] == most


def test_where_nothing_is_broken_the_flight_nearest_to_a_limit_is_named(tmp_path):
    checks = [{"metric": "bank_max_deg", "max": 60.0}, {"metric": "landed", "max": 1}, {"metric": "landed", "min": 0}]
    metrics = studies.study({**TABLES, "checks": checks}, tmp_path / "o", Inline())
    records = [json.loads(line) for line in (tmp_path / "o/flights.jsonl").read_text().splitlines()]
    worst = max(records, key=lambda record: record["metrics"]["bank_max_deg"])
    assert metrics["worst"] == {"flight": worst["flight"], "values": worst["values"]}
    said = study_summary(metrics, run_again("scenario.toml")).splitlines()[-1]
    assert said == f"nearest to a limit: flight {worst['flight']}: {worst['again']}"
