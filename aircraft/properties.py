"""Catalogue of the JSBSim properties that are read or written: name, factor to SI, meaning.

Binding a name that a model does not have is an error: JSBSim itself would silently create it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

FOOT = 0.3048  # m
POUND_PER_SLUG = 0.3048  # lbf/slug -> m/s2
EARTH_RADIUS = 6371000.0  # m, the sphere of ``aircraft.__doc__``


class Property(NamedTuple):
    """One JSBSim property."""

    name: str
    factor: float  # to SI, with the sign of our conventions
    meaning: str


STATE = (  # in the order of AircraftState, up to and including sideslip
    Property("simulation/sim-time-sec", 1.0, "time"),
    Property("position/lat-gc-rad", EARTH_RADIUS, "north of the threshold, on the sphere's equator"),
    Property("position/long-gc-rad", EARTH_RADIUS, "east of the threshold"),
    Property("position/h-sl-ft", FOOT, "height above sea level"),
    Property("velocities/v-north-fps", FOOT, "velocity over the ground, north"),
    Property("velocities/v-east-fps", FOOT, "velocity over the ground, east"),
    Property("velocities/v-down-fps", -FOOT, "velocity over the ground, up"),
    Property("attitude/phi-rad", 1.0, "bank"),
    Property("attitude/theta-rad", 1.0, "pitch"),
    Property("attitude/psi-rad", 1.0, "heading"),
    Property("velocities/p-rad_sec", 1.0, "roll rate"),
    Property("velocities/q-rad_sec", 1.0, "pitch rate"),
    Property("velocities/r-rad_sec", 1.0, "yaw rate"),
    Property("velocities/vt-fps", FOOT, "true airspeed"),
    Property("velocities/ve-fps", FOOT, "equivalent airspeed"),
    Property("aero/alpha-rad", 1.0, "angle of attack"),
    Property("aero/beta-rad", 1.0, "sideslip"),
)
FORCES = (  # everything but weight; the friction of the wheels is in it, a frame late
    Property("forces/fbx-total-lbs", POUND_PER_SLUG, "force forward, over the mass in slugs"),
    Property("forces/fby-total-lbs", POUND_PER_SLUG, "force right"),
    Property("forces/fbz-total-lbs", POUND_PER_SLUG, "force down"),
)
MASS = Property("inertia/mass-slugs", 14.593902937206365, "mass")
WING_AREA = Property("metrics/Sw-sqft", FOOT * FOOT, "area of the wing")
ACCELERATIONS = (
    Property("accelerations/udot-ft_sec2", FOOT, "rate of the velocity forward, in turning body axes"),
    Property("accelerations/vdot-ft_sec2", FOOT, "rate of the velocity right"),
    Property("accelerations/wdot-ft_sec2", FOOT, "rate of the velocity down"),
    Property("accelerations/pdot-rad_sec2", 1.0, "roll acceleration"),
    Property("accelerations/qdot-rad_sec2", 1.0, "pitch acceleration"),
    Property("accelerations/rdot-rad_sec2", 1.0, "yaw acceleration"),
)
SURFACES = (  # JSBSim counts elevator and rudder against our signs
    Property("fcs/aileron-cmd-norm", 1.0, "aileron"),
    Property("fcs/elevator-cmd-norm", -1.0, "elevator"),
    Property("fcs/rudder-cmd-norm", -1.0, "rudder"),
)
GROUND_REACTIONS = "simulation/models/FGGroundReactions/enabled"  # 1: contacts are looked at
THROTTLE = Property("fcs/throttle-cmd-norm", 1.0, "power lever, one per engine")
FOREIGN_THROTTLE = Property("/controls/engines/engine[{}]/throttle", 1.0, "power lever of FlightGear")
FLAPS_COMMAND = Property("fcs/flap-cmd-norm", 1.0, "flaps over their full deflection")
FLAPS = Property("fcs/flap-pos-deg", 0.017453292519943295, "flaps")
FLAPS_OF_FULL = Property("fcs/flap-pos-norm", 1.0, "flaps over their full deflection, of models that give no angle")
GEAR_COMMAND = Property("gear/gear-cmd-norm", 1.0, "gear, 1 down")
GEAR = Property("gear/gear-pos-norm", 1.0, "gear, 1 down")
BRAKES = (
    Property("fcs/left-brake-cmd-norm", 1.0, "brakes of the left wheels, 0..1"),
    Property("fcs/right-brake-cmd-norm", 1.0, "brakes of the right wheels"),
    Property("fcs/center-brake-cmd-norm", 1.0, "brakes of the wheels in the middle"),
)
STEERING = Property("fcs/steer-cmd-norm", 1.0, "steerable wheels, -1..1 of their travel, + to the right")
WIND = (
    Property("atmosphere/wind-north-fps", FOOT, "the way the air moves, north"),
    Property("atmosphere/wind-east-fps", FOOT, "the way the air moves, east"),
    Property("atmosphere/wind-down-fps", -FOOT, "the way the air moves, up"),
)
AIR = (
    Property("atmosphere/delta-T", 5.0 / 9.0, "temperature in excess of the standard one, K, at every height"),
    Property("atmosphere/P-sl-psf", 47.88025898033584, "pressure at sea level, Pa"),
)
INITIAL = (
    Property("ic/terrain-elevation-ft", FOOT, "elevation of the ground"),
    Property("ic/lat-gc-rad", EARTH_RADIUS, "north"),
    Property("ic/long-gc-rad", EARTH_RADIUS, "east"),
    Property("ic/h-sl-ft", FOOT, "height above sea level"),
    Property("ic/psi-true-rad", 1.0, "heading"),
    Property("ic/theta-rad", 1.0, "pitch"),
    Property("ic/phi-rad", 1.0, "bank"),
    Property("ic/vw-mag-fps", FOOT, "wind speed"),
    Property("ic/vw-dir-deg", 0.017453292519943295, "the way the wind blows to"),
    Property("ic/u-fps", FOOT, "velocity over the ground, forward"),
    Property("ic/v-fps", FOOT, "velocity over the ground, right"),
    Property("ic/w-fps", FOOT, "velocity over the ground, down"),
    Property("ic/p-rad_sec", 1.0, "roll rate"),
    Property("ic/q-rad_sec", 1.0, "pitch rate"),
    Property("ic/r-rad_sec", 1.0, "yaw rate"),
)


def node(manager: Any, name: str) -> Any:
    """The JSBSim node of this name; ``KeyError`` where the model has none."""
    found = manager.get_node(name, False)
    if found is None:
        raise KeyError(f"the model has no property '{name}'")
    return found


def getter(manager: Any, wanted: Property) -> Callable[[], float]:
    """Bound reader in JSBSim's own unit."""
    read: Callable[[], float] = node(manager, wanted.name).get_double_value
    return read


def setter(manager: Any, wanted: Property) -> Callable[[float], bool]:
    """Bound writer in JSBSim's own unit."""
    write: Callable[[float], bool] = node(manager, wanted.name).set_double_value
    return write
