"""Estimation kernel: processor time against filterpy, and memory.

Processor seconds (not wall time), the smallest of interleaved rounds: a ratio then holds on a shared machine. Other
packages appear where they are installed.
"""

from __future__ import annotations

import math
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from filterpy.kalman import IMMEstimator, KalmanFilter

from tracking.filterpy_adapter import FixedMotion
from tracking.gaussian import Gaussian
from tracking.measurement import ConvertedPolar, LinearMeasurement
from tracking.schedule import schedule
from tracking.track import Measurements, chunks, follow
from tracking.trackers.imm import InteractingMultipleModel, published_set
from tracking.trackers.kalman import Kalman

SCAN = 0.7
POSITION = LinearMeasurement(((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)))
PRIOR = Gaussian(np.array([12_000.0, -50.0, 300.0, 40.0]), np.diag([1e3, 25.0, 1e3, 25.0]))
MODELS = published_set(0.3)

RATE = 1.0 / 40.5
ANGLE_F, ANGLE_Q, ANGLE_R = ((1.0, RATE), (0.0, 1.0)), ((0.0, 0.0), (0.0, 1e-4)), 0.0036
ANGLE_PRIOR = Gaussian(np.array([0.7, 0.0122]), np.diag([50e-4, 0.0122**2]))


Row = tuple[str, str, str]  # what, measured, asked


class Contestant(NamedTuple):
    """Something to time: ``work()`` makes so many steps of so many runs."""

    what: str
    work: Callable[[], None]
    run_steps: int
    asked: float | None = None


def ratios(contestants: list[Contestant], rounds: int) -> list[Row]:
    """Time the contestants in turn, the first one being filterpy."""
    best = [math.inf] * len(contestants)
    for _ in range(rounds):
        for i, contestant in enumerate(contestants):
            begun = time.process_time()
            contestant.work()
            best[i] = min(best[i], (time.process_time() - begun) / contestant.run_steps)
    return [
        (
            contestant.what,
            f"{1e9 * seconds:.1f} ns per run and step, {best[0] / seconds:.1f} x filterpy",
            "" if contestant.asked is None else f">= {contestant.asked:.0f} x",
        )
        for contestant, seconds in zip(contestants, best, strict=True)
    ]


def positions(runs: int | None, steps: int, seed: int = 1) -> Measurements:
    """Positions whose accuracy differs from run to run and step to step, as converted plots have it."""
    rng = np.random.default_rng(seed)
    batch = () if runs is None else (runs,)
    now = SCAN * (1.0 + np.arange(steps))
    truth = np.stack([12_000.0 - 50.0 * now, 300.0 + 40.0 * now], axis=1).reshape(steps, 2, *(1,) * len(batch))
    A = 30.0 * rng.standard_normal((steps, 2, 2, *batch))
    R = np.einsum("kij...,klj...->kil...", A, A) + 1000.0 * np.eye(2).reshape(1, 2, 2, *(1,) * len(batch))
    z = truth + 50.0 * rng.standard_normal((steps, 2, *batch))
    return Measurements(("radar.north", "radar.east"), now, now, z, R)


def ours(tracker, measurements: Measurements, prior: Gaussian, size: int = 1536) -> Callable[[], None]:
    """Stream a record through a tracker, chunk by chunk."""
    runs = measurements.z.shape[2] if measurements.z.ndim == 3 else None

    def work() -> None:
        parts = [measurements] if runs is None else (measurements.runs(part) for part in chunks(runs, size))
        for part in parts:
            for _ in follow(tracker, part, prior, start=0.0):
                pass

    return work


def filterpy_imm(measurements: Measurements) -> Callable[[], None]:
    def work() -> None:
        filters = []
        for model in MODELS.models:
            F, Q, _ = model.transition(SCAN, None)
            member = KalmanFilter(dim_x=4, dim_z=2)
            member.F, member.Q, member.H = F.copy(), Q.copy(), np.array(POSITION.H)
            member.x, member.P = PRIOR.mean.reshape(4, 1).copy(), PRIOR.cov.copy()
            filters.append(member)
        imm = IMMEstimator(filters, np.array(MODELS.probabilities), np.array(MODELS.switching))
        for z, R in zip(measurements.z, measurements.R, strict=True):
            for member in filters:
                member.R = R
            imm.predict()
            imm.update(z.reshape(2, 1))

    return work


