"""Judges of the An-26: its geometry by closed forms, the independent An-24 set, published speeds, and Newton's trim."""

import math
import tomllib
from itertools import pairwise

import numpy as np
import pytest

from aircraft import handbook, model_files
from aircraft.airframe import load
from aircraft.data import RATES, data
from aircraft.linearise import linearise
from aircraft.minimum_speed import minimum_speed
from aircraft.model_files import ModelError
from aircraft.models.an26 import build
from aircraft.modes import flying_qualities, modes
from aircraft.properties import MASS
from aircraft.trim import trim


def test_the_committed_model_is_what_its_geometry_gives():
    assert (model_files.OWN_MODELS / "an26" / "an26.xml").read_text(encoding="utf-8") == build.build()


def test_every_starting_number_says_where_it_is_from():
    for name, fact in build.FACTS.items():
        assert fact.source.startswith(("public", "formula", "memory", "cross-check", "chosen")), name
    for source in dict(data("an26").sources).values():
        assert source.startswith(("public", "formula", "memory", "cross-check", "chosen"))


@pytest.mark.parametrize("path", sorted(model_files.OWN_MODELS.glob("*/*.toml")), ids=lambda path: path.stem)
def test_data_files_hold_no_gains(path):
    names = {field.lower() for field in _keys(tomllib.loads(path.read_text(encoding="utf-8")))}
    assert not {name for name in names if any(word in name for word in ("gain", "k1", "k2", "weight", "bandwidth"))}


def _keys(table):
    for key, value in table.items():
        yield key
        for inner in value if isinstance(value, list) else [value]:
            if isinstance(inner, dict):
                yield from _keys(inner)


CROSS_CHECK = {  # an independent set for the An-24 (same wing, smaller tail); read as a cross-check only
    "CLa": (5.1, 6.2),
    "CYb": (-0.72, -0.72),
    "Clb": (-0.072, -0.072),
    "Clp": (-0.50, -0.50),
    "Cnb": (0.103, 0.103),
    "Cnr": (-0.15, -0.15),
    "Clda": (0.15, 0.15),
    "Cndr": (-0.112, -0.112),
}


@pytest.mark.parametrize("name", CROSS_CHECK)
def test_derivatives_agree_with_the_an24_within_the_handbooks_accuracy(name):
    low, high = sorted(abs(value) for value in CROSS_CHECK[name])
    value = build.derivatives()[name]
    assert math.copysign(1.0, value) == math.copysign(1.0, CROSS_CHECK[name][0])
    assert low / 1.55 < abs(value) < high * 1.55  # strip theory and a bigger fin: at most 55 % away


@pytest.mark.parametrize(("name", "wanted"), [("CLa", 6.28), ("Cma", -1.63), ("Cmq", -45.0), ("Cmde", -2.2)])
def test_pitch_derivatives_agree_with_a_second_handbook_estimate(name, wanted):
    assert build.derivatives()[name] == pytest.approx(wanted, rel=0.2)


def test_closed_forms_at_their_limits():
    assert handbook.lift_curve_slope(1e9, 0.0, 0.0) == pytest.approx(2.0 * math.pi, rel=1e-6)  # thin aerofoil
    assert handbook.lift_curve_slope(1e-6, 0.0, 0.0) == pytest.approx(math.pi * 1e-6 / 2.0, rel=1e-6)  # slender wing
    assert handbook.flap_effectiveness(1.0, 1.0) == pytest.approx(1.0)  # all-moving surface
    assert handbook.flap_effectiveness(0.0, 1.0) == 0.0
    assert handbook.ground_effect_on_induced_drag(1e6) == pytest.approx(1.0)
    assert handbook.ground_effect_on_lift(1e6, 11.0) == pytest.approx(1.0)
    assert handbook.ground_effect_on_lift(0.1, 11.0) > 1.02
    # static thrust of an ideal propeller: T^3 = 2 rho A P^2
    area = math.pi / 4.0 * 3.9**2
    assert handbook.propeller_thrust(1e6, 0.0, 0.0, 3.9) == pytest.approx((2.0 * 1.225 * area * 1e12) ** (1 / 3))
    # at high speed the slipstream is slow: T V = P
    assert handbook.propeller_thrust(1e6, 300.0, 0.0, 3.9) * 300.0 == pytest.approx(1e6, rel=0.01)


