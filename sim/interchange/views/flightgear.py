"""Packets from which a FlightGear shows an aircraft that is flown elsewhere: its native FDM protocol, version 24.

One packet is one instant: 408 bytes in network order, the structure ``FGNetFDM`` [FlightGear, src/Network/net_fdm.hxx;
JSBSim, src/input_output/net_fdm.hxx]. FlightGear takes no packet of another version than its own.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from aircraft.units import SUFFIXES

VERSION = 24
ENGINES, TANKS, WHEELS = 4, 4, 3  # for which the structure has room
FOOT, KNOT = SUFFIXES["ft"][1], SUFFIXES["kt"][1]
VISIBILITY = 20_000.0  # m; a FlightGear has weather of its own and does not use it

REAL, WHOLE = ">f4", ">u4"
PACKET = np.dtype(
    [
        *((name, WHOLE) for name in ("version", "padding")),
        *((name, ">f8") for name in ("longitude", "latitude", "altitude")),  # rad, rad on WGS 84, m above the sea
        *((name, REAL) for name in ("agl", "phi", "theta", "psi", "alpha", "beta")),  # m above ground; rad
        *((name, REAL) for name in ("phidot", "thetadot", "psidot")),  # rad/s, of the Euler angles
        *((name, REAL) for name in ("vcas", "climb_rate")),  # kt, ft/s
        *((name, REAL) for name in ("v_north", "v_east", "v_down")),  # ft/s over the ground
        *((name, REAL) for name in ("v_body_u", "v_body_v", "v_body_w")),  # ft/s over the ground in body axes
        *((name, REAL) for name in ("A_X_pilot", "A_Y_pilot", "A_Z_pilot")),  # ft/s2 in body axes, all but gravity
        *((name, REAL) for name in ("stall_warning", "slip_deg")),
        ("num_engines", WHOLE),
        ("eng_state", WHOLE, ENGINES),
        *((name, REAL, ENGINES) for name in ("rpm", "fuel_flow", "fuel_px", "egt", "cht")),
        *((name, REAL, ENGINES) for name in ("mp_osi", "tit", "oil_temp", "oil_px")),
        ("num_tanks", WHOLE),
        ("fuel_quantity", REAL, TANKS),
        ("num_wheels", WHOLE),
        ("wow", WHOLE, WHEELS),  # whether each is on the ground: nose, left, right
        *((name, REAL, WHEELS) for name in ("gear_pos", "gear_steer", "gear_compression")),  # 0 up, 1 down
        *(("cur_time", WHOLE), ("warp", ">i4"), ("visibility", REAL)),  # s since 1970, s, m
        *((name, REAL) for name in ("elevator", "elevator_trim_tab", "left_flap", "right_flap")),  # -1..1, + trailing
        *((name, REAL) for name in ("left_aileron", "right_aileron")),  # edge down
        *((name, REAL) for name in ("rudder", "nose_wheel", "speedbrake", "spoilers")),  # + to the right
    ]
)


class Motion(NamedTuple):
    """An aircraft at n instants: SI, angles in rad, body axes forward, right and down."""

    latitude: np.ndarray  # WGS 84
    longitude: np.ndarray
    altitude: np.ndarray  # m above the sea
    above_ground: np.ndarray  # m
    attitude: np.ndarray  # (3, n) bank + right, pitch + up, heading
    body_rates: np.ndarray  # (3, n) rad/s roll, pitch, yaw
    air: np.ndarray  # (2, n) angle of attack; sideslip, + wind from the right
    velocity: np.ndarray  # (3, n) m/s over the ground: north, east, up
    calibrated_airspeed: np.ndarray  # m/s
    specific_force: np.ndarray  # (3, n) m/s2, everything but gravity
    controls: np.ndarray  # (3, n) aileron + rolls right, elevator + pitches up, rudder + yaws right, -1..1
    flaps: np.ndarray  # share of full travel
    gear: np.ndarray  # 0 up, 1 down
    on_ground: np.ndarray  # whether the main wheels are
    stamp: np.ndarray  # s since 1970; 0 = the FlightGear keeps its own clock


def packets(motion: Motion) -> np.ndarray:
    """(n,) of `PACKET`; what is not known (NaN) is sent as 0. ``packets(motion)[k].tobytes()`` is what a socket sends.

    Engines and tanks are not told: a flight here does not know them.
    """
    found = np.zeros(len(motion.latitude), PACKET)
    found["version"], found["visibility"], found["num_wheels"] = VERSION, VISIBILITY, WHEELS
    found["cur_time"] = motion.stamp
    values: dict[str, Any] = {
        **{name: getattr(motion, name) for name in ("longitude", "latitude", "altitude")},
        "agl": motion.above_ground,
        **dict(zip(("phi", "theta", "psi"), motion.attitude, strict=True)),
        **dict(zip(("alpha", "beta"), motion.air, strict=True)),
        **dict(zip(("phidot", "thetadot", "psidot"), _euler_rates(motion), strict=True)),
        "vcas": motion.calibrated_airspeed / KNOT,
        "climb_rate": motion.velocity[2] / FOOT,
        **dict(zip(("v_north", "v_east", "v_down"), _down(motion.velocity) / FOOT, strict=True)),
        **dict(zip(("v_body_u", "v_body_v", "v_body_w"), _in_body(motion) / FOOT, strict=True)),
        **dict(zip(("A_X_pilot", "A_Y_pilot", "A_Z_pilot"), motion.specific_force / FOOT, strict=True)),
        "elevator": -motion.controls[1],
        "left_aileron": motion.controls[0],
        "right_aileron": -motion.controls[0],
        "rudder": motion.controls[2],
        **dict.fromkeys(("left_flap", "right_flap"), motion.flaps),
        "gear_pos": motion.gear[:, None],
    }
    for name, column in values.items():
        found[name] = np.nan_to_num(column)
    found["wow"][:, 1:] = motion.on_ground[:, None]
    return found


def _euler_rates(motion: Motion) -> np.ndarray:
    """(3, n) rad/s of bank, pitch and heading from body rates [Etkin 1972, eq. (5.3,13), from memory]."""
    bank, pitch, _ = motion.attitude
    roll, pitching, yaw = motion.body_rates
    turning = pitching * np.sin(bank) + yaw * np.cos(bank)
    return np.array(
        (roll + np.tan(pitch) * turning, pitching * np.cos(bank) - yaw * np.sin(bank), turning / np.cos(pitch))
    )


def _down(velocity: np.ndarray) -> np.ndarray:
    """(3, n) north, east, down of north, east, up."""
    north, east, up = velocity
    return np.array((north, east, -up))


def _in_body(motion: Motion) -> np.ndarray:
    """(3, n) m/s, the velocity over the ground in body axes: turned by heading, then pitch, then bank."""
    bank, pitch, heading = motion.attitude
    north, east, down = _down(motion.velocity)
    ahead = np.cos(heading) * north + np.sin(heading) * east
    aside = np.cos(heading) * east - np.sin(heading) * north
    forward = np.cos(pitch) * ahead - np.sin(pitch) * down
    below = np.sin(pitch) * ahead + np.cos(pitch) * down
    return np.array((forward, np.cos(bank) * aside + np.sin(bank) * below, np.cos(bank) * below - np.sin(bank) * aside))
