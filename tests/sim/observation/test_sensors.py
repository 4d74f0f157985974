"""Every sensor of the folder: its noise is what it says, its epochs are its own, any step sees the same draws."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from aircraft.state import AircraftState
from sim.observation.antenna import inside, polar
from sim.observation.record import SensorRecord, measurements, observe
from sim.observation.sensor import broken_promises, quantity_of
from sim.randomness import Streams
from sim.scenario import catalogue
from sim.scenario.parameters import construct
from sim.scenario.tables import Runway
from tracking.measurement import wrap
from tracking.trackers.switching_noise import BeamNoise

RUNWAY = Runway(heading=math.radians(80.0))
KINDS = catalogue.kinds("sensors")
VARIANTS = {
    "surveillance_radar": [
        {},
        {"position_sigma": 100.0, "period": 0.31},
        {"range_step": 200.0, "azimuth_step": math.radians(0.5), "detection": 0.8, "coverage": 20e3},
    ],
    "localiser": [{}, {"course_offset": math.radians(6.0), "position": (2600.0, 300.0, 3.0)}],
    "precision_radar": [{}, {"accuracy": "constant", "period": 1 / 3, "detection": 0.9, "latency": 0.5}],
    "mls": [
        {},
        {"beam": BeamNoise(snr=5.38, at_distance=750.0, floor=math.radians(0.02))},
        {"angle": "azimuth", "position": (3500.0, 0.0, 2.0)},
    ],
}
WATCHING = [kind for kind in KINDS if kind != "recorded"]  # that has its looks from a file: test_recorded.py
CASES = [(kind, variant) for kind in WATCHING for variant in VARIANTS.get(kind, [{}])]


def build(kind, variant):
    return catalogue.load("sensors", kind)(**variant, runway=RUNWAY)


@pytest.fixture
def glide(make_flight):
    """Down the glide path along the runway's course, 12 km to 2 km before the threshold."""
    time = np.arange(0.0, 170.0, 1 / 30)
    past = -12_000.0 + 58.0 * time
    north, east = RUNWAY.to_local(past, np.full(len(time), 25.0))
    height = (RUNWAY.aiming_point - past) * math.tan(RUNWAY.glide_path)
    heading = np.full(len(time), RUNWAY.heading)
    return make_flight(
        time,
        ["glide"] * len(time),
        north=north,
        east=east,
        height=height,
        heading=heading,
        velocity_north=58.0 * np.cos(heading),
        velocity_east=58.0 * np.sin(heading),
        velocity_up=np.full(len(time), -58.0 * math.tan(RUNWAY.glide_path)),
        pitch=np.full(len(time), -RUNWAY.glide_path),
        airspeed=np.full(len(time), 58.0 / math.cos(RUNWAY.glide_path)),
        specific_force_down=np.full(len(time), -9.80665),
    )


def truth_at(sensor, flight, time):
    s = flight.state
    state = AircraftState(*(np.interp(time, s.time, column) for column in s))
    return sensor.truth(state)


@pytest.mark.parametrize("kind", KINDS)
def test_every_sensor_of_the_folder_keeps_its_contract(kind):
    cls = catalogue.load("sensors", kind)
    assert broken_promises(cls, lambda: construct(cls, getattr(cls, "example", {}), runway=Runway())) == []


@pytest.mark.parametrize(("kind", "variant"), CASES)
def test_noise_passes_a_chi_square_against_the_stated_covariance(kind, variant, glide):
    sensor = build(kind, variant)
    record = observe(glide, {"x": sensor}, seed=5, draws=40)["x"]
    error = record.z - truth_at(sensor, glide, record.time).T[:, :, None]
    angles = [i for i, name in enumerate(sensor.channels) if quantity_of(name).wraps]
    error[:, angles] = wrap(error[:, angles])
    R = record.R if record.R.ndim == 4 else record.R[..., None]
    squares = np.einsum("kdn,kdn->kn", error, error / np.einsum("kddn->kdn", R))
    squares = squares[np.isfinite(squares)]
    degrees = squares.size * len(sensor.channels)
    # the stated accuracy of a radar whose errors grow with distance is that at the measured place: 2 % more spread
    slack = 0.02 if R.shape[-1] > 1 else 0.0
    low, high = stats.chi2.ppf([5e-5, 1 - 5e-5], degrees) / degrees
    assert low - slack <= squares.sum() / degrees <= high + slack
    assert squares.size > 100