def kalbee_imm(measurements: Measurements) -> Iterator[Contestant]:
    """kalbee's interacting models, where it is installed; it takes one accuracy for all steps."""
    try:
        import kalbee as package
    except ImportError:
        return
    z, R = measurements.z, measurements.R[0]

    def work() -> None:
        members = []
        for model in MODELS.models:
            F, Q, _ = model.transition(SCAN, None)
            start = PRIOR.mean.reshape(4, 1).copy(), PRIOR.cov.copy()
            members.append(package.KalmanFilter(*start, F.copy(), Q.copy(), np.array(POSITION.H), R.copy()))
        imm = package.InteractingMultipleModel(members, np.array(MODELS.switching), np.array(MODELS.probabilities))
        for plot in z:
            imm.predict()
            imm.update(plot.reshape(2, 1))

    yield Contestant("IMM 3x4x2, kalbee", work, len(z))


def stone_soup_kalman(z) -> Iterator[Contestant]:
    """Stone Soup's Kalman filter, where it is installed."""
    try:
        from datetime import datetime, timedelta

        from stonesoup.models.measurement.linear import LinearGaussian
        from stonesoup.models.transition.linear import LinearGaussianTimeInvariantTransitionModel as Model
        from stonesoup.predictor.kalman import KalmanPredictor
        from stonesoup.types.detection import Detection
        from stonesoup.types.hypothesis import SingleHypothesis
        from stonesoup.types.prediction import GaussianStatePrediction
        from stonesoup.updater.kalman import KalmanUpdater
    except ImportError:
        return
    predictor = KalmanPredictor(Model(transition_matrix=np.array(ANGLE_F), covariance_matrix=np.array(ANGLE_Q)))
    sensor = LinearGaussian(ndim_state=2, mapping=(0,), noise_covar=np.array([[ANGLE_R]]))
    updater = KalmanUpdater(sensor)
    noon = datetime(2000, 1, 1)

    def work() -> None:
        state = GaussianStatePrediction(ANGLE_PRIOR.mean.reshape(2, 1), ANGLE_PRIOR.cov, timestamp=noon)
        for step, value in enumerate(z[:50, 0, 0], start=1):
            when = noon + timedelta(seconds=step * RATE)
            plot = Detection(np.array([[value]]), timestamp=when, measurement_model=sensor)
            state = updater.update(SingleHypothesis(predictor.predict(state, timestamp=when), plot))

    yield Contestant("Kalman 2x1, Stone Soup", work, 50)


def interacting_models(rounds: int = 7) -> list[Row]:
    """IMM 3 models x 4 states x 2 measurements."""
    tracker = InteractingMultipleModel(POSITION, MODELS)
    single, hundred, many = positions(None, 100), positions(130, 60), positions(10_000, 12)
    return ratios(
        [
            Contestant("IMM 3x4x2, filterpy", filterpy_imm(single), 100),
            *kalbee_imm(single),
            Contestant("IMM 3x4x2, 1 run", ours(tracker, single, PRIOR), 100, 4.0),
            Contestant("IMM 3x4x2, 130 runs", ours(tracker, hundred, PRIOR), 60 * 130, 350.0),
            Contestant("IMM 3x4x2, 10,000 runs in chunks of 1536", ours(tracker, many, PRIOR), 12 * 10_000, 750.0),
        ],
        rounds,
    )


def angles(runs: int, steps: int) -> Measurements:
    now = RATE * (1.0 + np.arange(steps))
    z = 0.7 + math.sqrt(ANGLE_R) * np.random.default_rng(2).standard_normal((steps, 1, runs))
    return Measurements(("mls.elevation",), now, now, z, np.full((steps, 1, 1, 1), ANGLE_R))


def filterpy_kalman(z) -> Callable[[], None]:
    def work() -> None:
        one = KalmanFilter(dim_x=2, dim_z=1)
        one.F, one.Q, one.H, one.R = np.array(ANGLE_F), np.array(ANGLE_Q), np.array([[1.0, 0.0]]), np.array([[ANGLE_R]])
        one.x, one.P = ANGLE_PRIOR.mean.reshape(2, 1).copy(), ANGLE_PRIOR.cov.copy()
        for value in z[:, 0, 0]:
            one.predict()
            one.update(value)

    return work


