"""Records that cannot be true: refused, or skipped and told; a track never turns NaN in silence."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import sim
from sim.metrics.ensemble.trackers import over_flights
from sim.reporting.text.warnings import skipped_looks
from tests.capture import CAPTURE
from tests.tracking.test_track import KALMAN, POSITION, PRIOR, record
from tracking.gaussian import Gaussian
from tracking.measurement import Stacked
from tracking.reference_path import MOST_SUB_STEPS, sub_steps
from tracking.track import FARTHEST, Measurements, follow, track
from tracking.trackers.huber import Huber
from tracking.trackers.imm import InteractingMultipleModel
from tracking.trackers.imm_published import PublishedModels
from tracking.trackers.kalman import Kalman

TRACKERS = {
    "kalman": Kalman,
    "huber": Huber,
    "imm": InteractingMultipleModel,
    "imm_published": PublishedModels,
}
TWICE = Stacked((POSITION, POSITION))


def of_two_sensors(measurements):
    """The same plots from two sensors of one accuracy at one instant."""
    z = np.concatenate([measurements.z, measurements.z], axis=1)
    R = np.zeros((len(z), 4, 4, 1))
    R[:, :2, :2] = R[:, 2:, 2:] = measurements.R
    return Measurements(("a.north", "a.east", "b.north", "b.east"), measurements.time, measurements.arrival, z, R)


def believable(found):
    """Whether every estimate is one: finite, and its covariance nowhere negative beyond rounding."""
    cov = np.moveaxis(found.cov, (1, 2), (-2, -1))
    finite = np.isfinite(found.mean).all() and np.isfinite(cov).all()
    return finite and np.linalg.eigvalsh(cov).min() > -1e-9 * np.abs(PRIOR.cov).max()


NO_COVARIANCE = [
    (np.full((2, 2), np.nan), "R of 'radar.north' is not finite at 5 s"),
    (np.full((2, 2), np.inf), "R of 'radar.north' is not finite at 5 s"),
    (np.array([[1.0, 0.2], [0.1, 1.0]]), "not symmetric"),
    (np.array([[1.0, 0.0], [0.0, -1.0]]), "the variance of 'radar.east' is negative"),
    (np.array([[0.0, 0.5], [0.5, 1.0]]), "a correlation exceeds 1"),
]


@pytest.mark.parametrize(("wrong", "sentence"), NO_COVARIANCE, ids=[sentence for _, sentence in NO_COVARIANCE])
def test_an_r_that_is_no_covariance_is_refused_also_when_it_is_written_later(wrong, sentence):
    R = np.array(record().R)
    R[5] = wrong[..., None]
    with pytest.raises(ValueError, match=sentence):
        dataclasses.replace(record(), R=R)
    measurements = dataclasses.replace(record(), R=np.array(record().R))
    measurements.R[5] = wrong[..., None]
    with pytest.raises(ValueError, match=sentence):
        track(KALMAN, measurements, PRIOR)


def test_a_negative_direction_that_no_pair_of_channels_shows_is_refused():
    """Three correlations of -0.6 are each possible, together they are not: the sum has a negative variance."""
    R = np.full((3, 3), -0.6) + 1.6 * np.eye(3)
    z = np.zeros((2, 3, 1))
    with pytest.raises(ValueError, match="negative in some direction"):
        Measurements(("a", "b", "c"), np.arange(2.0), np.arange(2.0), z, np.stack([np.eye(3), R]))


def test_what_r_says_of_an_absent_channel_is_nothing():
    whole = record()
    z, R = np.array(whole.z), np.array(whole.R)
    z[5, 1] = np.nan
    R[5, 1] = R[5, :, 1] = np.nan
    blind = dataclasses.replace(whole, z=z)
    np.testing.assert_array_equal(
        track(KALMAN, dataclasses.replace(blind, R=R), PRIOR).mean, track(KALMAN, blind, PRIOR).mean
    )


@pytest.mark.parametrize("kind", TRACKERS)
def test_a_plot_farther_than_the_earth_is_skipped_and_told(kind):
    """It changes nothing but that: the track is the one without the plot."""
    tracker = TRACKERS[kind](POSITION)
    far, without = record(k=20), record(k=20)
    far.z[5, :, 0] = 1e11
    without.z[5, :, 0] = np.nan
    found = track(tracker, far, PRIOR)
    np.testing.assert_array_equal(found.mean, track(tracker, without, PRIOR).mean)
    assert np.argwhere(found.skipped).tolist() == [[5, 0]]
    assert believable(found)
    assert track(tracker, without, PRIOR).skipped is None


def test_the_farthest_plot_that_is_used_leaves_an_imm_its_covariance():
    """Why `FARTHEST` is what it is: the squares of its deviations keep digits beside a variance of 1 m2."""
    far = record(k=20, runs=1)
    far.z[5] = 0.99 * FARTHEST
    exact = dataclasses.replace(far, R=np.array(far.R) * 1e-4)
    for measurements in (far, exact):
        found = track(PublishedModels(POSITION), measurements, PRIOR)
        assert found.skipped is None
        assert np.linalg.eigvalsh(found.cov[..., 0]).min() > 0.0


@pytest.mark.parametrize("kind", TRACKERS)
def test_two_exact_plots_of_one_instant_are_one(kind):
    """The second says nothing, and cannot be weighed: the run goes on by its prediction, which has the first."""
    tracker = TRACKERS[kind](POSITION)
    once = record(runs=2)
    R = np.array(once.R)
    R[5] = 0.0
    rows = np.sort(np.append(np.arange(10), 5))
    twice = Measurements(once.channels, once.time[rows], once.arrival[rows], once.z[rows], R[rows])
    found = track(tracker, twice, PRIOR)
    assert believable(found)
    np.testing.assert_allclose(found.mean[6, [0, 2]], once.z[5], rtol=1e-9)
    assert found.skipped is None or np.flatnonzero(found.skipped.any(axis=1)).tolist() == [6]


@pytest.mark.parametrize("kind", TRACKERS)
def test_two_sensors_that_are_exact_at_once_leave_a_track(kind):
    two = of_two_sensors(record())
    R = np.array(two.R)
    R[5] = 0.0
    found = track(TRACKERS[kind](TWICE), dataclasses.replace(two, R=R), PRIOR)
    assert believable(found)
    assert np.flatnonzero(found.skipped.any(axis=1)).tolist() == [5]
    assert np.isnan(found.white[5]).all()


def test_only_the_run_whose_update_fails_is_skipped():
    two = of_two_sensors(record(runs=3))
    R = np.broadcast_to(two.R, (10, 4, 4, 3)).copy()
    R[5, ..., 1] = 0.0
    found = track(Kalman(TWICE), dataclasses.replace(two, R=R), PRIOR)
    assert np.argwhere(found.skipped).tolist() == [[5, 1]]
    clean = track(Kalman(TWICE), two, PRIOR)
    np.testing.assert_allclose(found.mean[..., [0, 2]], clean.mean[..., [0, 2]], rtol=1e-12)
    (lost,) = [epoch.skipped for epoch in follow(Kalman(TWICE), dataclasses.replace(two, R=R), PRIOR)][5:6]
    assert lost.tolist() == [False, True, False]


def test_an_exact_plot_is_kept_by_hubers_filter():
    """In the limit of no noise the loss is a constraint: the position is the plot, however far it is."""
    exact = record(runs=1)
    R = np.array(exact.R)
    R[5] = 0.0
    found = track(Huber(POSITION), dataclasses.replace(exact, R=R), PRIOR)
    np.testing.assert_allclose(found.mean[5, [0, 2]], exact.z[5], rtol=1e-9)


DAMAGE = st.tuples(
    st.integers(0, 9),
    st.sampled_from(["far", "exact", "vague", "absent", "late", "twice"]),
    st.floats(3.0, 300.0),
    st.sampled_from([*TRACKERS]),
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(DAMAGE, min_size=1, max_size=4))
def test_whatever_is_damaged_the_track_is_believable_or_the_record_refused(damages):
    measurements = record(runs=2)
    z, R = np.array(measurements.z), np.array(measurements.R)
    time = measurements.time.copy()
    for row, how, exponent, _ in damages:
        if how == "far":
            z[row] += 10.0**exponent
        elif how == "exact":
            R[row] = 0.0
        elif how == "vague":
            R[row] = record().R[row] * 10.0 ** (exponent - 4.0)
        elif how == "absent":
            z[row, 0] = np.nan
        elif how == "late":
            time[row:] += 10.0 ** (exponent / 75.0)
        else:
            time[row:] -= time[row] - time[max(row - 1, 0)]
    found = track(TRACKERS[damages[0][3]](POSITION), Measurements(measurements.channels, time, time, z, R), PRIOR)
    assert np.isfinite(found.mean).all()
    assert np.isfinite(found.cov).all()
    assert (np.einsum("kiib->kib", found.cov) >= 0.0).all()


@pytest.mark.parametrize("dt", [0.3, 1.0, 999.9, 1000.0, 1e4, 1e300])
def test_sub_steps_are_bounded_and_cover_the_time(dt):
    count, step, rest = sub_steps(dt, 1.0)
    assert count <= MOST_SUB_STEPS
    assert step <= 1.0 + 1e-9
    assert count * step + rest == pytest.approx(dt)
    assert rest == 0.0 or dt > MOST_SUB_STEPS


def test_a_prior_still_serves_runs_after_a_skip():
    """A skip gives a covariance of its own to each run; what follows is as before."""
    measurements = record(runs=3)
    measurements.z[0, :, 1] = 1e200
    found = track(KALMAN, measurements, Gaussian(PRIOR.mean, PRIOR.cov))
    assert np.argwhere(found.skipped).tolist() == [[0, 1]]
    assert believable(found)


class Fickle(Kalman):
    """Its update fails where the position is known well."""

    def step(self, state, dt, z, R):
        moved, innovation = super().step(state, dt, z, R)
        known = moved.cov[0, 0] < 0.5 * R[0, 0] if z is not None else False
        return Gaussian(np.where(known, np.nan, moved.mean), moved.cov), innovation


def test_a_run_says_which_tracker_skipped_how_many_looks_and_since_when():
    plots = {"kind": "surveillance_radar"}
    steady = {"kind": "kalman", "sensors": ["radar"]}
    given = {**CAPTURE, "sensors": {"radar": plots}, "trackers": {"steady": steady}, "draws": 1, "until_s": 40}
    result = sim.run(given, trackers={"fickle": Fickle(POSITION)})
    (said,) = [sentence for sentence in result.metrics["warnings"] if "could not use" in sentence]
    found = result.tracks["fickle"].track
    assert np.isfinite(found.mean).all()
    first, count = found.time[found.skipped[:, 0]][0], int(found.skipped.sum())
    assert said.startswith(
        f"tracker 'fickle' could not use {count} of {len(found.time)} looks, the first at {first:.1f} s"
    )
    assert count < len(found.time)
    assert result.metrics["trackers"]["fickle"]["skipped"] == {
        "looks": count, "of_looks": len(found.time), "first_s": pytest.approx(first)
    }  # fmt: skip


def test_looks_that_other_flights_skipped_are_told_too():
    figures = [{}, {"looks": 2, "of_looks": 40, "first_s": 9.0}, {"looks": 3, "of_looks": 41, "first_s": 5.0}]
    records = [
        {"flight": number, "metrics": {"trackers": {"fickle": {"skipped": one} if one else {}, "steady": {}}}}
        for number, one in enumerate(figures)
    ]
    (said,) = skipped_looks(records)
    told = "could not use 5 of 81 looks in 2 of 3 flights, the first in flight 1 at 9.0 s: what they measured"
    assert said.startswith(f"tracker 'fickle' {told}")
    together = over_flights(records)["fickle"]["skipped"]
    assert together == {"looks": 5, "of_looks": 81, "first_s": 5.0}


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("truth", "tracker 'truth': 'truth' is the motion itself"),
        ("my own", "tracker 'my own': a name starts with a letter"),
    ],
)
def test_a_tracker_of_the_caller_has_a_name_of_its_own(name, said):
    given = {**CAPTURE, "sensors": {"radar": {"kind": "surveillance_radar"}}, "draws": 1, "until_s": 1}
    with pytest.raises(sim.ScenarioError, match=said):
        sim.run(given, trackers={name: KALMAN})