@pytest.mark.parametrize(("kind", "variant"), CASES)
def test_epochs_are_multiples_of_the_period_and_of_nothing_else(kind, variant, glide):
    sensor = build(kind, variant)
    record = observe(glide, {"x": sensor}, seed=5)["x"]
    turns = record.time / sensor.period
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-6)  # rounding of up to 7000 additions
    assert record.time[-1] <= glide.time[-1]
    assert np.all(record.arrival >= record.time)


@pytest.mark.parametrize(("kind", "variant"), CASES)
def test_steps_of_the_record_and_of_every_third_record_see_the_same_noise(kind, variant, glide):
    sensor = build(kind, variant)
    noises = []
    for stride in (1, 3):
        rows = [AircraftState(*row) for row in np.column_stack(glide.state)[:1801:stride].tolist()]
        state, seen = sensor.begin(0.0, Streams(5, 0, 2, "x")), []
        for before, after in pairwise(rows):
            state, looks = sensor.step(state, before, after)
            seen += looks
        noises.append(np.array([look.z for look in seen]))
    count = min(map(len, noises))
    # the motion is straight and uniform, so interpolation over three records is exact but for rounding
    np.testing.assert_allclose(noises[0][:count], noises[1][:count], rtol=0, atol=1e-6)
    # over a record it is not stepped through what no epoch lies in, and sees the same
    seen = observe(glide, {"x": sensor}, seed=5, draws=2)["x"].z
    np.testing.assert_array_equal(seen[: len(noises[0])], noises[0])


def test_azimuth_is_right_seen_from_the_antenna():
    radar = build("precision_radar", {"position": (0.0, 0.0, 0.0)})
    north, east = RUNWAY.to_local(-5000.0, 100.0)  # right of the centreline for the pilot
    _, azimuth, elevation = polar((north, east, 300.0), radar.antenna, radar.zero_azimuth)
    assert azimuth == pytest.approx(-math.atan(100 / 5000))
    assert elevation == pytest.approx(math.atan(300 / math.hypot(5000, 100)))


def test_annex_10_accuracy_is_half_its_limits():
    radar = build("precision_radar", {"position": (300.0, 0.0, 0.0)})
    sigmas = radar.sigmas(10_000.0, 0.0, RUNWAY.glide_path)
    # 0.6 % of 10 km across, 0.4 % in height, 30 m and 3 % in range, each two standard deviations
    assert sigmas * (1, 10_000, 10_000) == pytest.approx((165.0, 30.0, 20.0))
    near = radar.sigmas(1000.0, 0.0, RUNWAY.glide_path)
    assert near[1:] * 1000 == pytest.approx((4.5, 3.0))  # the least errors, 9 m and 6 m


def test_a_sector_sees_no_downwind(make_flight):
    time = np.arange(0.0, 60.0, 1 / 30)
    north, east = RUNWAY.to_local(-5000.0 - 70.0 * time, np.full(len(time), -7000.0))
    flight = make_flight(time, ["final"] * len(time), north=north, east=east, height=np.full(len(time), 400.0))
    narrow, all_round = (build("precision_radar", {"sector": math.radians(width)}) for width in (20.0, 360.0))
    assert len(observe(flight, {"x": narrow}, 1)["x"].time) == 0
    assert len(observe(flight, {"x": all_round}, 1)["x"].time) > 80


def test_a_localiser_s_course_line_is_offset_clockwise_and_its_error_is_the_bias(glide):
    aligned, offset = (build("localiser", {"course_offset": math.radians(turn)}) for turn in (0.0, 5.0))
    antenna = np.array(aligned.antenna)
    for sensor, course in ((aligned, RUNWAY.heading), (offset, RUNWAY.heading + math.radians(5.0))):
        before = antenna - 9000.0 * np.array((math.cos(course), math.sin(course), 0.0))  # inbound on the course line
        assert sensor.truth(on(*before)) == pytest.approx([0.0], abs=1e-12)
    biased = build("localiser", {"bias": math.radians(0.5)})
    plain, wrong = (observe(glide, {"x": sensor}, seed=5)["x"].z for sensor in (aligned, biased))
    np.testing.assert_allclose(wrong - plain, math.radians(0.5))


def test_a_localiser_is_silent_outside_its_sector(make_flight):
    time = np.arange(0.0, 10.0, 1 / 30)
    for right, seen in ((4000.0, True), (6000.0, False)):  # 5 km beyond the antenna's 2800 m: 35 deg is 5460 m beside
        north, east = RUNWAY.to_local(np.full(len(time), -5000.0), np.full(len(time), right))
        flight = make_flight(time, ["final"] * len(time), north=north, east=east)
        assert (len(observe(flight, {"x": build("localiser", {})}, 1)["x"].time) > 0) == seen


