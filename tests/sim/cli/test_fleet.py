"""The fleet: whatever a model does to its process, the user's goes on; what flew is in the table and is listed."""

import os
import tomllib
from pathlib import Path

import pytest

from aircraft.model_files import available
from aircraft.slowest import complete
from aircraft.stock import STOCK_TABLE
from sim.cli import fleet
from sim.cli.listing import aircraft_lines
from sim.workers import executors
from tests.hostile.foreign import FOREIGN


def dying(model):
    """What a model that aborts JSBSim does, one that raises, and a good one."""
    if model == "aborts":
        os.abort()
    if model == "raises":
        raise RuntimeError("nothing prepared for this")
    return {"route_capture": {"outcome": "completed"}}


def test_an_aircraft_that_kills_its_process_is_answered_and_the_others_fly(monkeypatch):
    monkeypatch.setattr(executors, "ATTEMPTS", 1)
    found = dict(fleet.answers(dying, ["aborts", "good", "raises"]))
    assert "died" in found["aborts"]["reason"]
    assert "nothing prepared" in found["raises"]["reason"]
    assert found["good"] == {"route_capture": {"outcome": "completed"}}


@pytest.mark.parametrize("model", [pytest.param("T37", marks=pytest.mark.soak), "A320"])
def test_a_stock_aircraft_captures_and_lands_with_nothing_set_by_hand(model):
    told = fleet.flown(model)
    capture, landing = told["route_capture"], told["straight_in"]
    assert capture["outcome"] == "completed"
    assert capture["overshoot_m"] <= 3.0  # asked of transports
    assert capture["bank_max_deg"] <= 17.0  # the limit of 15 deg and 2 deg
    assert landing["outcome"] == "landed"
    if model == "A320":  # the short period of the T37 is about critically damped: no oscillation
        assert set(told["modes"]) == {"phugoid", "short_period", "dutch_roll", "roll", "spiral"}


def test_what_cannot_fly_says_why_in_one_sentence():
    for model in ("ball", "J246", "blank"):
        reason = fleet.described(model)["reason"]
        assert reason
        assert "\n" not in reason


def test_a_folder_of_others_is_searched_and_each_aircraft_answered(tmp_path):
    for name in ("usual root", "folder without a file of its name", "no engines anywhere", "read, and broken besides"):
        FOREIGN[name].write(tmp_path / "fleet")
    FOREIGN["name of our own aircraft"].write(tmp_path / "elsewhere" / "deep")
    (tmp_path / "fleet" / "link").symlink_to("../elsewhere")
    found = fleet.found_in(tmp_path / "fleet")
    assert [Path(path).relative_to(tmp_path).as_posix() for path in found] == [
        "fleet/plane/a.xml",
        "fleet/plane/b.xml",
        "fleet/plane/plane.xml",
        "fleet/root/aircraft/plane/plane.xml",
    ]
    told = dict(fleet.of_others([found[2]]))
    assert "cannot load 'plane'" in told[found[2]]["reason"]


def test_every_stock_aircraft_is_answered_in_the_table():
    table = tomllib.loads(fleet.TABLE.read_text())["aircraft"]
    stock = {name for name, origin in available().items() if origin.startswith("stock")}
    assert set(table) >= stock
    for name, row in table.items():
        assert "reason" in row or {"route_capture", "straight_in"} <= set(row), name


def test_the_table_of_flap_settings_is_what_the_models_say():
    rows = tomllib.loads(STOCK_TABLE.read_text())
    tabled = [row["slowest_mps"] for row in rows["T37"]["flap_settings"]]
    known = fleet.described("T37")["flap_settings"]
    assert [row["slowest_mps"] for row in known] == pytest.approx(tabled, rel=1e-3)  # rounded to 1 cm/s
    assert [s.stall_speed for s in complete("T37").flap_settings] == tabled


def test_the_list_shows_speeds_modes_results_and_reasons():
    text = "\n".join(aircraft_lines())
    assert "measured under JSBSim" in text
    for line in aircraft_lines():
        if line.startswith("B747 "):
            assert line.endswith("landed")
            break
    else:
        raise AssertionError("the B747 is not listed")
    assert "ball" in text
    assert "C130" in text
    assert "repaired: its turbines act directly" in text
