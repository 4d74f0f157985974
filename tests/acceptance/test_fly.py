"""What the An-26 must show in closed loop."""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
import time
from functools import cache

import numpy as np
import pytest

from aircraft.airframe import load
from aircraft.data import data
from aircraft.trim import trim
from autopilot.analysis import BankReference, predict_kinematic, predict_limited, predict_linear
from sim.experiment import fly
from sim.flight.preparation import prepare
from sim.metrics.flight import flight_metrics
from sim.scenario.reading import read

pytestmark = pytest.mark.acceptance
SEEDS = range(1001, 1021)  # not the seeds on which anything was designed
# what these seeds gave, in the same air, before the flare was closed on the height of the wheels
BEFORE = {"landed": 19, "spread": 115.0, "sink": 2.94}  # of 20; m along the runway; m/s, the 19th


@cache
def flown(name, *changes, flight=0):
    prepared = prepare(read(name, dict(changes)))
    return prepared, fly(prepared, flight)


def figures(name, *changes, flight=0):
    prepared, one = flown(name, *changes, flight=flight)
    return flight_metrics(one, prepared.scenario.runway, prepared.law.bank_limit)


@pytest.mark.parametrize(("speed", "flaps", "gear"), [(72, 15, 0), (69, 15, 0), (58, 38, 1)])
@pytest.mark.parametrize("glide", [0.0, 8 / 3, 3.0])
def test_trim(row, speed, flaps, gear, glide):
    found = trim(load("an26", 20000.0), speed, -math.radians(glide), 600.0, math.radians(flaps), gear)
    alpha = math.degrees(found.initial.angle_of_attack)
    controls = f"power {found.controls.throttle:.3f}, elevator {found.controls.elevator:+.3f}"
    told = f"{found.residual:.1e}; alpha {alpha:.2f} deg, {controls}"
    row(f"trim {speed} m/s, flaps {flaps}, {glide:.2f} deg down: residual", "< 1e-6", told, found.residual < 1e-6)
    assert found.residual < 1e-6


def over_stall(down, mass):
    return down["airspeed_mps"] / data("an26").stall_speed(math.radians(38.0), mass)


@pytest.mark.parametrize("mass", [16000, 18000, 20000, 22000, 24000])
def test_landing_at_every_mass(row, mass):
    m = figures("an26_pattern", ("aircraft.mass_kg", float(mass)), ("start.phase", "final"))
    down = m["touchdown"]
    margin = over_stall(down, mass)
    met = (
        m["outcome"] == "landed"
        and down["main_first"] == 1
        and down["pitch_deg"] > 0
        and 1.1 <= margin <= 1.25
        and 350 <= down["past_threshold_m"] <= 600
        and down["sink_mps"] <= 0.8
    )
    told = (
        f"{m['outcome']}; pitch {down['pitch_deg']:.2f} deg, {margin:.2f} Vs, {down['past_threshold_m']:.0f} m, "
        f"{down['sink_mps']:.2f} m/s"
    )
    row(f"landing at {mass} kg, calm", "pitch > 0; 1.10-1.25 Vs; 350-600 m; <= 0.8 m/s", told, met)
    assert met


@pytest.mark.parametrize("name", ["an26_pattern", "an26_pattern_right"])
def test_pattern_calm(row, name):
    m = figures(name)
    down = m["touchdown"]
    margin = over_stall(down, 20000)
    rows = [
        ("bank, deg", "<= 16.1", m["bank_max_deg"], m["bank_max_deg"] <= 16.1),
        ("base overshoot, m", "<= 5", m["base_overshoot_m"], m["base_overshoot_m"] <= 5),
        ("final overshoot, m", "<= 1", m["overshoot_m"], m["overshoot_m"] <= 1),
        (
            "height error on the glide path, m rms",
            "<= 0.2",
            m["height_error_rms_final_m"],
            m["height_error_rms_final_m"] <= 0.2,
        ),
        ("cross-track at 30 m, m", "<= 0.5", m["cross_track_at_30_m_m"], abs(m["cross_track_at_30_m_m"]) <= 0.5),
        (
            "touchdown past the threshold, m",
            "350-600",
            down["past_threshold_m"],
            350 <= down["past_threshold_m"] <= 600,
        ),
        ("touchdown off the centreline, m", "<= 2", down["cross_track_m"], abs(down["cross_track_m"]) <= 2),
        ("touchdown sink, m/s", "<= 0.8", down["sink_mps"], down["sink_mps"] <= 0.8),
        ("touchdown pitch, deg", "> 0", down["pitch_deg"], down["pitch_deg"] > 0),
        ("main wheels first", "1", down["main_first"], down["main_first"] == 1),
        ("touchdown airspeed over the stall", "1.10-1.25", margin, 1.1 <= margin <= 1.25),
    ]
    for what, asked, value, met in rows:
        row(f"{name}: {what}", asked, f"{value:.3g}", met)
    assert m["outcome"] == "landed"
    assert all(met for *_, met in rows)