@pytest.mark.parametrize(("speed", "wanted"), [(58.0, 24.5e3), (72.0, 21.5e3), (100.0, 16.9e3)])
def test_thrust_agrees_with_blade_elements(speed, wanted):
    power = 2660.0 * 745.7
    loss = build.propeller_loss(speed, power)
    assert handbook.propeller_thrust(power, speed, loss, 3.9) == pytest.approx(wanted, rel=0.05)


def test_load_over_the_span_at_its_limits():
    """Strip theory for a wing without end, the closed form of the damping for one with; two ailerons add up."""
    endless = 1e5
    assert math.pi * endless / 4.0 * handbook.rolling_load(endless, 1.0)[0] == pytest.approx(math.pi / 3.0, rel=0.005)
    strip = 2.0 * math.pi * (0.9**2 - 0.6**2) / 4.0
    assert handbook.aileron_power(endless, 1.0, 0.6, 0.9, 1.0) == pytest.approx(strip, rel=0.02)
    damping = math.pi * 11.4 / 4.0 * handbook.rolling_load(11.4, 0.31)[0]
    assert damping == pytest.approx(-handbook.roll_damping(11.4, 0.31), rel=0.02)
    inside, outside = (handbook.aileron_power(11.4, 0.31, *ends, 1.0) for ends in ((0.2, 0.6), (0.6, 0.98)))
    assert inside + outside == pytest.approx(handbook.aileron_power(11.4, 0.31, 0.2, 0.98, 1.0))


def test_full_aileron_rolls_it_as_a_transport():
    """Helix angle of the tip in steady roll: 0.07 was asked of transports, 0.09 of fighters [Perkins and Hage 1949]."""
    values = build.derivatives()
    assert 0.07 < values["Clda"] * build.fact("aileron_travel") / -values["Clp"] < 0.105


def test_the_flying_model_has_the_thrust_of_its_table():
    """Level acceleration at full and at idle power differ by the thrust of two propellers over the mass."""
    airframe = load("an26")
    steady = trim(airframe, 72.0, height=10.0, flaps=math.radians(15.0))
    force = []
    for throttle in (0.0, 1.0):
        state = airframe.begin(steady.initial._replace(controls=steady.controls._replace(throttle=throttle)))
        force.append(state.specific_force_forward * 20000.0)
    wanted = [
        2.0 * handbook.propeller_thrust(power, 72.0, build.propeller_loss(72.0, power), 3.9)
        for power in (200e3, 2103e3)
    ]
    assert force[1] - force[0] == pytest.approx(wanted[1] - wanted[0], rel=0.02)  # interpolated in a table of 14 powers


def test_stall_speeds_are_those_of_the_published_polar():
    facts = data("an26")
    for setting in facts.flap_settings:
        top = build.POLAR[round(math.degrees(setting.flaps), 1)][1]
        wanted = math.sqrt(2.0 * 20000.0 * 9.80665 / (1.225 * build.fact("area") * top))
        assert setting.stall_speed == pytest.approx(wanted, abs=0.06)
    assert facts.stall_speed(math.radians(38.0), 24000.0) == pytest.approx(45.2, abs=0.1)


