"""Packets for FlightGear against the structure as it is documented, unpacked by hand, and motion worked out by hand."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest

from sim.interchange.views.flightgear import PACKET, Motion, packets

# version, padding | longitude, latitude, altitude | agl ... slip | engines | tanks | wheels | time | surfaces
LAYOUT = ">II" + "3d" + "6f" + "3f" + "2f" + "3f3f3f" + "2f" + "I4I36f" + "I4f" + "I3I9f" + "Iif" + "10f"
FOOT, KNOT = 0.3048, 1852 / 3600


def motion(**changes):
    """One instant in level flight to the east."""
    own = {
        "latitude": [0.9], "longitude": [-1.2], "altitude": [500.0], "above_ground": [380.0],
        "attitude": [[0.0], [0.0], [math.pi / 2]], "body_rates": [[0.0], [0.0], [0.0]], "air": [[0.05], [-0.02]],
        "velocity": [[0.0], [70.0], [0.0]], "calibrated_airspeed": [72.0],
        "specific_force": [[0.1], [0.2], [-9.8]], "controls": [[0.3], [0.2], [-0.1]], "flaps": [0.5], "gear": [1.0],
        "on_ground": [False], "stamp": [1767225600.0],
    }  # fmt: skip
    return Motion(**{name: np.array(value) for name, value in (own | changes).items()})


def unpacked(told):
    """The one packet by the names of its fields."""
    (packet,) = packets(told)
    assert len(packet.tobytes()) == struct.calcsize(LAYOUT) == 408
    values = iter(struct.unpack(LAYOUT, packet.tobytes()))
    sizes = {name: max(1, math.prod(PACKET[name].shape)) for name in PACKET.names}
    found = {name: [next(values) for _ in range(size)] for name, size in sizes.items()}
    assert next(values, None) is None
    return {name: value[0] if len(value) == 1 else value for name, value in found.items()}


def test_a_packet_has_every_value_where_the_structure_has_it_in_its_unit():
    found = unpacked(motion())
    assert (found["version"], found["padding"]) == (24, 0)
    assert (found["longitude"], found["latitude"], found["altitude"]) == (-1.2, 0.9, 500.0)
    expected = {
        "agl": 380.0, "phi": 0.0, "theta": 0.0, "psi": math.pi / 2, "alpha": 0.05, "beta": -0.02,
        "vcas": 72.0 / KNOT, "climb_rate": 0.0, "v_north": 0.0, "v_east": 70.0 / FOOT, "v_down": 0.0,
        "v_body_u": 70.0 / FOOT, "v_body_v": 0.0, "v_body_w": 0.0,
        "A_X_pilot": 0.1 / FOOT, "A_Y_pilot": 0.2 / FOOT, "A_Z_pilot": -9.8 / FOOT,
        "left_flap": 0.5, "right_flap": 0.5, "elevator": -0.2, "left_aileron": 0.3, "right_aileron": -0.3,
        "rudder": -0.1, "speedbrake": 0.0, "spoilers": 0.0,
    }  # fmt: skip
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=2e-7, abs=3e-5), name
    assert (found["num_engines"], found["num_tanks"], found["num_wheels"]) == (0, 0, 3)
    assert (found["gear_pos"], found["wow"]) == ([1.0, 1.0, 1.0], [0, 0, 0])
    assert (found["cur_time"], found["warp"]) == (1767225600, 0)


def test_a_climbing_turn_by_hand():
    """Heading north, pitched up 30 deg, banked 90 deg right: its right wing points down along the local vertical."""
    found = unpacked(
        motion(
            attitude=[[math.pi / 2], [math.pi / 6], [0.0]],
            body_rates=[[0.1], [0.2], [0.3]],
            velocity=[[60.0], [0.0], [20.0]],
        )
    )
    root = math.sqrt(3.0)
    assert found["climb_rate"] == pytest.approx(20.0 / FOOT)
    assert found["v_down"] == pytest.approx(-20.0 / FOOT)
    # along the nose; across it upwards, which is to the left here; nothing to the east, where its belly does not look
    assert found["v_body_u"] == pytest.approx((30.0 * root + 10.0) / FOOT)
    assert found["v_body_v"] == pytest.approx((30.0 - 10.0 * root) / FOOT, rel=1e-5)
    assert found["v_body_w"] == pytest.approx(0.0, abs=1e-4)
    # with the wing down, pitching turns the nose over the ground and yawing lowers it
    assert found["psidot"] == pytest.approx(0.2 / math.cos(math.pi / 6), rel=1e-6)
    assert found["thetadot"] == pytest.approx(-0.3, rel=1e-6)
    assert found["phidot"] == pytest.approx(0.1 + 0.2 * math.tan(math.pi / 6), rel=1e-6)


def test_the_velocity_keeps_its_length_in_body_axes():
    rng = np.random.default_rng(1)
    told = motion(attitude=rng.uniform(-1.0, 1.0, (3, 1)), velocity=rng.uniform(-80.0, 80.0, (3, 1)))
    found = unpacked(told)
    length = math.hypot(*(found[f"v_body_{axis}"] for axis in "uvw"))
    assert length * FOOT == pytest.approx(np.linalg.norm(told.velocity), rel=1e-6)


def test_what_is_not_known_is_sent_as_nothing():
    nan = [[math.nan]] * 3
    found = unpacked(motion(attitude=nan, body_rates=nan, calibrated_airspeed=[math.nan], flaps=[math.nan]))
    assert (found["phi"], found["psi"], found["vcas"], found["left_flap"], found["v_body_u"]) == (0.0,) * 5


def test_the_main_wheels_say_when_they_are_on_the_ground():
    assert unpacked(motion(on_ground=[True]))["wow"] == [0, 1, 1]
