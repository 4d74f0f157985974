"""Routes against plane geometry and an integrated turn."""

import math

import numpy as np
import pytest

from autopilot.route import Leg, Route, pattern_route

G = 9.80665
BANK = math.radians(15.0)


def corner(turn, wind=(0.0, 0.0), time_to_roll=0.0, speed=70.0, course=0.3):
    """Two legs of 20 km that meet at the origin with a turn (rad, + right)."""
    before = (-20e3 * math.cos(course), -20e3 * math.sin(course))
    after = (20e3 * math.cos(course + turn), 20e3 * math.sin(course + turn))
    legs = (Leg(before, (0.0, 0.0), speed, 400.0), Leg((0.0, 0.0), after, speed, 400.0))
    return Route(legs, wind, time_to_roll)


def test_signs_of_a_point_right_of_a_leg_flying_away_from_it():
    route = Route((Leg((0.0, 0.0), (1000.0, 0.0), 70.0, 0.0),))
    deviation = route.deviation(0, (400.0, 50.0), (60.0, 5.0), 0.1)
    assert deviation.cross_track == pytest.approx(50.0)
    assert deviation.cross_track_rate == pytest.approx(5.0)
    assert deviation.distance_to_go == pytest.approx(600.0)
    assert deviation.bearing_error == pytest.approx(-math.atan2(50.0, 600.0))
    assert deviation.track_error == pytest.approx(math.atan2(5.0, 60.0))
    assert deviation.heading_error == pytest.approx(0.1)
    assert route.deviation(0, (400.0, 50.0), (60.0, 5.0)).heading_error == deviation.track_error


@pytest.mark.parametrize("course_deg", [-179.0, -90.0, 0.0, 45.0, 180.0])
def test_arrays_agree_with_floats(course_deg):
    route = corner(math.radians(70.0), course=math.radians(course_deg))
    rng = np.random.default_rng(1)
    north, east, rate_north, rate_east, heading = rng.normal(0.0, 1000.0, (5, 40))
    legs = rng.integers(0, 2, 40)
    batch = route.deviation(legs, (north, east), (rate_north, rate_east), heading)
    for i in range(40):
        single = route.deviation(
            int(legs[i]),
            (float(north[i]), float(east[i])),
            (float(rate_north[i]), float(rate_east[i])),
            float(heading[i]),
        )
        # one rounding of numbers of 1e4 m
        np.testing.assert_allclose([getattr(batch, name)[i] for name in single._fields], single, atol=1e-9)


@pytest.mark.parametrize("turn_deg", [5.0, -30.0, 90.0, -90.0, 150.0])
def test_calm_turn_is_the_textbook_rule(turn_deg):
    turn, speed = math.radians(turn_deg), 72.0
    radius = speed**2 / (G * math.tan(BANK))
    planned = corner(turn, time_to_roll=2.2).turn(0, speed, BANK)
    assert planned.entry == pytest.approx(radius * math.tan(abs(turn) / 2) + 2.2 * speed, rel=1e-12)
    assert planned.exit == pytest.approx(radius * math.tan(abs(turn) / 2), rel=1e-9)
    assert planned.duration == pytest.approx(abs(turn) * speed / (G * math.tan(BANK)), rel=1e-12)


@pytest.mark.parametrize("turn_deg", [40.0, -90.0, 90.0, 130.0])
@pytest.mark.parametrize("from_deg", range(0, 360, 45))
def test_turn_in_wind_ends_on_the_new_leg_of_an_integrated_path(turn_deg, from_deg):
    """Judge: point-mass kinematics at constant airspeed and bank, integrated from the entry for the planned time."""
    toward = math.radians(from_deg) + math.pi
    wind, speed = (20.0 * math.cos(toward), 20.0 * math.sin(toward)), 70.0
    turn = math.radians(turn_deg)
    route = corner(turn, wind)
    planned = route.turn(0, speed, BANK)
    course_1, course_2 = route.legs[0].course, route.legs[1].course

    def heading(course):
        return course - math.asin((wind[1] * math.cos(course) - wind[0] * math.sin(course)) / speed)

    rate = math.copysign(G * math.tan(BANK) / speed, turn)
    time = np.linspace(0.0, planned.duration, 20001)
    nose = heading(course_1) + rate * time
    north = -planned.entry * math.cos(course_1) + np.trapezoid(speed * np.cos(nose) + wind[0], time)
    east = -planned.entry * math.sin(course_1) + np.trapezoid(speed * np.sin(nose) + wind[1], time)
    end = route.deviation(1, (float(north), float(east)), (1.0, 0.0))
    assert math.remainder(nose[-1] - heading(course_2), math.tau) == pytest.approx(0.0, abs=1e-9)
    assert end.cross_track == pytest.approx(0.0, abs=1e-3)  # m: the trapezoid rule on a 2 km arc
    assert route.legs[1].length - end.distance_to_go == pytest.approx(planned.exit, abs=1e-3)


