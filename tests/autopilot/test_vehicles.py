"""Every vehicle keeps the contract of the flight loop."""

import math

import pytest

from aircraft.state import Command
from aircraft.wind import steady_wind
from sim.flight.vehicles import (
    AirframeChoice,
    Configuration,
    Initial,
    JsbsimVehicle,
    PointMassVehicle,
    designed,
    designed_point_mass,
)

FLAPS = math.radians(15.0)


@pytest.fixture(scope="module")
def an26():
    choice, flown = AirframeChoice("an26", 20000.0), Configuration(FLAPS, 0.0, 66.0, 74.0)
    limits = {"bank_limit": math.radians(15.0), "roll_rate_limit": math.radians(5.0)}
    return JsbsimVehicle(designed(choice, [flown], speed=72.0, **limits, height=400.0), choice)


def vehicle(kind, an26):
    return an26 if kind == "jsbsim" else PointMassVehicle()


@pytest.mark.parametrize("kind", ["jsbsim", "point mass"])
@pytest.mark.parametrize("course_deg", [0.0, 200.0])
def test_steady_start_on_a_course_in_wind_stays_on_it(kind, course_deg, an26):
    flying = vehicle(kind, an26)
    course = math.radians(course_deg)
    body = flying.begin(
        Initial(10.0, -20.0, 400.0, course, 70.0, 0.0, FLAPS, 0.0), steady_wind(math.radians(70.0), 10.0)
    )
    start = flying.read(body)
    assert (start.north, start.east, start.height) == pytest.approx((10.0, -20.0, 400.0), abs=1e-6)
    hold = Command(0.0, 0.0, 400.0, 70.0, FLAPS, 0.0)
    for _ in range(300):
        body = flying.step(body, hold, 1 / 30)
    state = flying.read(body)
    assert state.time - start.time == pytest.approx(10.0)
    assert math.remainder(state.course - course, math.tau) == pytest.approx(0.0, abs=math.radians(0.05))
    assert state.height == pytest.approx(400.0, abs=0.5)
    assert state.airspeed == pytest.approx(70.0, abs=0.2)


@pytest.mark.parametrize("kind", ["jsbsim", "point mass"])
def test_commands_are_flown(kind, an26):
    flying = vehicle(kind, an26)
    body = flying.begin(Initial(0.0, 0.0, 400.0, 0.0, 70.0, 0.0, FLAPS, 0.0), None)
    bank, airspeed = 0.0, 70.0
    for _ in range(900):
        bank = min(bank + math.radians(5.0) / 30, math.radians(12.0))
        airspeed = min(airspeed + 0.5 / 30, 73.0)
        body = flying.step(body, Command(bank, 0.0, 400.0, airspeed, FLAPS, 0.0), 1 / 30)
    state = flying.read(body)
    assert math.degrees(state.bank) == pytest.approx(12.0, abs=0.2)
    assert state.airspeed == pytest.approx(73.0, abs=0.3)
    assert state.height == pytest.approx(400.0, abs=2.0)


def test_same_flight_twice_is_the_same_to_the_last_bit(an26):
    ends = []
    for _ in range(2):
        body = an26.begin(Initial(0.0, 0.0, 400.0, 0.0, 70.0, 0.0, FLAPS, 0.0), steady_wind(1.0, 8.0))
        for _ in range(200):
            body = an26.step(body, Command(0.2, 0.0, 400.0, 71.0, FLAPS, 0.0), 1 / 30)
        ends.append(an26.read(body))
    assert ends[0] == ends[1]


def test_law_of_the_point_mass_knows_its_lag():
    gains = designed_point_mass(72.0, math.radians(15.0), math.radians(5.0))
    assert gains.bank_bandwidth == pytest.approx(1.0 / PointMassVehicle().body.roll_lag)
    gains.law.check_convergence(72.0, turns=True)


def test_a_steady_bank_turns_the_path_by_what_the_linear_model_says():
    """A jet whose loops leave a quarter of a degree of sideslip in a turn: 4 % of g tan(bank) go missing."""
    speed, bank = 121.0, math.radians(15.0)
    choice, flown = AirframeChoice("A320"), Configuration(0.0, 0.0, 115.0, 127.0)
    limits = {"bank_limit": bank, "roll_rate_limit": math.radians(5.0)}
    gains = designed(choice, [flown], speed=speed, **limits, height=600.0)
    flying = JsbsimVehicle(gains, choice)
    body = flying.begin(Initial(0.0, 0.0, 600.0, 0.0, speed), None)
    commanded, courses = 0.0, []
    for step in range(1800):
        commanded = min(commanded + math.radians(5.0) / 30, bank)
        body = flying.step(body, Command(commanded, 0.0, 600.0, speed, 0.0, 0.0), 1 / 30)
        if step in (1199, 1799):
            courses.append(flying.read(body).course)
    state = flying.read(body)
    turned = (courses[1] - courses[0]) % math.tau / 20.0
    found = turned * state.airspeed / (9.80665 * math.tan(state.bank))
    assert found == pytest.approx(gains.turning, abs=0.003)  # the speed and the bank hunt by a part in a thousand
    assert gains.turning < 0.97
