"""Turbulence against MIL-F-8785C with JSBSim's own beside it, and what microbursts do to the An-26's approach."""

from __future__ import annotations

import itertools
import math
import time
from functools import cache
from typing import Any

import numpy as np
import pytest

from aircraft import model_files
from aircraft.executive import fresh_executive
from aircraft.turbulence import Turbulence, across_spectrum, along_spectrum
from aircraft.turbulence_intensity import INTENSITIES, intensity
from sim.experiment import fly
from sim.flight.preparation import prepare
from sim.metrics.flight import flight_metrics
from sim.scenario.reading import read
from sim.studies.theory import border

pytestmark = pytest.mark.acceptance
FOOT = 0.3048
MODERATE, RATE = INTENSITIES["moderate"], 60.0
SEVERITY = 4  # JSBSim's index of moderate
TIME = 8000.0  # s; at the longest scale and 72 m/s a standard error of 1.7 % of sigma
CLOSE = {"start.phase": "final", "start.distance_m": 10000.0, "trackers": {}, "sensors": {}}
PLACES = (-4000.0, -2500.0, -1500.0, -500.0, 500.0, 1500.0)  # m past the threshold
STRENGTHS = [float(peak) for peak in range(4, 41, 2)]  # m/s; between two that end differently, one more


@cache
def ours(height: float, airspeed: float) -> np.ndarray:
    """(k, 3) m/s along, across, up of our turbulence, moderate."""
    air = Turbulence(MODERATE, np.random.default_rng(2001), course=0.0, rate=RATE)
    steps = range(int(TIME * RATE))
    return np.array([air.velocity(step / RATE, (0.0, 0.0, height), airspeed) for step in steps])


@cache
def milspec(height: float, airspeed: float) -> np.ndarray:
    """(k, 3) m/s of JSBSim's turbulence model 3, moderate, met by a body that is held where it is."""
    executive = fresh_executive(model_files.read("ball"), RATE)
    executive["ic/h-sl-ft"] = height / FOOT
    executive["ic/u-fps"] = airspeed / FOOT
    executive.run_ic()
    for motion in ("rate/rotational", "rate/translational", "position/rotational", "position/translational"):
        executive[f"simulation/integrator/{motion}"] = 0
    executive["atmosphere/randomseed"] = 7
    executive["atmosphere/turb-type"] = 3
    executive["atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps"] = MODERATE / FOOT
    executive["atmosphere/turbulence/milspec/severity"] = SEVERITY
    manager = executive.get_property_manager()
    read_out = [manager.get_node(f"atmosphere/turb-{axis}-fps").get_double_value for axis in ("north", "east", "down")]
    record = np.empty((int(TIME * RATE), 3))
    for row in record:
        executive.run()
        row[:] = [get() for get in read_out]
    return record * FOOT


def sigmas(record: np.ndarray) -> np.ndarray:
    """Of the three components, about zero."""
    return np.sqrt(np.mean(record**2, axis=0))


@pytest.mark.parametrize(
    ("height", "airspeed"),
    [(30.0, 72.0), (100.0, 72.0), (300.0, 72.0), (500.0, 150.0), (800.0, 150.0), (2000.0, 150.0)],
)
def test_sigma(row, height, airspeed):
    now = intensity(height, MODERATE)
    wanted = np.array([now.sigma_along, now.sigma_along, now.sigma_up])
    mine, theirs = sigmas(ours(height, airspeed)), sigmas(milspec(height, airspeed))
    error = float(np.abs(mine / wanted - 1.0).max())
    told = "/".join(f"{value:.2f}" for value in mine)
    beside = "/".join(f"{value:.2f}" for value in theirs)
    off = float(np.abs(theirs / wanted - 1.0).max())
    row(
        f"moderate turbulence at {height:.0f} m: sigma along/across/up, m/s",
        f"within 5 % of MIL-F-8785C, {'/'.join(f'{value:.2f}' for value in wanted)}",
        f"{told}, {100 * error:.1f} % off; JSBSim's Milspec {beside}, {100 * off:.1f} % off",
        error <= 0.05,
    )
    assert error <= 0.05