def test_leg_switches_at_the_entry_for_each_run_of_a_batch():
    route = corner(math.pi / 2, wind=(5.0, -8.0), time_to_roll=2.2)
    along = np.array(route.legs[0].direction)
    speed = route.ground_speed(0, 70.0)
    entry = route.turn(0, 70.0, BANK).entry
    to_go = np.array([entry + 300.0, entry + 1.0, entry - 1.0, -50.0])
    north, east = -to_go * along[0], -to_go * along[1]
    velocity = np.full(4, speed * along[0]), np.full(4, speed * along[1])
    batch = route.sequence(np.array([0, 0, 0, 1]), (north, east), velocity, BANK)
    assert batch.tolist() == [0, 0, 1, 1]
    singles = [
        route.sequence(leg, (float(north[i]), float(east[i])), (float(velocity[0][i]), float(velocity[1][i])), BANK)
        for i, leg in enumerate([0, 0, 0, 1])
    ]
    assert singles == [0, 0, 1, 1]


def test_a_batch_changes_legs_as_each_of_its_runs_does_alone():
    """Wild estimates too: far from the route, hardly moving, faster than sound, lost; one leg further at the most."""
    route = pattern_route("left", 400.0, 7000.0, 13800.0, 72.0, 69.0, 300.0, 1.4, wind=(4.0, -6.0))
    generator = np.random.default_rng(8)
    runs = 300
    leg = generator.integers(0, 3, runs)
    north, east = 15000.0 * generator.standard_normal((2, runs))
    velocity = generator.choice([3.0, 70.0, 700.0], runs) * generator.standard_normal((2, runs))
    north[-1] = np.nan
    batch = route.sequence(leg, (north, east), velocity, BANK)
    singles = [
        route.sequence(one, (n, e), v, BANK)
        for one, n, e, v in zip(leg.tolist(), north.tolist(), east.tolist(), velocity.T.tolist(), strict=True)
    ]
    assert batch.tolist() == singles
    assert set((batch - leg).tolist()) == {0, 1}


def test_mirrored_patterns_mirror_exactly():
    wind = (3.0, 7.0)
    left = pattern_route("left", 400.0, 7000.0, 13800.0, 72.0, 69.0, 300.0, 0.0, wind)
    right = pattern_route("right", 400.0, 7000.0, 13800.0, 72.0, 69.0, 300.0, 0.0, (wind[0], -wind[1]))
    rng = np.random.default_rng(2)
    for leg in range(3):
        if leg < 2:
            assert left.turn(leg, 72.0, BANK) == right.turn(leg, 72.0, BANK)
        for north, east, rate_north, rate_east in rng.normal(0.0, 5000.0, (20, 4)).tolist():
            one = left.deviation(leg, (north, east), (rate_north, rate_east))
            other = right.deviation(leg, (north, -east), (rate_north, -rate_east))
            assert one.cross_track == -other.cross_track
            assert one.cross_track_rate == -other.cross_track_rate
            assert one.distance_to_go == other.distance_to_go
            assert one.track_error == -other.track_error


def test_pattern_lies_left_of_the_approach_and_turns_left():
    route = pattern_route("left", 400.0, 7000.0, 13800.0, 72.0, 69.0, 300.0, math.radians(90.0))
    downwind, base, final = route.legs
    assert final.end == pytest.approx((0.0, 300.0), abs=1e-9)
    assert final.start == pytest.approx((0.0, -13500.0), abs=1e-9)
    assert downwind.end == pytest.approx((7000.0, -13500.0))  # north of an approach that flies east
    assert math.degrees(downwind.course) == pytest.approx(-90.0)
    assert math.remainder(math.degrees(base.course) - 180.0, 360.0) == pytest.approx(0.0)
    assert (downwind.speed, base.speed, final.speed) == (72.0, 72.0, 69.0)


def test_routes_too_tight_for_the_bank_name_the_leg():
    route = pattern_route("left", 400.0, 3000.0, 13800.0, 72.0, 69.0, 300.0, 0.0)
    with pytest.raises(ValueError, match=r"leg 1 \(after leg 0\) is 3000 m long"):
        route.check_turns(BANK)
    route.check_turns(math.radians(25.0))
    back = Route((Leg((0.0, 0.0), (9e3, 0.0), 70.0, 0.0), Leg((9e3, 0.0), (0.0, 0.0), 70.0, 0.0)))
    with pytest.raises(ValueError, match="turns straight back"):
        back.check_turns(BANK)


@pytest.mark.parametrize(
    ("legs", "wind", "words"),
    [
        ((), (0.0, 0.0), "at least one leg"),
        (
            (Leg((0.0, 0.0), (1e3, 0.0), 70.0, 0.0), Leg((2e3, 0.0), (3e3, 0.0), 70.0, 0.0)),
            (0.0, 0.0),
            "must start where",
        ),
        ((Leg((0.0, 0.0), (1e3, 0.0), 70.0, 0.0),), (80.0, 0.0), "not less than"),
    ],
)
def test_impossible_routes_are_refused(legs, wind, words):
    with pytest.raises(ValueError, match=words):
        Route(legs, wind)


def test_collinear_legs_need_no_turn():
    route = Route((Leg((0.0, 0.0), (1e3, 0.0), 70.0, 0.0), Leg((1e3, 0.0), (3e3, 0.0), 60.0, 0.0)), (5.0, 9.0))
    assert route.turn(0, 70.0, BANK) == (0.0, 0.0, 0.0)