def test_lift_is_smooth_up_to_the_published_maximum():
    slope = build.derivatives()["CLa"]
    for flaps, (at_zero, top, alpha_top) in build.POLAR.items():
        angles = np.radians(np.linspace(-5.0, 30.0, 3501))
        lift = np.array([build.lift_coefficient(angle, flaps, slope) for angle in angles])
        assert lift.max() == pytest.approx(top, abs=1e-6)
        assert math.degrees(angles[lift.argmax()]) == pytest.approx(alpha_top, abs=0.02)
        assert build.lift_coefficient(0.0, flaps, slope) == at_zero
        rising = np.diff(lift[: lift.argmax()])
        assert rising.min() > 0.0
        assert rising.max() < 1.001 * slope * (angles[1] - angles[0])
        assert np.diff(rising).max() < 1e-9  # the slope only falls
        beyond = build.lift_coefficient(math.radians(alpha_top + 10.0), flaps, slope)
        assert 0.6 * top < beyond < 0.9 * top


TRIMS = [
    # m/s, flaps deg, gear, path deg
    (72.0, 15.0, 0.0, 0.0),
    (69.0, 15.0, 0.0, 0.0),
    (58.0, 38.0, 1.0, 0.0),
    (58.0, 38.0, 1.0, -8.0 / 3.0),
    (58.0, 38.0, 1.0, -3.0),
]


@pytest.mark.parametrize(("airspeed", "flaps", "gear", "path"), TRIMS)
@pytest.mark.parametrize(("mass", "centre"), [(20000.0, 0.24), (24000.0, 0.15), (16500.0, 0.33)])
def test_it_trims_at_every_speed_of_the_schedule(airspeed, flaps, gear, path, mass, centre):
    airframe = load("an26", mass, centre)
    steady = trim(airframe, airspeed, math.radians(path), 600.0, math.radians(flaps), gear)
    assert steady.residual < 1e-6
    # lift = weight gives the angle of attack up to the tail's load and the thrust's lift, 3 deg together
    pressure = 0.5 * 1.225 * 0.9437 * airspeed**2
    lift = mass * 9.80665 * math.cos(math.radians(path)) / (pressure * build.fact("area"))
    alpha = (lift - build.POLAR[flaps][0]) / build.derivatives()["CLa"] - build.fact("incidence")
    assert steady.initial.angle_of_attack == pytest.approx(alpha, abs=math.radians(3.0))
    assert 0.0 < steady.controls.throttle < 1.0
    assert abs(steady.controls.elevator) < 0.5


@pytest.mark.parametrize(("airspeed", "flaps", "gear", "path"), TRIMS)
def test_it_flies_as_level_1_on_approach(airspeed, flaps, gear, path):
    airframe = load("an26")
    steady = trim(airframe, airspeed, math.radians(path), 300.0, math.radians(flaps), gear)
    verdicts = flying_qualities(linearise(airframe, steady))
    assert {verdict.level for verdict in verdicts} == {1}


def documented(heading):
    """Rows of numbers of one table of the model's README, up = 0 and down = 1."""
    text = (model_files.OWN_MODELS / "an26" / "README.md").read_text(encoding="utf-8").split(f"## {heading}\n")[1]
    rows = [line.strip("| \n").replace("up", "0").replace("down", "1") for line in text.splitlines() if "|" in line]
    last = next((i for i, row in enumerate(rows[2:], 2) if not row[0].isdigit()), len(rows))
    return [[float(number) for number in row.replace(",", "|").split("|")] for row in rows[2:last]]


def test_the_documented_trims_are_those_of_the_model():
    rows = documented("Trim")
    assert [tuple(row[:3]) for row in rows] == [entry[:3] for entry in TRIMS]
    airframe = load("an26")
    for airspeed, flaps, gear, path, alpha, power, elevator in rows:
        exact = {-2.67: -8.0 / 3.0}.get(path, path)
        steady = trim(airframe, airspeed, math.radians(exact), 600.0, math.radians(flaps), gear)
        kilowatts = (build.fact("idle_power") * (1.0 - steady.controls.throttle)) / 1e3
        kilowatts += build.fact("power") * steady.controls.throttle / 1e3
        assert math.degrees(steady.initial.angle_of_attack) == pytest.approx(alpha, abs=0.006)  # as printed
        assert kilowatts == pytest.approx(power, abs=0.6)
        assert math.degrees(steady.controls.elevator * build.fact("elevator_up")) == pytest.approx(elevator, abs=0.006)