def density(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(circular frequency, one-sided density) by windows of 68 s."""
    from scipy.signal import welch

    frequency, power = welch(values, RATE, nperseg=4096)
    return 2.0 * math.pi * frequency, power / (2.0 * math.pi)


@pytest.mark.parametrize("height", [30.0, 100.0, 300.0])
def test_spectrum(row, height):
    now = intensity(height, MODERATE)
    told, worst = [], 0.0
    for axis, (name, form, sigma, length) in enumerate(
        (
            ("along", along_spectrum, now.sigma_along, now.length_along),
            ("across", across_spectrum, now.sigma_along, now.length_along),
            ("up", across_spectrum, now.sigma_up, now.length_up),
        )
    ):
        slopes = []
        for record in (ours(height, 72.0), milspec(height, 72.0)):
            frequency, power = density(record[:, axis])
            among = (frequency > 5.0 * 72.0 / length) & (frequency < 40.0)
            logs = np.log(frequency[among])
            slopes.append(np.polyfit(logs, np.log(power[among]), 1)[0])
        said = np.polyfit(logs, np.log(form(frequency[among], 72.0, sigma, length)), 1)[0]
        worst = max(worst, abs(slopes[0] - said))
        told.append(f"{name} {slopes[0]:.2f} (specified {said:.2f}; JSBSim's Milspec {slopes[1]:.2f})")
    row(
        f"turbulence at {height:.0f} m: slope of the spectrum beyond five corner frequencies, to 40 rad/s",
        "as specified, -2 at the end; within 0.1",
        ", ".join(told),
        worst <= 0.1,
    )
    assert worst <= 0.1


@cache
def ended(place: float, peak: float) -> tuple[str, str]:
    """(outcome, reason) of an26_pattern's final approach through a microburst."""
    burst = {"kind": "microburst", "past_threshold_m": place, "peak_mps": peak}
    flight = fly(prepare(read("an26_pattern", {**CLOSE, "designed": gains(), "wind.events": {"burst": burst}})))
    return flight.outcome, flight.reason


@cache
def gains() -> dict[str, Any]:
    """The design that all these flights share."""
    return prepare(read("an26_pattern", CLOSE)).designed.to_table()


def spans(place: float) -> str:
    """Outcomes over rising strength, each with the strength where it begins."""
    ends = {peak: ended(place, peak)[0] for peak in STRENGTHS}
    for low, high in itertools.pairwise(STRENGTHS):
        if ends[low] != ends[high]:
            ends[(low + high) / 2] = ended(place, (low + high) / 2)[0]
    runs = itertools.groupby(sorted(ends), lambda peak: ends[peak])
    return ", ".join(f"{outcome.replace('_', '-')} from {next(iter(peaks)):.0f}" for outcome, peaks in runs)


@pytest.mark.parametrize("place", PLACES)
def test_microburst_of_rising_strength(row, place):
    line = float(border("energy", read("an26_microburst"), np.array([place]))[0])
    row(
        f"an26_pattern, microburst {place:+.0f} m past the threshold, 4 to 40 m/s, to 1 m/s: outcomes",
        "the strength where each begins",
        f"{spans(place)} m/s; no power holds speed and glide path from {line:.1f} m/s",
        True,
    )
    assert ended(place, 4.0)[0] == "landed"


def test_microburst_map(row):
    cells = {(place, peak): ended(place, peak)[0] for place in PLACES for peak in STRENGTHS}
    lines = dict(zip(PLACES, border("energy", read("an26_microburst"), np.array(PLACES)), strict=True))
    above = [outcome for (place, peak), outcome in cells.items() if peak > lines[place]]
    below = [outcome for (place, peak), outcome in cells.items() if peak <= lines[place]]
    stayed, gone = below.count("landed") + below.count("ground"), len(above) - above.count("landed")
    counts = {outcome: list(cells.values()).count(outcome) for outcome in sorted(set(cells.values()))}
    row(
        f"the map of {len(cells)} flights: outcomes",
        "landed, go-around and ground occur",
        ", ".join(f"{count} {outcome.replace('_', '-')}" for outcome, count in counts.items()),
        {"landed", "go_around", "ground"} <= set(counts),
    )
    row(
        "the map against the energy line",
        "reported",
        f"below it {stayed} of {len(below)} come down to the runway, above it {gone - above.count('ground')} of "
        f"{len(above)} do not",
        True,
    )
    assert {"landed", "go_around", "ground"} <= set(counts)


@pytest.mark.parametrize(("name", "flights"), [("an26_shear", 10), ("an26_gust", 1)])  # single gusts know no chance
def test_bundled_weather_lands(row, name, flights):
    outcomes, sinks = [], []
    for seed in range(3001, 3001 + flights):
        prepared = prepare(read(name, {"seed": seed}))
        flight = fly(prepared)
        outcomes.append(flight.outcome)
        down = flight_metrics(flight, prepared.scenario.runway, prepared.law.bank_limit)["touchdown"]
        sinks.append(down["sink_mps"] if down else math.inf)
    met = outcomes.count("landed") == len(outcomes) and max(sinks) <= 3.05
    told = f"{outcomes.count('landed')} of {flights}; worst sink {max(sinks):.2f}"
    row(f"{name}, seeds of its own: landed", "all, with a sink <= 3.05 m/s", told, met)
    assert met


def test_cost_of_weather(row):
    """CPU seconds of the same 120 s of flight, least of three each, as ratios to calm air."""

    def cost(**wind):
        prepared = prepare(read("route_capture", {"until_s": 120.0, "wind": wind}))
        walls = []
        for _ in range(3):
            started = time.process_time()
            fly(prepared)
            walls.append(time.process_time() - started)
        return min(walls)

    calm, burst = cost(), {"b": {"kind": "microburst", "peak_mps": 3.0, "past_threshold_m": 10000.0}}
    told = {
        "steady": cost(speed_mps=5.0),
        "turbulence": cost(turbulence="light"),
        "shear": cost(speed_mps=5.0, shear="logarithmic"),
        "microburst": cost(events=burst),
    }
    said = ", ".join(f"{name} {seconds / calm:.2f}" for name, seconds in told.items())
    row("CPU time of a flight over that in calm air", "reported; steady about 1", said, told["steady"] < 1.2 * calm)
