import math
import pickle

import numpy as np
import pytest

from aircraft import loading, model_files
from aircraft.airframe import EARTH_RADIUS, FlightError, InitialCondition, Runway, load
from aircraft.landing_gear import contacts
from aircraft.state import MAIN_WHEEL, NOSE_WHEEL, STANDARD_GRAVITY, TAIL, WING_TIP, Controls
from aircraft.wind import SteadyWind


def fly(model, start, seconds, wind=(0.0, 0.0, 0.0), **loading):
    airframe = load(model, **loading)
    record = [airframe.begin(start, wind)]
    for _ in range(round(seconds * 30)):
        airframe.step(start.controls, 4)
        record.append(airframe.read())
    return record


@pytest.mark.parametrize("model", ["an26", "c172x"])
def test_fresh_flights_are_bitwise_equal(steady, model):
    start = steady(model, {"an26": 72.0, "c172x": 33.4}[model], gear=1.0).at(0.0, 0.0, 500.0, 1.0)
    assert fly(model, start, 10.0) == fly(model, start, 10.0)


@pytest.mark.parametrize("heading", [0.0, math.pi / 2.0])
def test_nothing_turns_a_symmetric_aircraft_on_a_non_rotating_earth(steady, heading):
    start = steady("an26", 72.0, flaps_deg=15.0).at(0.0, 0.0, 400.0, heading)  # along great circles
    end = fly("an26", start, 60.0)[-1]
    assert abs(end.bank) < 1e-9
    assert abs(math.remainder(end.heading - heading, 2.0 * math.pi)) < 1e-9
    assert abs(end.airspeed - 72.0) < 0.01
    assert abs(end.height - 400.0) < 1.0


@pytest.mark.parametrize("wind", [(10.0, 0.0, 0.0), (-10.0, 0.0, 0.0), (0.0, 10.0, 0.0), (3.0, -8.0, 0.0)])
def test_a_trimmed_start_in_wind_stays_trimmed(steady, wind):
    start = steady("an26", 58.0, -2.667, 38.0, 1.0, height=300.0).at(0.0, 0.0, 300.0, 0.4)
    record = fly("an26", start, 10.0, wind)
    for state in record:
        assert state.airspeed == pytest.approx(58.0, abs=0.1)  # density grows by 0.2 % over the descent
        assert abs(state.bank) < 1e-4
        assert abs(state.sideslip) < 1e-4
    first = record[0]
    north, east, _ = first.air_velocity
    assert first.velocity_north - north == pytest.approx(wind[0], abs=1e-9)
    assert first.velocity_east - east == pytest.approx(wind[1], abs=1e-9)


def test_a_wind_that_is_told_at_every_step_is_the_wind_of_the_start(steady):
    start = steady("an26", 72.0).at(0.0, 0.0, 400.0, 0.4)
    wind = SteadyWind(4.0, -7.0, 0.0)

    class Asked:
        def velocity(self, time, position, airspeed):
            return wind

    told = []
    for blowing in (None, wind, Asked()):
        airframe = load("an26")
        airframe.begin(start, wind)
        for _ in range(60):
            airframe.step(start.controls, 4, blowing)
        told.append(airframe.read())
    assert told[0] == pytest.approx(told[1], abs=1e-9)
    assert told[0] == pytest.approx(told[2], abs=1e-9)


def test_a_changing_wind_sees_the_time_of_every_step(steady):
    start = steady("an26", 72.0).at(0.0, 0.0, 400.0, 0.4)
    asked = []

    class Asked:
        def velocity(self, time, position, airspeed):
            asked.append((time, position, airspeed))
            return 0.0, 0.0, 0.0

    airframe = load("an26", runway=Runway(elevation=200.0))
    airframe.begin(start)
    for _ in range(2):
        airframe.step(start.controls, 4, Asked())
    assert [time for time, _, _ in asked] == pytest.approx([step / 120 for step in range(8)], abs=1e-12)
    assert asked[0][1] == pytest.approx((0.0, 0.0, 400.0), abs=1e-6)
    assert asked[0][2] == pytest.approx(72.0)


def test_an_up_draught_lifts_and_raises_the_angle_of_attack(steady):
    start = steady("an26", 72.0).at(0.0, 0.0, 400.0, 0.0)
    airframe = load("an26")
    before = airframe.begin(start)
    airframe.step(start.controls, 2, SteadyWind(0.0, 0.0, 3.0))
    after = airframe.read()
    assert after.angle_of_attack - before.angle_of_attack == pytest.approx(3.0 / 72.0, rel=0.1)
    assert after.load_factor[2] > before.load_factor[2] + 0.1


def test_runway_elevation_moves_the_ground_and_not_the_height(steady):
    start = steady("an26", 72.0).at(100.0, -200.0, 300.0, 0.0)
    for elevation in (0.0, 800.0):
        airframe = load("an26", runway=Runway(elevation=elevation))
        state = airframe.begin(start)
        assert (state.north, state.east, state.height) == pytest.approx((100.0, -200.0, 300.0), abs=1e-6)
        assert airframe._executive["position/h-agl-ft"] * 0.3048 == pytest.approx(300.0, abs=1e-6)