def test_the_documented_modes_are_those_of_the_model():
    airframe = load("an26")
    for airspeed, flaps, *wanted in documented("Modes"):
        steady = trim(airframe, airspeed, 0.0, 600.0, math.radians(flaps), float(flaps > 15.0))
        phugoid, short, dutch, roll, spiral = modes(linearise(airframe, steady))
        found = [(mode.natural_frequency, mode.damping) for mode in (phugoid, short, dutch)]
        assert [*found[0], *found[1], *found[2]] == pytest.approx(wanted[:6], abs=0.006)
        assert (roll.time_constant, spiral.time_to_double) == pytest.approx(wanted[6:], abs=0.06)


def test_minimum_speed_is_near_the_published_one():
    """A build check, not a validation: the published polar shaped the lift table. 41 m/s at 20 t, flaps 38 deg."""
    found = minimum_speed(lambda: load("an26", 20000.0), math.radians(38.0))
    assert found.flown == pytest.approx(41.0, rel=0.03)
    assert found.trimmed == pytest.approx(41.0, rel=0.03)


def inertia(airframe):
    executive = airframe._executive
    return [executive[f"inertia/i{axis}{axis}-slugs_ft2"] * 1.3558179483 for axis in "xyz"]


def test_mass_and_centre_of_gravity_are_what_was_asked():
    light, heavy = load("an26", 18000.0, 0.20), load("an26", 24000.0, 0.30)
    assert light.mass == pytest.approx(18000.0, rel=1e-7)  # JSBSim's pounds
    assert heavy.mass == pytest.approx(24000.0, rel=1e-7)
    for airframe, centre in ((light, 0.20), (heavy, 0.30)):
        assert airframe._executive["inertia/cg-x-in"] * 0.0254 == pytest.approx(8.97 + centre * 2.813, abs=1e-6)
    assert np.array(inertia(heavy)) / np.array(inertia(light)) == pytest.approx([24.0 / 18.0] * 3, rel=1e-6)
    # Raymer's radii at 20 t
    assert inertia(load("an26")) == pytest.approx([2.46e5, 3.27e5, 5.34e5], rel=0.01)


def test_a_stock_aircraft_takes_a_mass_around_its_fuel():
    assert load("c172x", 1000.0).mass == pytest.approx(1000.0, rel=1e-6)
    assert MASS.factor == pytest.approx(14.5939, rel=1e-5)
    with pytest.raises(ModelError, match="fuel and fixed loads"):
        load("c172x", 50.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"mass": -1.0}, "between 16000 and 24000 kg"),
        ({"mass": 30000.0}, "between 16000 and 24000 kg"),
        ({"mass": math.nan}, "between 16000 and 24000 kg"),
        ({"centre_of_gravity_mac": 0.9}, "between 0.15 and 0.33"),
        ({"factors": {"lift": 1.0}}, "no factor 'lift'"),
        ({"factors": {"drag": -1.0}}, "between 0 and 100"),
    ],
)
def test_an_impossible_loading_gets_one_sentence(arguments, message):
    with pytest.raises(ModelError, match=message):
        load("an26", **arguments)


def test_a_stock_aircraft_without_a_chord_keeps_its_centre_of_gravity():
    with pytest.raises(ModelError, match="no mean aerodynamic chord"):
        load("c172x", centre_of_gravity_mac=0.25)


