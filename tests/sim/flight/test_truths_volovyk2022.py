"""The kinematic landing pattern against the measured results of Volovyk's experiment on independent truths."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim.flight.truths.landing_pattern import BASE, FINAL_TURN, GLIDE, GROUND, LandingPattern
from tracking.gaussian import Gaussian
from tracking.measurement import ConvertedPolar
from tracking.track import Measurements, track
from tracking.trackers.imm import InteractingMultipleModel, published_set

PERIOD, STEP, RUNS = 0.7, 0.35, 130
RADAR = (300.0 + 900.0, 150.0)  # m, 900 m past the aiming point, 150 m right of the centreline
SIGMAS = np.array([30.0, math.radians(1.0)])
PRIOR = np.diag([1e3, 0.05, 1e3, 0.05])


@pytest.fixture(scope="module")
def experiment():
    """Scans of 130 runs from the base leg to the touchdown: measurements, true (north, east), phases."""
    generator = np.random.default_rng(20221026)
    flight = LandingPattern().fly(generator, RUNS, step=STEP)
    rows = np.arange(round(PERIOD / STEP), len(flight.time), round(PERIOD / STEP))
    truth = np.stack([flight.state.north[rows], flight.state.east[rows]], axis=1)
    north, east = truth[:, 0] - RADAR[0], truth[:, 1] - RADAR[1]
    polar = np.stack([np.hypot(north, east), np.arctan2(east, north)], axis=1)
    z = polar + SIGMAS[:, None] * generator.standard_normal(polar.shape)
    R = np.broadcast_to(np.diag(SIGMAS**2), (len(rows), 2, 2))
    measurements = Measurements(("radar.range", "radar.azimuth"), flight.time[rows], flight.time[rows], z, R)
    state = flight.state
    start = np.array([state.north[0], state.velocity_north[0], state.east[0], state.velocity_east[0]])
    return measurements, truth, polar[:, 1], flight.phase[rows], Gaussian(start, PRIOR)


def gains(experiment, density: float) -> dict[str, float]:
    """Raw over filtered RMSE of position and azimuth, by phases."""
    measurements, truth, azimuth, phase, prior = experiment
    tracker = InteractingMultipleModel(ConvertedPolar(position=RADAR, height=0.0), published_set(density))
    estimate = track(tracker, measurements, prior, start=0.0).mean[:, [0, 2]]
    radar = np.array(RADAR)[:, None]
    z = measurements.z
    raw = radar + z[:, :1] * np.stack([np.cos(z[:, 1]), np.sin(z[:, 1])], axis=1)
    off = np.arctan2(estimate[:, 1] - RADAR[1], estimate[:, 0] - RADAR[0]) - azimuth
    squares = {
        "position": (((raw - truth) ** 2).sum(axis=1), ((estimate - truth) ** 2).sum(axis=1)),
        "azimuth": ((z[:, 1] - azimuth) ** 2, np.angle(np.exp(1j * off)) ** 2),
    }
    masks = {"all": phase < GROUND, "base": phase == BASE, "turn": phase == FINAL_TURN, "glide": phase == GLIDE}
    return {
        f"{what} {where}": math.sqrt(before[mask].mean() / after[mask].mean())
        for what, (before, after) in squares.items()
        for where, mask in masks.items()
    }


def test_published_filter_on_the_glide_path(experiment):
    """1.27 +- .08 in position, 1.49 +- .09 in azimuth: five deviations of a batch of 130 runs, and the geometry."""
    measured = gains(experiment, 0.01)
    assert measured["position glide"] == pytest.approx(1.27, abs=0.08)
    assert measured["azimuth glide"] == pytest.approx(1.49, abs=0.09)
    assert measured["position all"] == pytest.approx(2.9, abs=0.25)
    assert measured["position base"] > 9.0  # 13.1 +- .44 there; the leg's length and the hand-over matter


def test_more_process_noise_on_the_glide_path(experiment):
    """All phases >= 3.8 (4.14 +- .25), glide path >= 2.5 (2.78)."""
    measured = gains(experiment, 0.3)
    assert measured["position all"] >= 3.8
    assert measured["position glide"] >= 2.5
