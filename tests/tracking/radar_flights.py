"""Flights of a point past a radar in closed form, and what the radar and a downlink measure of them."""

from __future__ import annotations

import numpy as np

from tracking.gaussian import Gaussian
from tracking.motion import GRAVITY
from tracking.track import Measurements, follow
from tracking.trackers.load_factor import DOWNLINK

DEGREE = np.pi / 180
MEASURED = (*("radar." + name for name in ("range", "azimuth", "elevation")), *("link." + name for name in DOWNLINK))
FINE = 0.01  # s, grid of the truths
BANK = 15 * DEGREE


def ramp(time, start, stop, rise=5.0):
    """From 0 to 1 and back, twice differentiable."""

    def smooth(x):
        x = np.clip(x, 0.0, 1.0)
        return x**3 * (10 - 15 * x + 6 * x * x)

    return smooth((time - start) / rise) - smooth((time - stop) / rise)


def fly(duration, north, east, course, bank, speed=72.0, path=0.0, height=400.0):
    """Coordinated flight of a point past a radar at the origin that looks north: positions, rates, load factors."""

    def integral(values, step):  # Simpson's rule over pairs of steps, at every second point
        parts = (values[:-2:2] + 4 * values[1:-1:2] + values[2::2]) * step / 3
        return np.concatenate([[0.0], np.cumsum(parts)])

    quarter = np.arange(round(duration / FINE) * 4 + 1) * FINE / 4
    courses = course + integral(GRAVITY * np.tan(bank(quarter)) / speed, FINE / 4)
    ground = speed * np.cos(path)
    n = north + integral(ground * np.cos(courses), FINE / 2)
    e = east + integral(ground * np.sin(courses), FINE / 2)
    time, chi = quarter[::4], courses[::2]
    turn = GRAVITY * np.tan(bank(time)) / speed
    climb = speed * np.sin(path)
    h = height + climb * time
    vn, ve = ground * np.cos(chi), ground * np.sin(chi)
    an, ae = -ve * turn, vn * turn
    square = n * n + e * e
    rho, slant = np.sqrt(square), np.sqrt(square + h * h)
    radial = n * vn + e * ve
    side = ground * turn / GRAVITY
    return {
        "time": time,
        "north": n,
        "east": e,
        "north_rate": vn,
        "east_rate": ve,
        "range": slant,
        "range_rate": (radial + h * climb) / slant,
        "azimuth": np.arctan2(e, n),
        "azimuth_rate": (n * ve - e * vn) / square,
        "azimuth_acceleration": (n * ae - e * an) / square - 2 * (n * ve - e * vn) * radial / square**2,
        "elevation": np.arctan2(h, rho),
        "elevation_rate": (climb * rho - h * radial / rho) / slant**2,
        "load_factor_forward": np.full_like(time, np.sin(path)),
        "load_factor_up": np.hypot(np.cos(path), side),
        "load_factor_right": np.zeros_like(time),
        "aerodynamic_bank": np.arctan2(side, np.cos(path)),
        "flight_path_angle": np.full_like(time, path),
        "air_course": chi,
        "turning": np.abs(bank(time)) > DEGREE,
    }


def base_turn(side=-1.0):
    """Base leg, turn and final of a left-hand (side = -1) circuit, 8.5 km before the radar."""
    return fly(120, 8500, -4950 * side, side * np.pi / 2, lambda t: side * BANK * ramp(t, 40, 84.5))


def s_turn():
    return fly(100, 9800, 300, np.pi, lambda t: -BANK * (ramp(t, 10, 30) - ramp(t, 35, 75) + ramp(t, 80, 100)))


def glide_turn():
    return fly(60, 6000, 3000, -2.0, lambda t: -BANK * ramp(t, 10, 50), path=-3 * DEGREE, height=600.0)


SIGMAS = {"range": 30.0, "aerodynamic_bank": 0.5 * DEGREE, "flight_path_angle": 0.25 * DEGREE,
          "air_course": 0.5 * DEGREE}  # fmt: skip


def observed(flight, period, angle, runs, rng, scale=1.0):
    """Measurements every period with noise scaled by ``scale``, and their covariance; load factors to 0.01."""
    rows = np.arange(round(period / FINE), len(flight["time"]), round(period / FINE))
    names = [name.split(".")[1] for name in MEASURED]
    sigmas = np.array([SIGMAS.get(name, angle if name in ("azimuth", "elevation") else 0.01) for name in names])
    exact = np.stack([flight[name][rows] for name in names], axis=1)[..., None]
    z = exact + scale * sigmas[:, None] * rng.standard_normal((len(rows), len(names), runs))
    R = np.broadcast_to(np.diag(sigmas**2), (len(rows), 9, 9))
    return rows, Measurements(MEASURED, flight["time"][rows], flight["time"][rows], z, R)


def prior_of(flight, angle, runs, rng, scale=1.0):
    sigmas = np.array([100.0, 5.0, 2 * angle, 0.002, 2 * angle, 5e-4])
    names = ("range", "range_rate", "azimuth", "azimuth_rate", "elevation", "elevation_rate")
    mean = np.array([flight[name][0] for name in names])[:, None]
    return Gaussian(mean + scale * sigmas[:, None] * rng.standard_normal((6, runs)), np.diag(sigmas**2))


def azimuth_errors(tracker, flight, rows, measurements, prior):
    errors = [
        epoch.estimate.mean[2] - flight["azimuth"][rows[epoch.row]]
        for epoch in follow(tracker, measurements, prior, start=0.0)
    ]
    return (np.array(errors) + np.pi) % (2 * np.pi) - np.pi


def deaf(measurements, chosen=slice(None)):
    """The same without the downlink at the chosen epochs."""
    z = np.array(measurements.z)
    z[chosen, 3:] = np.nan
    return Measurements(measurements.channels, measurements.time, measurements.arrival, z, measurements.R)


def rms(errors):
    return np.sqrt(np.mean(np.square(errors)))
