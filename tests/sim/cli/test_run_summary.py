"""What a terminal says of broken checks: name, value, limit, time or place, source."""

from __future__ import annotations

import numpy as np
import pytest

from sim.cli.run_summary import study_summary, summary
from sim.metrics.ensemble.verdict import verdicts
from sim.reporting.text.broken_checks import broken, run_again
from sim.scenario.tables import Check, Runway
from tests.sim.one_flight import judged

AGAIN = "; flight 0, seed 4: shortfinal run 'a b.toml' --plugin mine.py --flight 0"
TIME = np.arange(0.0, 20.0, 1 / 30)


@pytest.mark.parametrize(
    ("check", "said"),
    [
        (
            Check("bank_deg", max=15.0, source="the manual"),
            f"bank_deg: bank_deg = 18 deg at 10.0 s, limit 15 deg, beyond it by 3 deg; source: the manual{AGAIN}",
        ),
        (
            Check("bank_deg", name="roll", max=15.0, for_=1.0),
            f"roll: bank_deg = 18 deg for 1 s at 10.0 s, limit 15 deg, beyond it by 3 deg; source: not given{AGAIN}",
        ),
        (
            Check("airspeed_error_mps", min=2.0, statistic="rms"),
            "airspeed_error_mps: airspeed_error_mps (rms) = 0 m/s at 0.0 s, limit 2 m/s, beyond it by 2 m/s; "
            f"source: not given{AGAIN}",
        ),
        (
            Check("touchdown.sink_mps", max=3.0, source="gear"),
            f"touchdown.sink_mps: the flight has no touchdown.sink_mps, limit 3 m/s; source: gear{AGAIN}",
        ),
    ],
)
def test_a_broken_check_names_value_limit_time_and_source(make_flight, check, said):
    bank = np.radians(np.where((TIME >= 9.99) & (TIME < 12), 18.0, 0.0))
    flight = make_flight(TIME, ["final"] * len(TIME), bank=bank)
    (result,) = judged((check,), flight, Runway(), {"touchdown": {"sink_mps": None}})
    assert broken(result, {"seed": 4}, run_again("a b.toml", ["mine.py"])) == said


def record(speed, sink, flight=0, cell=0):
    check = {"value": sink, "limit": 3.0, "margin": 3.0 - sink, "time_s": 5.0, "passed": sink <= 3.0}
    metrics = {"outcome": "landed", "sink_mps": sink}
    values = {"wind.speed_mps": speed, "aircraft.mass_kg": 2e4}
    return {"cell": cell, "values": values, "flight": flight, "metrics": metrics, "checks": [check]}


STUDY = {"seed": 7, "axes": {"wind.speed_mps": {"values": [0.0]}, "aircraft.mass_kg": {"uniform": [1e4, 3e4]}}}


def test_a_study_names_the_worst_flight_and_the_command_that_flies_it():
    records = [record(0.0, 1.0), record(8.0, 4.5, flight=3), record(12.0, 3.5)]
    (check,) = verdicts((Check("sink_mps", max=3.0, source="gear"),), records)
    assert broken(check, STUDY, run_again("o/scenario.toml")) == (
        "sink_mps: 1 of 3 flights keep it; sink_mps = 4.5 m/s at 5.0 s, limit 3 m/s, beyond it by 1.5 m/s; "
        "source: gear; flight 3, seed 7, wind.speed_mps = 8, aircraft.mass_kg = 2e+04: "
        "shortfinal run o/scenario.toml --set wind.speed_mps=8.0 --flight 3"
    )


def test_a_share_says_what_is_shown():
    """59 flights of which none may fail: the worst decides."""
    records = [record(0.0, 1.0 + 0.05 * i, flight=i) for i in range(59)]
    (check,) = verdicts((Check("sink_mps", max=3.0, share=0.95, confidence=0.95, source="gear"),), records)
    said = broken(check, STUDY, run_again("f"))
    assert said.startswith(
        "sink_mps: 41 of 59 flights keep it, which shows 58.2 % with 95 % confidence where 95 % are asked; "
        "sink_mps = 3.9 m/s at 5.0 s"  # the largest: 1 + 58 / 20
    )
    metrics = {
        **STUDY,
        "worst": {"flight": 0, "values": {}},
        "scenario": "s",
        "flights": 59,
        "rows": [{}],
        "outcomes": {"landed": 59},
        "checks": [check],
    }
    assert study_summary(metrics, run_again("f")).splitlines()[-1] == said


def test_a_flight_that_crashed_breaks_every_check():
    crashed = {"flight": 1, "metrics": {"outcome": "crashed", "reason": "why"}, "checks": []}
    (check,) = verdicts((Check("sink_mps", max=3.0),), [record(0.0, 1.0), crashed])
    said = broken(check, STUDY, run_again("f"))
    assert said.startswith(
        "sink_mps: 1 of 2 flights keep it; the flight crashed, limit 3 m/s; source: not given; flight 1"
    )


def test_contrasts_of_a_run_are_a_table_with_their_intervals():
    def figure(ratio):
        return {"ratio": ratio, "low": None, "high": 9.0, "n": 4, "of": 1.0, "against": 3.0}

    tables = {"overall": {"position_m": figure(2.5), "height_m": figure(7.0)}, "by_phase": {}}
    tables["look_ahead"] = {"60_s": {"position_m": figure(8.0), "height_m": figure(7.0)}, "120_s": {}}
    flight = {"reason": "stopped", "duration_s": 1.0}
    metrics = {"scenario": "s", "seed": 1, "flights": 1, "flight": flight, "trackers": {}, "checks": [], "warnings": []}
    entry = {"of": "a", "against": "b", "name": "as published", **tables}
    before = str(entry)
    told = summary({**metrics, "contrasts": [entry, {**entry, "name": None, "overall": {}, "look_ahead": {}}]}, "again")
    assert told.splitlines()[2:] == [
        "RMSE of          over that of                          ratio  from  to",
        "a, as published  b             position_m                2.5     -   9",
        "a, as published  b             position_m, 60 s ahead      8     -   9",
    ]
    assert str(entry) == before