def simdkalman(z) -> Iterator[Contestant]:
    """simdkalman's batched filter, where it is installed."""
    try:
        import simdkalman as package
    except ImportError:
        return
    filter_ = package.KalmanFilter(np.array(ANGLE_F), np.array(ANGLE_Q), np.array([[1.0, 0.0]]), np.array([[ANGLE_R]]))
    data = np.ascontiguousarray(z[:100, 0, :1000].T)

    def work() -> None:
        filter_.compute(data, 0, filtered=True, smoothed=False, initial_value=ANGLE_PRIOR.mean)

    yield Contestant("Kalman 2x1, simdkalman, 1000 runs", work, data.size)


def common_noise(rounds: int = 5) -> list[Row]:
    """Kalman filter 2 x 1 with noise that all runs share: one covariance for all."""
    measurements = angles(10_000, 200)
    tracker = Kalman(LinearMeasurement(((1.0, 0.0),)), FixedMotion(ANGLE_F, ANGLE_Q, ("elevation", "elevation_rate")))
    stored = schedule(tracker, measurements.runs(slice(0, 1)), ANGLE_PRIOR, start=0.0)
    return ratios(
        [
            Contestant("Kalman 2x1, filterpy", filterpy_kalman(measurements.z), 200),
            Contestant(
                "Kalman 2x1, 10,000 runs",
                ours(tracker, measurements, ANGLE_PRIOR, 10_000),
                200 * 10_000,
            ),
            Contestant(
                "Kalman 2x1, 10,000 runs, stored gains",
                ours(stored, measurements, ANGLE_PRIOR, 10_000),
                200 * 10_000,
                3000.0,
            ),
            *simdkalman(measurements.z),
            *stone_soup_kalman(measurements.z),
        ],
        rounds,
    )


def stream() -> None:
    """IMM over 10,000 runs x 500 steps of polar plots with mean-square errors; prints the process's peak in MB."""
    runs, steps = 10_000, 500
    rng = np.random.default_rng(3)
    now = SCAN * np.arange(steps)
    truth = np.stack([12_000.0 - 20.0 * now, 3_000.0 + 10.0 * now])
    exact = np.stack([np.hypot(*truth), np.arctan2(truth[1], truth[0])], axis=1)
    sigma = np.array([30.0, math.radians(1.0)])
    R = np.broadcast_to(np.diag(sigma**2)[None, :, :, None], (steps, 2, 2, 1))
    tracker = InteractingMultipleModel(ConvertedPolar(height=0.0), MODELS)
    prior = Gaussian(np.array([truth[0, 0], -20.0, truth[1, 0], 10.0]), PRIOR.cov)
    squares = np.zeros(steps)
    for part in chunks(runs):
        count = part.stop - part.start
        z = exact[:, :, None] + sigma[:, None] * rng.standard_normal((steps, 2, count))
        for epoch in follow(tracker, Measurements(("radar.range", "radar.azimuth"), now, now, z, R), prior):
            mean = np.einsum("m...,im...->i...", epoch.estimate.weights, epoch.estimate.mean)[[0, 2]]
            squares[epoch.row] += np.square(mean - truth[:, epoch.row, None]).sum()
    unit = 1024.0 if sys.platform != "darwin" else 1024.0**2
    print(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit:.0f}")


def memory() -> list[Row]:
    """The peak is that of a whole process, so it gets one of its own."""
    peak = subprocess.run([sys.executable, __file__, "stream"], check=True, capture_output=True, text=True).stdout
    return [("IMM, 10,000 runs x 500 polar plots with statistics", f"peak {peak.strip()} MB", "< 300 MB")]


def main() -> list[Row]:
    """Every figure of the estimation kernel."""
    return [*interacting_models(), *common_noise(), *memory()]


if __name__ == "__main__":
    if sys.argv[1:] == ["stream"]:
        stream()
    else:
        for row in main():
            print("  ".join(row))
