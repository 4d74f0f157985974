"""What passes between JSBSim and us at every step of a flight: commands in, the state out.

Both stand inside the closed loop, where JSBSim has emptied the processor's caches before each call: what is looked up
then costs more than the arithmetic. So each is one function, built once, with the nodes of the model as its own names.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from aircraft import properties
from aircraft.properties import EARTH_RADIUS, FOOT, getter, setter
from aircraft.state import AircraftState, Controls

HIGHEST_WHEEL = 30.0  # m; above, no part of any aircraft can touch level ground
_NEW = tuple.__new__  # an AircraftState from a tuple of its fields at half the time of its own constructor

Number = Callable[[], float]


def state_reader(
    manager: Any, flaps: Number, flaps_factor: float, main_wheels: Sequence[Number], elevation: float
) -> Callable[[Controls, tuple[float, float], float], AircraftState]:
    """The function that reads a state.

    Parameters
    ----------
    flaps : reads their deflection; times ``flaps_factor`` it is in rad
    main_wheels : each reads 1 while its wheel is on the ground
    elevation : m, of the runway

    The function takes the controls that were commanded, the parts that touched the ground first and so far, and the
    acceleration (m/s2) of a force of 1 lbf.
    """
    time, latitude, longitude, altitude, north, east, down, *others = (getter(manager, one) for one in properties.STATE)
    bank, pitch, heading, roll_rate, pitch_rate, yaw_rate, airspeed, equivalent, angle_of_attack, sideslip = others
    forward, right, downward = (getter(manager, one) for one in properties.FORCES)
    gear = getter(manager, properties.GEAR)
    count = max(len(main_wheels), 1)

    def read(controls: Controls, contact: tuple[float, float], per_pound: float) -> AircraftState:
        aileron, elevator, rudder, throttle, _, _ = controls
        first_contact, touched = contact
        wheels, height = 0.0, altitude() * FOOT - elevation
        if height < HIGHEST_WHEEL:
            for wheel in main_wheels:
                wheels += wheel()
        return _NEW(
            AircraftState,
            (
                time(),
                latitude() * EARTH_RADIUS,
                longitude() * EARTH_RADIUS,
                height,
                north() * FOOT,
                east() * FOOT,
                -down() * FOOT,
                bank(),
                pitch(),
                heading(),
                roll_rate(),
                pitch_rate(),
                yaw_rate(),
                airspeed() * FOOT,
                equivalent() * FOOT,
                angle_of_attack(),
                sideslip(),
                forward() * per_pound,
                right() * per_pound,
                downward() * per_pound,
                aileron,
                elevator,
                rudder,
                throttle,
                flaps() * flaps_factor,
                gear(),
                wheels / count,
                first_contact,
                touched,
            ),
        )

    return read


def control_writer(manager: Any) -> Callable[[Controls], None]:
    """The function that sets the control surfaces and every power lever that the model has."""
    set_aileron, set_elevator, set_rudder = (setter(manager, one) for one in properties.SURFACES)
    throttles = tuple(_throttles(manager))

    def write(controls: Controls) -> None:
        aileron, elevator, rudder, throttle, _, _ = controls
        set_aileron(aileron)
        set_elevator(-elevator)
        set_rudder(-rudder)
        for set_throttle in throttles:
            set_throttle(throttle)

    return write


def _throttles(manager: Any) -> list[Any]:
    """The power levers, be they of FlightGear, which the model itself then turns into JSBSim's."""
    found: list[Callable[[float], bool]] = []
    while (lever := manager.get_node(f"{properties.THROTTLE.name}[{len(found)}]", False)) is not None:
        foreign = manager.get_node(properties.FOREIGN_THROTTLE.name.format(len(found)), False)
        found.append((foreign or lever).set_double_value)
    return found
