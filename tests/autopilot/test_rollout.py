"""The law of the roll-out on tyres made by formula."""

from __future__ import annotations

import math

import pytest

from aircraft.state import STANDARD_GRAVITY, AircraftState
from autopilot.rollout import Rollout

STEP = 1.0 / 30.0
STANDING = AircraftState(*(0.0 for _ in AircraftState._fields))
PUSH = 0.02 * STANDARD_GRAVITY  # m/s2 sideways at the main wheels, and the turn that it gives: a side wind


def law(wheelbase, **changes):
    """Nose wheel alone: no rudder, no brakes."""
    return Rollout(wheelbase, 0.0, math.radians(10.0), 0.0, 0.0, **changes)


def on_tyres(wheelbase, speed, across, course, push=0.0, nose_load=0.09, gyration=0.65, seconds=60.0):
    """(t, y) of a two-wheeled model with linear tyres at one speed, under the law; not the law's own equations.

    Side forces are minus 7.7 times load and slip angle of each wheel; the centre of gravity lies ``nose_load`` of the
    wheelbase ahead of the main wheels.
    """
    behind, ahead = nose_load * wheelbase, (1.0 - nose_load) * wheelbase
    pilot, cornering = law(wheelbase), 7.7 * STANDARD_GRAVITY
    y, heading, sideways, rate = across, course, 0.0, 0.0
    s, found = pilot.begin(STANDING), []
    for k in range(round(seconds / STEP)):
        track = heading + math.atan2(sideways, speed)
        state = STANDING._replace(
            time=k * STEP, velocity_north=speed * math.cos(track), velocity_east=speed * math.sin(track),
            heading=heading, yaw_rate=rate,
        )  # fmt: skip
        s, _, wheels = pilot.step(s, state, y, track, heading, STEP)
        steering = wheels.steering * pilot.steering_limit
        for _ in range(20):
            fore = -cornering * nose_load * ((sideways + ahead * rate) / speed - steering)
            aft = -cornering * (1.0 - nose_load) * (sideways - behind * rate) / speed
            sideways += (fore + aft + push - speed * rate) * STEP / 20
            rate += (ahead * fore - behind * aft + 0.1 * wheelbase * push) / (gyration * wheelbase) ** 2 * STEP / 20
            heading += rate * STEP / 20
            y += (speed * math.sin(heading) + sideways * math.cos(heading)) * STEP / 20
        found.append(y)
    return found


@pytest.mark.parametrize("wheelbase", [1.65, 7.85, 25.6])  # of a light single, the An-26, a B747
@pytest.mark.parametrize("speed", [60.0, 30.0, 8.0])
def test_it_comes_back_to_the_centreline_without_swinging(wheelbase, speed):
    path = on_tyres(wheelbase, speed, 4.0, 0.0)
    assert abs(path[-1]) < 0.1
    assert min(path) > -1.0  # a quarter of the offset: a loop with less than 45 deg of phase margin overshoots by more


@pytest.mark.parametrize("nose_load", [0.06, 0.15])
@pytest.mark.parametrize("gyration", [0.5, 0.8])
def test_it_needs_no_exact_geometry(nose_load, gyration):
    path = on_tyres(7.85, 40.0, 4.0, 0.0, nose_load=nose_load, gyration=gyration)
    assert abs(path[-1]) < 0.1
    assert min(path) > -1.6


def test_a_side_force_that_lasts_is_taken_out_by_the_sum():
    steady = on_tyres(7.85, 40.0, 0.0, 0.0, push=PUSH)
    assert max(map(abs, steady)) > 0.2  # it is felt
    assert abs(steady[-1] - steady[-60]) < 0.02  # and the aircraft runs parallel to the centreline
    assert abs(steady[-1]) < 3.0


def test_what_is_asked_stays_within_the_limits():
    pilot = law(7.85)
    for speed in (5.0, 30.0, 60.0):
        for across in (-20.0, 20.0):
            sharp = abs(pilot.curvature(speed, across, 0.0)) * speed**2
            assert sharp <= pilot.lateral_acceleration * (1 + 1e-12)
    towards = -math.radians(10.0)
    assert pilot.curvature(20.0, 60.0, towards) == pytest.approx(0.0)  # the intercept is as steep as it may be


def test_brakes_wait_for_the_nose_and_hold_their_deceleration():
    pilot, speed, s = law(7.85), 50.0, None
    felt = []
    for k in range(600):
        state = STANDING._replace(time=k * STEP, velocity_north=speed, elevator=0.3)
        s = pilot.begin(state) if s is None else s
        s, controls, wheels = pilot.step(s, state, 0.0, 0.0, 0.0, STEP)
        assert wheels.left_brake == wheels.right_brake
        assert controls.throttle == 0.0
        felt.append((state.time, wheels.left_brake, controls.elevator))
        speed -= (0.3 + 6.0 * wheels.left_brake) * STEP  # weaker brakes than the law reckons with
    assert max(brakes for time, brakes, _ in felt if time < 3.0) == 0.0
    assert all(elevator == 0.0 for time, _, elevator in felt if time > 3.1)
    assert 0.3 + 6.0 * felt[-1][1] == pytest.approx(pilot.deceleration, rel=0.01)


def test_a_tail_wheel_and_a_reversed_wheel_turn_the_other_way():
    state = STANDING._replace(velocity_north=20.0)

    def steering(wheelbase, limit):
        pilot = Rollout(wheelbase, 0.0, limit, 0.0, 0.0)
        return pilot.step(pilot.begin(state), state, 3.0, 0.0, 0.0, STEP)[2].steering

    nose = steering(5.0, 0.2)
    assert nose < 0.0  # it is right of the centreline
    assert steering(5.0, -0.2) == pytest.approx(-nose)
    assert steering(-5.0, 0.2) > 0.0
    assert steering(0.0, 0.0) == 0.0
