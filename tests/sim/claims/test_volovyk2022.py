"""The rows of Volovyk 2022: flights side by side, shares over scans, norms, costs and the search of the rivals."""

from __future__ import annotations

import numpy as np
import pytest

from sim.claims.papers.volovyk2022 import cost, experiment, norms, tuning
from sim.claims.papers.volovyk2022.experiment import Experiment, gain_over, mean_over_scans
from sim.claims.papers.volovyk2022.filters import DETECTOR, FILTERS, ONE_FILTER, TUNED
from sim.claims.papers.volovyk2022.landing_paths import Path, together
from sim.flight.truths.landing_pattern import FINAL, GLIDE, GROUND
from tracking.gaussian import Gaussian
from tracking.track import Measurements


def path(scans: int, last: int) -> Path:
    place = np.arange(2.0 * scans).reshape(scans, 2, 1)
    return Path(0.7 * np.arange(scans), place, np.full((scans, 1), last), np.arange(4.0))


def test_who_has_landed_stands_still_and_is_on_no_leg():
    """Also where the last scan of a flight is still on the glide path."""
    both = together([path(3, GLIDE), path(5, GLIDE)], 2)
    assert both.phase.T.tolist() == [[GLIDE] * 3 + [GROUND] * 2] * 2 + [[GLIDE] * 5] * 2
    assert (both.place[2:, :, :2] == both.place[2, :, :2]).all()
    assert (both.place[:, :, 2] == path(5, GLIDE).place[:, :, 0]).all()
    assert both.start.shape == (4, 4)


def test_a_share_of_scans_is_in_no_doubt_because_runs_are_long_or_short():
    among = np.array([[True, True, True], [True, False, True], [True, False, False]])
    assert mean_over_scans(np.ones((3, 3)), among)[:3] == (1.0, 1.0, 1.0)
    values = np.array([[1.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 1.0]])
    assert mean_over_scans(values, among).value == pytest.approx(values[among].mean())


def test_the_interval_of_a_share_holds_as_often_as_it_says():
    """Forty runs of 5 to 40 scans, each with a share of its own: 95 % of 300 rows within three deviations."""
    generator = np.random.default_rng(5)
    held = []
    for _ in range(300):
        among = np.arange(40)[:, None] < generator.integers(5, 41, 40)
        values = generator.random((40, 40)) < generator.beta(4.0, 2.0, 40)
        held.append(mean_over_scans(values, among).contains(2.0 / 3.0))
    assert 0.91 <= np.mean(held) <= 0.985


@pytest.fixture
def scans(monkeypatch):
    """Five scans of two runs, at 2 km, 100 m beside the centreline, and at 1 km on it; made errors (m)."""
    distance = np.repeat([[2000.0, 1000.0]], 5, axis=0)
    errors = np.array([5.0, 15.0, 25.0, 34.0, 70.0])[:, None] / distance
    truth = np.stack([distance, np.repeat([[100.0, 0.0]], 5, axis=0)], axis=1)
    seen = Measurements(("radar.range",), np.arange(5.0), np.arange(5.0), np.ones((5, 1, 2)), np.ones((5, 1, 1)))
    data = Experiment(seen, truth, np.full((5, 2), FINAL), Gaussian(np.zeros(4), np.eye(4)), distance, distance)
    own = experiment.Squares({}, {"azimuth": errors**2}, np.zeros((5, 2)))
    for module in (norms, experiment):
        monkeypatch.setattr(module, "experiment", lambda *given: data)
        monkeypatch.setattr(module, "squares", lambda *given: own)


@pytest.mark.parametrize(
    ("norm", "share"),
    [
        (norms.annex_10, 30.0),  # 12 + 10 m and 9 m, more than 6 m: two and one of five
        (norms.one_degree, 60.0),  # 34.9 m and 17.5 m: four and two
        (norms.two_sigma, 80.0),  # 68.4 m and 34.2 m: four and four
    ],
)
def test_norms_by_hand(scans, norm, share):
    assert norms.within(norm, "any", 3000.0, 500.0)(1, 2).value == pytest.approx(share)


def test_costs_are_told_as_more_than_one_filter(monkeypatch):
    took = {
        name: iter(values) for name, values in ((ONE_FILTER, [9.0] + [0.02] * 20), (cost.DENSITY, [9.0] + [0.05] * 20))
    }
    monkeypatch.setattr(cost, "seconds", lambda name, data, runs: next(took[name]))
    monkeypatch.setattr(cost, "experiment", lambda seed, runs: None)
    assert cost.more_time(1)(1, 1).value == pytest.approx(150.0)
    assert cost.more_time(2, of_the_scan=True)(1, 1).value == pytest.approx(100.0 * 0.03 / 1.4)
    assert cost.more_operations() == pytest.approx(100.0 * ((1536 + 1308) / (328 + 276) - 1.0))


def test_a_gain_is_the_rmse_of_the_rival_over_that_of_the_models(scans, monkeypatch):
    square = {"rival": np.full((5, 2), 36.0), "models": np.full((5, 2), 9.0)}
    monkeypatch.setattr(experiment, "squares", lambda name, *of: experiment.Squares({}, {"position": square[name]}, 0))
    assert gain_over("rival", "models", "all")(1, 2)[:3] == (2.0, 2.0, 2.0)


def test_the_search_goes_downhill_on_its_grid_and_stays_there(monkeypatch):
    aim = {"quiet_density": 0.1, "manoeuvre_density": 100.0, "window": 5, "false_alarm_rate": 0.03}

    def bowl(name, parameters):
        return 1.0 + sum(
            (tuning.GRID[key].index(value) - tuning.GRID[key].index(aim[key])) ** 2 for key, value in parameters
        )

    monkeypatch.setattr(tuning, "cost", bowl)
    assert tuning.tune(DETECTOR) == aim
    assert tuning.tune(DETECTOR, aim) == aim
    edge = {**aim, "quiet_density": 100.0, "window": 1}
    beside = tuning.neighbours(edge)
    assert len(beside) == 5  # of eight, one below the grid, one with more noise on the straight, one ...
    assert all(one["quiet_density"] <= one["manoeuvre_density"] for one in beside)


@pytest.mark.parametrize("name", TUNED)
def test_tuned_parameters_lie_inside_their_grids(name):
    for key, value in TUNED[name].items():
        assert value in tuning.GRID[key][1:-1]
    assert name in FILTERS