FACTOR_EFFECTS = {  # factor: the entry of the linear model that it must scale, (state, state or input)
    "lift_slope": ("angle_of_attack", "angle_of_attack"),
    "pitch_stiffness": ("pitch_rate", "angle_of_attack"),
    "pitch_damping": ("pitch_rate", "pitch_rate"),
    "yaw_stiffness": ("yaw_rate", "sideslip"),
    "yaw_damping": ("yaw_rate", "yaw_rate"),
    "dihedral": ("roll_rate", "sideslip"),
    "roll_damping": ("roll_rate", "roll_rate"),
    "elevator_power": ("pitch_rate", "elevator"),
    "aileron_power": ("roll_rate", "aileron"),
    "rudder_power": ("yaw_rate", "rudder"),
}


def entry(row, column, **factors):
    airframe = load("an26", factors=factors)
    linear = linearise(airframe, trim(airframe, 72.0, flaps=math.radians(15.0)))
    values, columns = (linear.B, linear.inputs) if column in linear.inputs else (linear.A, linear.states)
    return values[linear.states.index(row), columns.index(column)]


@pytest.mark.parametrize("name", FACTOR_EFFECTS)
def test_a_factor_scales_its_derivative(name):
    row, column = FACTOR_EFFECTS[name]
    ratio = entry(row, column, **{name: 1.2}) / entry(row, column)
    assert ratio == pytest.approx(1.2, abs=0.06)  # next to the scaled term stand drag, arms and rates: 6 % of it


def test_the_factor_of_drag_takes_power():
    def power(**factors):
        return trim(load("an26", factors=factors), 72.0, flaps=math.radians(15.0)).controls.throttle

    assert power(drag=1.2) > power() + 0.03
    assert set(data("an26").factors) == {*FACTOR_EFFECTS, "drag"}


def test_placards_and_settings_go_together():
    settings = data("an26").flap_settings
    assert [round(math.degrees(setting.flaps)) for setting in settings] == [0, 15, 38]
    for slower, faster in pairwise(reversed(settings)):
        assert slower.placard_speed < faster.placard_speed
        assert slower.stall_speed < faster.stall_speed


def test_data_of_an_unknown_key_or_unit_are_refused(tmp_path):
    home = tmp_path / "mine"
    home.mkdir()
    (home / "mine.xml").write_text((model_files.OWN_MODELS / "an26" / "an26.xml").read_text())
    for text, message in (("title='x'\nspan_m=1.0", "span_m"), ("mass_max_m=1.0", "mass_max_m"), ("a=[", "cannot be")):
        (home / "mine.toml").write_text(text)
        with pytest.raises(ModelError, match=message):
            data(home)
    (home / "mine.toml").write_text('title = "Mine"\nwheel_track_ft = 10.0')
    mine = data(home)
    assert (mine.title, mine.wheel_track) == ("Mine", pytest.approx(3.048))
    # what the file leaves out is read from the model
    assert (mine.reference_mass, mine.height_of_wheels) == pytest.approx((20000.0, 2.45))


def positions(controls_change, name, seconds=1.0, rate=120.0):
    """Position of a surface, rad, at ``rate`` Hz after a step of its command from the trim."""
    airframe = load("an26")
    steady = trim(airframe, 72.0, flaps=math.radians(15.0))
    airframe = load("an26", rate=rate)
    airframe.begin(steady.initial)
    found = [airframe._executive[f"fcs/{name}-pos-rad"]]
    for _ in range(round(rate * seconds)):
        airframe.step(steady.controls._replace(**controls_change), 1)
        found.append(airframe._executive[f"fcs/{name}-pos-rad"])
    return np.array(found)


@pytest.mark.parametrize(
    ("name", "command", "stop"),
    [
        ("elevator", 1.0, -build.fact("elevator_up")),
        ("elevator", -1.0, build.fact("elevator_down")),
        ("aileron", 1.0, build.fact("aileron_travel")),
        ("rudder", 1.0, -build.fact("rudder_travel")),
    ],
)
def test_surfaces_run_at_their_rate_to_their_stop(name, command, stop):
    angles = positions({name: command}, name)
    assert angles[-1] == pytest.approx(stop, abs=1e-3)
    assert np.abs(np.diff(angles)).max() * 120.0 == pytest.approx(build.fact("actuator_rate"), rel=0.01)