def test_geodetic_position_agrees_with_the_wgs84_degree():
    # a degree of latitude is 111.132 km and one of longitude 78.847 km at 45 deg (WGS 84 tables)
    runway = Runway(latitude=math.radians(45.0), longitude=math.radians(30.0))
    # meridians converge: each way is measured alone, in the plane that touches the earth at the threshold
    assert np.degrees(runway.geodetic(1111.32, 0.0)) == pytest.approx((45.01, 30.0), abs=1e-6)
    assert np.degrees(runway.geodetic(0.0, 788.47)) == pytest.approx((45.0, 30.01), abs=1e-6)


@pytest.mark.parametrize("height", [50.0, 2000.0])
def test_gravity_is_standard_and_falls_with_height(steady, height):
    """In steady level flight the load factor is gravity over the standard one, less the curvature of the path."""
    state = load("an26").begin(steady("an26", 80.0, height=height).at(0.0, 0.0, height, 0.5))
    radius = EARTH_RADIUS + height
    gravity = STANDARD_GRAVITY * (EARTH_RADIUS / radius) ** 2
    # the trim holds the velocity in body axes, which turn with the horizon or not: either way within V^2 / R
    assert state.load_factor[2] * STANDARD_GRAVITY == pytest.approx(gravity, abs=80.0**2 / radius)


def test_fuel_does_not_burn(steady):
    start = steady("c172x", 33.4).at(0.0, 0.0, 500.0, 0.0)
    airframe = load("c172x")
    airframe.begin(start)
    before = airframe.mass
    airframe.step(start.controls, 1200)
    assert airframe.mass == before


def test_the_sphere_is_metric_around_the_threshold():
    assert 1.0 - math.cos(15000.0 / EARTH_RADIUS) < 3e-6


def test_wheels_carry_the_aircraft_at_rest(steady):
    start = steady("an26", 58.0, flaps_deg=38.0, gear=1.0)
    airframe = load("an26")
    standing = start.at(0.0, 0.0, 2.45, 0.0)._replace(
        airspeed=1.0, pitch=0.0, angle_of_attack=0.0, controls=Controls(0.0, 0.0, 0.0, 0.06, 0.0, 1.0)
    )
    airframe.begin(standing)
    for _ in range(300):
        airframe.step(standing.controls, 4)
    state = airframe.read()
    assert state.main_wheels == 1.0
    assert abs(state.velocity_up) < 1e-3
    assert 2.2 < state.height < 2.45
    assert abs(state.pitch) < math.radians(1.0)


def test_main_wheels_are_off_the_ground_in_the_air(steady):
    for model, airspeed in (("an26", 72.0), ("737", 90.0)):
        start = steady(model, airspeed)
        assert load(model).begin(start.at(0.0, 0.0, 500.0, 0.0)).main_wheels == 0.0


def test_flaps_and_gear_travel_in_their_time(steady):
    start = steady("an26", 65.0).at(0.0, 0.0, 500.0, 0.0)
    airframe = load("an26")
    airframe.begin(start)
    wanted = start.controls._replace(flaps=math.radians(38.0), gear=1.0)
    for _ in range(30 * 16):
        airframe.step(wanted, 4)
        state = airframe.read()
        if state.time < 14.9:
            assert state.flaps < math.radians(38.0)
    assert state.flaps == pytest.approx(math.radians(38.0))
    assert state.gear == 1.0


def test_power_follows_the_lever_with_its_lag(steady):
    start = steady("an26", 72.0).at(0.0, 0.0, 500.0, 0.0)
    airframe = load("an26")
    airframe.begin(start)
    power = airframe._executive["fcs/power-kw[0]"]
    demand = 200.0 + 1903.0
    for _ in range(24):  # 0.8 s, the time constant
        airframe.step(start.controls._replace(throttle=1.0), 4)
    now = airframe._executive["fcs/power-kw[0]"]
    # one 120 Hz step of delay shifts an exponential of 0.8 s by 1 %
    assert (now - power) / (demand - power) == pytest.approx(1.0 - math.exp(-1.0), abs=0.01)


def test_a_flight_that_is_not_finite_carries_its_last_state(steady):
    start = steady("an26", 72.0).at(0.0, 0.0, 500.0, 0.0)
    airframe = load("an26")
    airframe.begin(start)
    airframe.step(start.controls, 4)
    good = airframe.read()
    airframe.step(start.controls._replace(elevator=math.nan), 4)
    with pytest.raises(FlightError, match="not finite") as caught:
        airframe.read()
    assert caught.value.state == good
    travelled = pickle.loads(pickle.dumps(caught.value))  # from a worker to its parent
    assert (str(travelled), travelled.time, travelled.state) == (str(caught.value), caught.value.time, good)
    assert caught.value.time == pytest.approx(8 / 120)