def on(north, east, height):
    """A state at a place, at rest."""
    return AircraftState(*[0.0] * len(AircraftState._fields))._replace(north=north, east=east, height=height)


@pytest.mark.parametrize("kind", WATCHING)
def test_no_sensor_sees_beyond_its_outline(kind, make_flight):
    """All round it at 12 km: looks lie inside, and where there is an outline, not everything is."""
    sensor = build(kind, {})
    time = np.arange(0.0, 90.0, 1 / 10)
    turn = 2 * math.pi * time / 90.0
    north, east = 12_000.0 * np.cos(turn), 12_000.0 * np.sin(turn)
    velocity = {"velocity_north": -838.0 * np.sin(turn), "velocity_east": 838.0 * np.cos(turn)}
    flight = make_flight(time, ["final"] * len(time), north=north, east=east, height=400.0 + 0 * time, **velocity)
    record = observe(flight, {"x": sensor}, seed=2)["x"]
    place = np.interp(record.time, time, north), np.interp(record.time, time, east)
    # the angle subtended by the chord of the arc of an outline's edge is under 0.02 deg
    share = inside(sensor.outline(), *place).mean() if len(record.time) else 1.0
    assert share > 0.99
    if sensor.outline():
        assert 0.0 < inside(sensor.outline(), north, east).mean() < 0.5


@pytest.mark.parametrize("anomalies", ["iid", "bursts", "bias_bursts", "dropouts"])
def test_anomalies_have_their_share_and_their_length(anomalies):
    sensor = build("mls", {"anomalies": anomalies, "burst_length": 1.25 if anomalies == "iid" else 20.0})
    look = sensor.begin(0.0, Streams(3, 0, 400, "x"))
    states = [look.anomalous]
    for _ in range(600):
        states.append(sensor._chain(states[-1], look.luck.row()[0]))
    chain = np.array(states)
    assert chain.mean() == pytest.approx(0.2, abs=0.02)  # 5 sd for runs of 20 in 240 000 samples
    ends = (chain[:-1] & ~chain[1:]).sum()
    length = chain[:-1].sum() / ends
    assert length == pytest.approx(sensor.burst_length, rel=0.1)  # 2400 bursts: sd 2 %


def test_silence_and_latency_of_the_downlink(glide):
    sensor = build("downlink", {"latency": 0.7, "silent_from": 50.0, "silent_until": 80.0})
    record = observe(glide, {"x": sensor}, 1)["x"]
    assert not ((record.time >= 50) & (record.time < 80)).any()
    np.testing.assert_allclose(record.arrival - record.time, 0.7)


def test_two_sensors_are_merged_in_order_of_arrival(glide):
    sensors = {"link": build("downlink", {"latency": 0.7, "period": 1.0}), "radar": build("surveillance_radar", {})}
    both = measurements(observe(glide, sensors, 1, draws=3), ("link", "radar"))
    assert np.all(np.diff(both.arrival) >= 0)
    assert both.z.shape[1:] == (8, 3)
    assert np.isnan(both.z[:, :6]).all(axis=(1, 2)).any()
    assert not np.isnan(both.z).all(axis=1).any()
    count = sum(len(record.time) for record in observe(glide, sensors, 1).values())
    assert len(both.time) == count  # 0.7 s of latency never meets the 4 s of the radar


@pytest.mark.parametrize(
    ("kind", "variant", "said"),
    [
        ("mls", {"anomalies": "bursts", "anomaly_share": 0.9, "burst_length": 2.0}, "burst_length must be at least 9"),
        ("precision_radar", {"detection": 1.2}, "detection must be at most 1"),
        ("downlink", {"latency": -1.0}, "latency must be at least 0"),
        ("dme", {"period": 0.001}, "finer than 1/120 s"),
        ("radio_altimeter", {"sigma": 0.0}, "sigma must be above 0"),
        ("localiser", {"course_offset": 1.0}, "course_offset must be at most 0.785"),
        ("localiser", {"bias": 0.1}, "bias must be at most 0.0872665: beyond, nobody would fly it"),
    ],
)
def test_bad_parameters_are_told(kind, variant, said):
    with pytest.raises(ValueError, match=said):
        build(kind, variant)


def test_no_tracker_can_change_what_the_others_are_given():
    record = SensorRecord(("range",), np.array([1.0]), np.array([1.0]), np.zeros((1, 1, 2)), np.ones((1, 1, 1)))
    seen = measurements({"dme": record}, ("dme",))
    for shared in (seen.z, seen.R):
        with pytest.raises(ValueError, match="read-only"):
            shared[0] = 1.0
