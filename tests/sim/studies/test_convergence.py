"""The rate of the equations of motion: the lowest at which nothing that is read differs, and who follows it."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import pytest

from aircraft.airframe import load
from aircraft.data import RATES, data
from aircraft.errors import ModelError
from aircraft.model_files import OWN_MODELS
from sim.cli.fleet import straight_in
from sim.experiment import read
from sim.flight.preparation import prepare
from sim.studies import convergence
from sim.studies.convergence import AIRS, FINEST, LIMITS, SHARE, converged_rate, figures

APPROACH = straight_in("an26", 72.0, 58.0)


@pytest.fixture
def unflown(monkeypatch):
    """Nothing is prepared: the figures are made up."""
    monkeypatch.setattr(convergence, "prepare", lambda scenario: SimpleNamespace(scenario=scenario))


@pytest.mark.parametrize(
    ("errors", "chosen"),
    [({60.0: 0.9, 120.0: 0.4}, 60.0), ({60.0: 1.1, 120.0: 0.9}, 120.0), ({60.0: 5.0, 120.0: 1.1}, 120.0)],
)
def test_the_lowest_rate_within_a_share_of_every_limit_is_chosen(unflown, monkeypatch, errors, chosen):
    """One figure in one air is off, by so many times what is tolerated."""

    def made_up(prepared, rate):
        off = errors.get(rate, 0.0) if prepared.scenario.seed == 3 else 0.0
        return {name: 1.0 + (off * SHARE * LIMITS[name] if name == "overshoot_m" else 0.0) for name in LIMITS}

    monkeypatch.setattr(convergence, "figures", made_up)
    rate, found = converged_rate(APPROACH)
    assert rate == chosen
    assert [one.rate for one in found] == sorted(RATES)[:-1]
    assert {(one.figure, one.air) for one in found} == {("overshoot_m", "turbulence_3")}
    assert [one.difference for one in found] == pytest.approx([errors[one.rate] * SHARE for one in found])


def test_a_rate_at_which_the_aircraft_does_not_touch_down_is_not_good(unflown, monkeypatch):
    def made_up(prepared, rate):
        return {name: 1.0 for name in LIMITS if rate > 60.0 or not name.startswith("touchdown")}

    monkeypatch.setattr(convergence, "figures", made_up)
    rate, found = converged_rate(APPROACH)
    assert rate == 120.0
    assert found[0].difference == math.inf


def test_the_rate_of_the_an26_lands_it_in_a_gust_as_the_finest_does():
    late = {"start.distance_m": 5000.0}  # on the glide path
    prepared = prepare(read({**APPROACH, **AIRS["gust"]}, late))
    at_rate, finest = (figures(prepared, rate) for rate in (data("an26").rate, FINEST))
    assert "touchdown.sink_mps" in finest
    assert at_rate != finest  # it was another rate
    assert all(abs(at_rate[name] - finest[name]) <= SHARE * LIMITS[name] for name in finest)


def test_airframe_turbulence_and_route_loop_follow_the_rate_of_the_aircraft():
    prepared = prepare(read(APPROACH, {"wind.turbulence": "light"}))
    assert prepared.rate == load("an26").rate == data("an26").rate
    for rate in RATES:
        airframe = dataclasses.replace(prepared, rate=rate).airframe.load()
        assert airframe.rate == rate
        assert airframe._executive["simulation/dt"] == pytest.approx(1.0 / rate)
        assert dataclasses.replace(prepared, rate=rate).wind(0)._rate == rate


def test_a_rate_that_is_no_whole_number_of_steps_is_a_sentence(tmp_path):
    home = tmp_path / "mine"
    home.mkdir()
    (home / "mine.xml").write_bytes((OWN_MODELS / "an26" / "an26.xml").read_bytes())
    (home / "mine.toml").write_text('title = "Mine"\nrate_hz = 100')
    with pytest.raises(ModelError, match=r"'Mine' need a rate of 60, 120 or 240 Hz, not 100"):
        data(home)