def test_an_airframe_flies_once_and_begins_above_the_ground(steady):
    start = steady("an26", 72.0).at(0.0, 0.0, 500.0, 0.0)
    airframe = load("an26")
    with pytest.raises(FlightError, match="50 m below the runway"):
        airframe.begin(start._replace(height=-50.0))
    with pytest.raises(FlightError, match="finite"):
        airframe.begin(start._replace(airspeed=math.nan))
    airframe.begin(start)
    airframe.step(start.controls, 4)
    with pytest.raises(FlightError, match="flies once"):
        airframe.begin(start)


def test_a_read_on_the_way_changes_nothing(steady):
    start = steady("an26", 72.0).at(0.0, 0.0, 500.0, 0.3)
    ends = []
    for substeps in (1, 4, 12):
        airframe = load("an26")
        airframe.begin(start)
        for _ in range(120 // substeps):
            airframe.step(start.controls._replace(aileron=0.05), substeps)
            airframe.read()
        ends.append(airframe.read())
    assert ends[0] == ends[1] == ends[2]
    assert np.isfinite(ends[0]).all()


@pytest.mark.parametrize(
    ("pitch_deg", "bank_deg", "first"),
    [
        (3.0, 0.0, MAIN_WHEEL),
        (-3.0, 0.0, NOSE_WHEEL),
        (12.0, 0.0, TAIL),
        (0.0, 25.0, WING_TIP),
    ],
)
def test_what_touches_first_is_told_by_the_attitude(pitch_deg, bank_deg, first):
    """Dropped by 5 cm, nearly standing: the part that the geometry has lowest, in one step of the motion."""
    pitch, bank = math.radians(pitch_deg), math.radians(bank_deg)
    source = model_files.read("an26")
    aft, up = loading.centre_of_gravity(source)
    depth = max(
        (point.x - aft) * math.sin(pitch)
        + (point.y * math.sin(bank) - (point.z - up) * math.cos(bank)) * math.cos(pitch)
        for _, _, point in contacts(source)
    )
    airframe = load("an26")
    controls = Controls(0.0, 0.0, 0.0, 0.0, math.radians(38.0), 1.0)
    state = airframe.begin(InitialCondition(0.0, 0.0, depth + 0.05, 0.0, pitch, bank, 5.0, pitch, 0.0, controls))
    steps = 0
    while not state.first_contact:
        steps += 1
        assert steps < 30
        airframe.step(controls, 1)
        state = airframe.read()
    assert steps > 5  # 5 cm of free fall take 0.1 s
    assert state.first_contact == state.touched == first


def test_the_order_of_contacts_is_kept_through_a_long_step():
    """Nose and main wheels all down within one step of the loop: the nose wheel was first."""
    airframe = load("an26")
    controls = Controls(0.0, 0.0, 0.0, 0.0, math.radians(38.0), 1.0)
    state = airframe.begin(InitialCondition(0.0, 0.0, 2.9, 0.0, math.radians(-1.0), 0.0, 5.0, 0.0, 0.0, controls))
    airframe.step(controls, 120)
    state = airframe.read()
    assert state.first_contact == NOSE_WHEEL
    assert state.touched == NOSE_WHEEL + MAIN_WHEEL


def test_contacts_far_from_the_ground_cost_nothing_and_change_nothing(steady, monkeypatch):
    """The same bytes in the air, and a belly landing that is felt: the contacts are back before anything can touch."""
    start = steady("an26", 62.0, flaps_deg=15.0).at(0.0, 0.0, 70.0, 0.3)
    records = {}
    for name, reach in (("left_out", None), ("always", math.inf)):
        airframe = load("an26")
        if reach is not None:
            airframe._reach = reach
        state, record, looked = airframe.begin(start), [], []
        while state.time < 12.0:
            airframe.step(start.controls._replace(elevator=-0.1, throttle=0.0), 4)
            state = airframe.read()
            record.append(state)
            looked.append((state.height, airframe._executive["simulation/models/FGGroundReactions/enabled"]))
        records[name] = record
    assert looked[0][1] == 1.0  # always
    assert records["left_out"] == records["always"]
    assert min(state.height for state in record) < 3.0
    assert min(state.specific_force_down for state in record) < -1.5  # it hit the ground, on its belly: the gear is up


def test_contacts_are_left_out_in_the_air_only(steady):
    start = steady("an26", 62.0, flaps_deg=15.0).at(0.0, 0.0, 70.0, 0.3)
    airframe = load("an26")
    state, looked = airframe.begin(start), []
    while state.height > 20.0:
        airframe.step(start.controls._replace(elevator=-0.1, throttle=0.0), 4)
        state = airframe.read()
        looked.append((state.height, airframe._executive["simulation/models/FGGroundReactions/enabled"]))
    assert all(on == 0.0 for height, on in looked if height > 40.0)
    assert all(on == 1.0 for height, on in looked if height < 25.0)


def test_one_long_step_to_the_ground_finds_it(steady):
    start = steady("an26", 62.0, flaps_deg=15.0).at(0.0, 0.0, 70.0, 0.3)
    airframe = load("an26")
    airframe.begin(start)
    airframe.step(start.controls._replace(elevator=-0.1, throttle=0.0), 1440)
    assert airframe.read().height > -1.0  # the ground carries it