@pytest.mark.parametrize("direction", range(0, 360, 45))
def test_pattern_in_wind(row, direction):
    m = figures("an26_pattern", ("wind.from_deg", float(direction + 80)), ("wind.speed_mps", 10.0))
    down = m["touchdown"]
    met = (
        m["outcome"] == "landed"
        and m["base_overshoot_m"] <= 30
        and m["overshoot_m"] <= 30
        and abs(down["cross_track_m"]) <= 2
        and 60 <= down["past_threshold_m"] <= 823
        and abs(down["crab_deg"]) <= 5
        and abs(down["drift_mps"]) <= 1.5
        and down["pitch_deg"] > 0
        and down["main_first"] == 1
    )
    told = (
        f"{m['outcome']}; {m['base_overshoot_m']:.1f}, {m['overshoot_m']:.1f} m; {down['past_threshold_m']:.0f} m, "
        f"{down['cross_track_m']:+.2f} m; crab {down['crab_deg']:+.1f} deg, drift {down['drift_mps']:+.2f} m/s"
    )
    asked = "landed; overshoots <= 30 m; box 60-823 m, within 2 m; crab <= 5 deg, drift <= 1.5 m/s"
    row(f"10 m/s from {direction} deg right of the runway heading", asked, told, met)
    assert met


def test_pattern_in_turbulence(row):
    wind = (("wind.turbulence", "moderate"), ("wind.speed_mps", 8.0))
    all_of_them = [
        figures("an26_pattern", *wind, ("wind.from_deg", float((37 * seed) % 360)), ("seed", seed)) for seed in SEEDS
    ]
    outcomes = [m["outcome"] for m in all_of_them]
    landed = [m for m in all_of_them if m["outcome"] == "landed"]
    bank = max(m["bank_max_deg"] for m in all_of_them)
    height = max(m["height_error_rms_final_m"] for m in landed)
    sinks = sorted(m["touchdown"]["sink_mps"] for m in landed)
    nose = min(m["touchdown"]["pitch_deg"] for m in landed)
    spread = float(np.std([m["touchdown"]["past_threshold_m"] for m in landed]))
    rows = [
        ("lowest pitch at touchdown, deg", "> 0", f"{nose:.2f}", nose > 0),
        (
            "touchdown along the runway, m, standard deviation",
            f"<= {BEFORE['spread']:.0f}, as before",
            f"{spread:.0f}",
            spread <= BEFORE["spread"],
        ),
        (
            "landed of 20",
            f">= {BEFORE['landed']}, as before",
            f"{len(landed)} {sorted(set(outcomes))}",
            len(landed) >= BEFORE["landed"],
        ),
        ("bank, deg", "<= 19", f"{bank:.2f}", bank <= 19),
        ("worst height error, m rms", "<= 5", f"{height:.2f}", height <= 5),
        (
            "19th sink, m/s",
            f"<= {BEFORE['sink']}, as before",
            f"{sinks[min(18, len(sinks) - 1)]:.2f}",
            len(sinks) >= 19 and sinks[18] <= BEFORE["sink"],
        ),
        ("worst sink, m/s", "<= 3.05", f"{sinks[-1]:.2f}", sinks[-1] <= 3.05),
    ]
    for what, asked, told, met in rows:
        row(f"moderate turbulence and 8 m/s from anywhere, 20 seeds: {what}", asked, told, met)
    assert all(met for *_, met in rows)


def test_route_capture_against_its_predictions(row):
    prepared, one = flown("route_capture")
    z, time_, law = one.deviation.cross_track, one.time, prepared.law
    reference = BankReference(72.0, prepared.scenario.autopilot.roll_rate_limit, prepared.designed.reference_frequency)
    rate0 = float(one.deviation.cross_track_rate[0])
    predictions = {
        "double integrator with the limits, (6)+(4)": (predict_limited(law, z[0], rate0, time_), 35.0),
        "with rate-limited bank reference and tan/cos": (predict_kinematic(law, z[0], rate0, time_, reference), 10.0),
    }
    for what, (prediction, limit) in predictions.items():
        rms = float(np.sqrt(np.mean((prediction.cross_track - z) ** 2)))
        row(f"route_capture: {what}, m rms", f"<= {limit:.0f}", f"{rms:.1f}", rms <= limit)
        assert rms <= limit
    linear = predict_linear(law, z[0], rate0, time_[::10])
    rms = float(np.sqrt(np.mean((linear.cross_track - z[::10]) ** 2)))
    row("route_capture: linear model (7), m rms", "> 500", f"{rms:.0f}", rms > 500)
    assert rms > 500


def test_same_bytes_in_two_processes(row, tmp_path):
    content = []
    for name in ("a", "b"):
        command = [sys.executable, "-m", "sim", "run", "an26_turbulence", "-o", str(tmp_path / name)]
        assert subprocess.run(command, check=False, capture_output=True).returncode in (0, 1)
        content.append((tmp_path / name / "metrics.json").read_bytes())
    same = content[0] == content[1]
    row("an26_turbulence twice: bytes of metrics.json", "equal", "equal" if same else "different", same)
    assert same
    assert json.loads(content[0])["flight"]["outcome"]


def test_cost_of_a_run(row, tmp_path):
    command = [sys.executable, "-m", "sim", "run", "an26_pattern", "--set", "trackers={}", "-o", str(tmp_path / "o")]
    walls = []
    for _ in range(3):
        started = time.perf_counter()
        assert subprocess.run(command, check=False, capture_output=True).returncode == 0
        walls.append(time.perf_counter() - started)
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    row(
        "run an26_pattern without trackers, process start to report, s (best of 3)",
        "<= 6",
        f"{min(walls):.2f}",
        min(walls) <= 6,
    )
    row("its peak memory, MB", "< 300", f"{peak:.0f}", peak < 300)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "sim", "--help"], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    row("--help, s of CPU", "<= 0.3", f"{used:.2f}", used <= 0.3)
    assert peak < 300
