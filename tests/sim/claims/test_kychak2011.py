"""The ledger's rows on Kychak 2011: filters by accuracy and operations, drawn glide paths."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

from sim import claims
from sim.claims.angle_channel import MEASURED, PRIOR, SIGMA, drawn
from sim.claims.ledger import measure
from sim.claims.papers.kychak2011.cheaper import (
    BURSTS,
    CHAINS,
    FACTOR,
    FILTERS,
    FREEDOM,
    GATE,
    HUBER,
    INDEPENDENT,
    SCALE,
    THREE,
    TURNS,
    Cheap,
    Step,
    gained,
    operations,
    settled,
    three_levels,
)
from sim.claims.papers.kychak2011.experiment import PRINTED_CHAIN, glides
from tracking.gaussian import Mixture, merge
from tracking.intervals import chi_square
from tracking.measurement import LinearMeasurement
from tracking.motion import Transition
from tracking.operations import Number, Tally
from tracking.track import follow
from tracking.trackers.elevation import PERIOD, Elevation, increments
from tracking.trackers.gated import Gated
from tracking.trackers.huber import Huber
from tracking.trackers.switching_noise import SwitchingNoise

STEPS, RUNS = 60, 5


@dataclass(frozen=True)
class AngleMotion:
    """The process of the paper for trackers that take any motion."""

    channels = ("elevation", "elevation_rate")
    depends_on_state = False

    def transition(self, dt, mean):
        return Transition(*increments(2, PERIOD, PERIOD, np.radians(0.01)))


ANGLE = LinearMeasurement(((1.0, 0.0),))
PASSES = next(p for p in np.linspace(0.997, 0.998, 100_001) if chi_square(p, 1) >= GATE**2)
TRACKERS = {
    "Kalman filter": Elevation(MEASURED),
    "gate at 3 deviations": Gated(ANGLE, AngleMotion(), PASSES),
    "Huber at 1.345 deviations": Huber(ANGLE, AngleMotion(), HUBER),
    "two hypotheses, closed form": SwitchingNoise(MEASURED),
    "two hypotheses, as printed": SwitchingNoise(MEASURED),
    "two hypotheses with the chain of the bursts": SwitchingNoise(MEASURED, switching=CHAINS[BURSTS]),
    "three hypotheses": SwitchingNoise(MEASURED, THREE, three_levels(PRINTED_CHAIN)),
    "three hypotheses with the chain of the bursts": SwitchingNoise(MEASURED, THREE, three_levels(CHAINS[BURSTS])),
}


@pytest.fixture(scope="module")
def stream_of_angles():
    return drawn(np.random.default_rng(5), RUNS, STEPS, PRIOR, PRINTED_CHAIN, (1.0, FACTOR))


def followed(filter_: Cheap, measurements):
    """Angle (steps, runs) in rad, and its variance."""
    mean, spread, ones = SCALE * PRIOR.mean, SCALE**2 * np.diag(PRIOR.cov), np.ones(RUNS)
    s = Step(mean[0] * ones, mean[1] * ones, spread[0] * ones, 0.0 * ones, spread[1] * ones,
             tuple(weight * ones for weight in filter_.weights))  # fmt: skip
    found = []
    for z in measurements.z[:, 0] / SIGMA:
        s = filter_.step(s, z)
        found.append((s.x * SIGMA, s.p * np.ones(RUNS) * SIGMA**2))
    return np.array(found)


@pytest.mark.parametrize("name", list(TRACKERS))
def test_plain_arithmetic_is_the_tracker(name, stream_of_angles):
    _, measurements = stream_of_angles
    found = followed(FILTERS[name], measurements)
    for epoch in follow(TRACKERS[name], measurements, PRIOR, start=0.0):
        estimate = merge(epoch.estimate) if isinstance(epoch.estimate, Mixture) else epoch.estimate
        assert found[epoch.row, 0] == pytest.approx(estimate.mean[0], rel=1e-9)
        # a gate at a probability with five digits is the gate at 3 deviations unless an innovation lies between
        assert found[epoch.row, 1] == pytest.approx(np.broadcast_to(estimate.cov[0, 0], RUNS), rel=1e-7)


def test_a_stored_gain_is_the_settled_filter_where_nothing_is_anomalous():
    truth, measurements = drawn(np.random.default_rng(6), RUNS, 400, PRIOR)
    angle_gain, _, limit = settled()
    assert 1.0 / (1.0 - angle_gain) == pytest.approx(limit / GATE**2)
    stored, full = (
        np.mean((followed(FILTERS[name], measurements)[100:, 0] - truth[100:]) ** 2)
        for name in ("stored gain with a gate", "Kalman filter")
    )
    # the gate holds back 0.27 % of good measurements, and the error of a missed one lasts for a dozen scans
    assert stored == pytest.approx(full, rel=0.1)


def test_students_scale_is_a_fixed_point_of_its_equations():
    s, z = Step(0.0, 0.0, 0.5, 0.0, 0.0), 8.0
    found = FILTERS["Student's t, 4 degrees of freedom"].step(s, z)
    p, scale = s.p, 1.0
    for _ in range(TURNS):
        k = p / (p + 1.0 / scale)
        mean, variance = k * z, (1.0 - k) * p
        scale = (FREEDOM + 1.0) / (FREEDOM + (z - mean) ** 2 + variance)
    assert found.x == pytest.approx(mean)
    assert found.p == pytest.approx(variance)


def test_an_anomaly_that_says_nothing_is_a_missed_measurement(stream_of_angles):
    """As the factor grows two hypotheses become the cheaper form; at 30 they are near."""
    _, measurements = stream_of_angles
    two, missed = (
        followed(FILTERS[name], measurements)[:, 0]
        for name in ("two hypotheses, closed form", "two hypotheses, an anomaly as a missed measurement")
    )
    assert 0.0 < np.abs(two - missed).max() < 0.2 * SIGMA


def test_operations_of_the_kalman_filter_are_those_counted_by_hand():
    """Five additions predict; innovation, its variance and its inverse; 4 and 5 for the state and the covariance."""
    assert operations("Kalman filter") == (1 + 1 + 7, 5 + 1 + 1 + 5)
    assert operations("stored gain with a gate") == (3, 5)


@pytest.mark.parametrize("name", list(FILTERS))
@pytest.mark.parametrize("z", [0.9, -40.0, 40.0])
def test_operations_do_not_depend_on_the_values(name, z):
    tally, filter_ = Tally(), FILTERS[name]
    number = partial(Number, tally=tally)
    numbers = [number(value) for value in (1.0, 0.1, 0.2, 0.05, 0.1)]
    filter_.step(Step(*numbers, tuple(number(weight) for weight in filter_.weights)), number(z))
    assert tally.total() == operations(name)


def test_a_stored_gain_suffices_for_independent_anomalies_and_only_the_chain_for_bursts():
    stored, chain = "stored gain with a gate", "two hypotheses with the chain of the bursts"
    assert gained(stored, INDEPENDENT)(1, 100).low > 50.0
    assert gained(stored, BURSTS)(1, 100).high < 4.0
    assert gained(chain, BURSTS)(1, 100).low > 4.0
    assert gained("Kalman filter", BURSTS)(1, 100).value == 1.0


def test_glide_paths_are_drawn_by_the_seed():
    angles = glides(1, 2)
    assert angles.shape[1] == 2
    assert np.degrees(np.abs(np.diff(angles, axis=1))).max() > 1e-4  # another wind is another approach
    assert np.degrees(angles) == pytest.approx(2.29, abs=0.1)  # and all of them hold the glide path


def test_what_hangs_on_a_ratio_that_is_not_printed_cannot_be_tested():
    listed = {claim.name: claim for claim in claims.claims_of("kychak2011")}
    row = measure("kychak2011", listed["weak_at_decision_height"], 1, quick=True)
    assert row.verdict == "not testable here"
    assert not row.measured
    assert "signal-to-noise" in row.claim.note