@pytest.mark.parametrize("rate", RATES)
def test_a_small_command_is_followed_with_the_actuators_bandwidth(rate):
    """At every rate: an actuator that was loaded for another one would be as much too quick or too slow."""
    before = positions({}, "aileron", 0.1, rate)[-1]
    angles = positions({"aileron": 0.02}, "aileron", 0.5, rate) - before
    final = 0.02 * build.fact("aileron_travel")
    lag = 1.0 / build.fact("actuator_bandwidth")
    reached = np.interp(1.0 - math.exp(-1.0), angles / final, np.arange(len(angles)) / rate)
    assert reached == pytest.approx(lag, abs=1.5 / rate)  # a discrete lag, one step of delay


def test_the_ground_lifts_and_takes_induced_drag():
    airframe = load("an26")
    steady = trim(airframe, 58.0, height=300.0, flaps=math.radians(38.0), gear=1.0)
    far = airframe.begin(steady.initial)
    near = airframe.begin(steady.initial._replace(height=3.0))
    (drag_far, _, lift_far), (drag_near, _, lift_near) = far.load_factor, near.load_factor
    above = (3.0 + build.fact("wing_height")) / build.fact("span")
    aspect_ratio = build.fact("span") ** 2 / build.fact("area")
    density = 1.0 + 297.0 * 9.6e-5  # per metre near sea level
    more_lift = handbook.ground_effect_on_lift(above, aspect_ratio)
    assert lift_near / lift_far == pytest.approx(more_lift * density, rel=0.01)
    slope = build.derivatives()["CLa"]
    alpha = steady.initial.angle_of_attack + build.fact("incidence")
    lift = build.lift_coefficient(alpha, 38.0, slope)
    induced = handbook.induced_drag_factor(aspect_ratio, build.fact("oswald")) * lift**2
    left = handbook.ground_effect_on_induced_drag(above)
    # drag balanced the thrust far from the ground; near it the density raises both
    spared = density * (induced - induced * left * more_lift**2)
    assert drag_near - drag_far == pytest.approx(spared / lift * lift_far, rel=0.05)


def test_beyond_the_stall_lift_falls_and_drag_grows():
    airframe = load("an26")
    steady = trim(airframe, 58.0, height=300.0, flaps=math.radians(38.0), gear=1.0)
    found = []
    for alpha in (13.0, 20.0):  # of the body: the top is at 16 deg of the wing
        state = airframe.begin(steady.initial._replace(angle_of_attack=math.radians(alpha), pitch=math.radians(alpha)))
        found.append(state.load_factor)
    assert found[1][2] < 0.97 * found[0][2]
    assert found[1][0] < found[0][0] - 0.05


@pytest.mark.parametrize("sink", [0.5, 3.05])
def test_a_touchdown_comes_to_rest_on_its_wheels(sink):
    airframe = load("an26")
    path = -math.asin(sink / 55.0)
    steady = trim(airframe, 55.0, path, 20.0, math.radians(38.0), 1.0)
    airframe = load("an26")
    # both main wheels first: 2 deg nose up, as after a flare
    start = steady.at(0.0, 0.0, 3.2, 0.0)._replace(
        pitch=math.radians(2.0), angle_of_attack=math.radians(2.0) - path, airspeed=52.0
    )
    airframe.begin(start)
    loads = []
    for _ in range(30 * 25):
        airframe.step(start.controls._replace(throttle=0.0, elevator=-0.05), 4)
        state = airframe.read()
        loads.append(state.load_factor[2])
    assert state.main_wheels == 1.0
    assert abs(state.velocity_up) < 0.02
    assert abs(state.bank) < 1e-6
    assert max(loads) < 3.0  # well within what struts of the design sink rate bring
