"""What a terminal says of broken checks: name, value, limit, time or place, source."""

from __future__ import annotations

import numpy as np
import pytest

from sim.cli.run_summary import study_summary
from sim.metrics.checks import broken, broken_in_study, evaluate_checks
from sim.scenario.tables import Check, Runway, StudyCheck
from sim.studies.metrics import every_flight, share_check

TIME = np.arange(0.0, 20.0, 1 / 30)


@pytest.mark.parametrize(
    ("check", "said"),
    [
        (
            Check("bank_deg", max=15.0, source="the manual"),
            "bank_deg: bank_deg = 18 deg at 10.0 s, limit 15 deg, beyond it by 3 deg; source: the manual",
        ),
        (
            Check("bank_deg", name="roll", max=15.0, for_=1.0),
            "roll: bank_deg = 18 deg for 1 s at 10.0 s, limit 15 deg, beyond it by 3 deg; source: not given",
        ),
        (
            Check("airspeed_error_mps", min=2.0, statistic="rms"),
            "airspeed_error_mps: airspeed_error_mps (rms) = 0 m/s at 0.0 s, limit 2 m/s, beyond it by 2 m/s; "
            "source: not given",
        ),
        (
            Check("touchdown.sink_mps", max=3.0, source="gear"),
            "touchdown.sink_mps: the flight has no touchdown.sink_mps, limit 3 m/s; source: gear",
        ),
    ],
)
def test_a_broken_check_names_value_limit_time_and_source(make_flight, check, said):
    bank = np.radians(np.where((TIME >= 9.99) & (TIME < 12), 18.0, 0.0))
    flight = make_flight(TIME, ["final"] * len(TIME), bank=bank)
    (result,) = evaluate_checks((check,), flight, Runway(), {"touchdown": None})
    assert broken(result) == said


def record(speed, sink, flight=0):
    check = {"value": sink, "margin": 3.0 - sink, "time_s": 5.0, "passed": sink <= 3.0}
    metrics = {"outcome": "landed", "sink_mps": sink}
    return {"values": {"wind.speed_mps": speed}, "flight": flight, "metrics": metrics, "checks": [check]}


def test_a_study_names_the_worst_flight():
    records = [record(0.0, 1.0), record(8.0, 4.5, flight=3), record(12.0, 3.5)]
    said = broken_in_study(every_flight(Check("sink_mps", max=3.0, source="gear"), 0, records))
    assert said == (
        "sink_mps: 1 of 3 flights keep sink_mps, limit 3 m/s; "
        "the worst has 4.5 m/s with wind.speed_mps = 8, flight = 3; source: gear"
    )


def test_a_share_says_what_is_shown():
    records = [record(0.0, 1.0 + 0.05 * i) for i in range(59)]
    check = share_check(StudyCheck("sink_mps", max=3.0, source="gear"), records)
    said = (
        "sink_mps: 41 of 59 flights keep sink_mps, limit 3 m/s; "
        "95 % with 95 % confidence are shown to keep 3.9 m/s; source: gear"
    )
    assert broken_in_study(check) == said  # of 59 flights the largest: 1 + 58 / 20
    metrics = {"scenario": "s", "flights": 59, "rows": [{}], "outcomes": {"landed": 59}, "checks": [check]}
    assert study_summary(metrics).splitlines()[-1] == said
    none = share_check(StudyCheck("landed", min=1.0), records)
    assert "are shown to keep no limit; source: not given" in broken_in_study(none)
