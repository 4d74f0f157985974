"""One JSBSim aircraft for one flight: load, begin, step, read.

A handle used once: JSBSim corrupts memory when a second model is loaded and does not restart cleanly, so every flight
has a fresh one (2-5 ms). Nodes are bound once; ``step`` and ``read`` are flat and use plain floats only, because they
stand inside the closed loop.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import jsbsim

from aircraft import loading, model_files, properties, repairs
from aircraft.air import Air
from aircraft.data import AircraftData, describe
from aircraft.errors import FlightError, ModelError
from aircraft.executive import fresh_executive, put_aside, sentence
from aircraft.landing_gear import Contact, contacts, reach
from aircraft.link import HIGHEST_WHEEL, control_writer, state_reader
from aircraft.power_plant import started
from aircraft.properties import EARTH_RADIUS, FOOT, getter, node, setter
from aircraft.runway import Runway
from aircraft.state import MAIN_WHEEL, AircraftState, Controls, WheelControls
from aircraft.wind import SteadyWind

FASTEST = 340.0  # m/s; no aircraft of ours comes down faster
UNTOLD_FLAPS = math.radians(40.0)  # full deflection of a model that gives only its share
MOTION = slice(AircraftState._fields.index("north"), AircraftState._fields.index("airspeed") + 1)
ALTITUDE, AIRSPEED = (AircraftState._fields.index(name) for name in ("height", "airspeed"))


class Wind(Protocol):
    """Air in motion; see ``aircraft.wind``."""

    def velocity(
        self, time: float, position: tuple[float, float, float], airspeed: float
    ) -> tuple[float, float, float]:
        """(north, east, up) m/s, the way the air moves."""
        ...


class InitialCondition(NamedTuple):
    """How a flight begins; steady, so that actuators, engines, flaps and gear stand where the controls want them."""

    north: float  # m from the threshold
    east: float
    height: float
    heading: float  # rad
    pitch: float
    bank: float
    airspeed: float  # m/s
    angle_of_attack: float  # rad
    sideslip: float
    controls: Controls
    roll_rate: float = 0.0  # rad/s, body axes
    pitch_rate: float = 0.0
    yaw_rate: float = 0.0


class Wiring(NamedTuple):
    """The properties by which one model shows its motion and takes its controls, beside those of every model."""

    state: tuple[properties.Property, ...]  # fields of AircraftState up to the sideslip
    flaps: properties.Property
    main_wheels: tuple[str, ...]  # properties, 1 on the ground
    throttles: tuple[str, ...]
    full_flaps: float  # rad at full command; 0 without flaps


class Airframe:
    """One aircraft in flight: ``load`` it, ``begin`` it (again and again until it has moved), then ``step`` it."""

    def __init__(
        self,
        executive: Any,
        aircraft: AircraftData,
        runway: Runway,
        points: tuple[Contact, ...],
        reach: float,
        has_propellers: bool,
        air: Air | None = None,
    ) -> None:
        self.data = aircraft
        self.rate = aircraft.rate  # Hz, of the equations of motion
        self.runway = runway
        self.air = air or Air(runway.elevation)
        self.repairs: tuple[str, ...] = ()  # what the model needed to fly here
        self.source: model_files.Model | None = None  # what JSBSim was given
        self._executive = executive
        self._run = executive.run
        manager = executive.get_property_manager()
        self._manager = manager
        if air is not None and not air.is_standard:  # before anything trims or starts in it
            for wanted, value in zip(properties.AIR, (air.temperature_shift, air.sea_level_pressure), strict=True):
                setter(manager, wanted)(value / wanted.factor)
        self._accelerations = [getter(manager, wanted) for wanted in properties.ACCELERATIONS]
        self._mass = getter(manager, properties.MASS)
        self._points = points
        self._contacts = [(node(manager, point.node).get_double_value, point.part) for point in points]
        self._main_wheels = [weight for weight, part in self._contacts if part == MAIN_WHEEL]
        self._first_contact = self._touched = 0
        self._contact = (0.0, 0.0)  # the same as a state shows them
        ground = manager.get_node(properties.GROUND_REACTIONS, False)  # JSBSim 1.3.1 cannot leave them out
        self._reach = math.inf if ground is None else reach
        self._set_ground = None if ground is None else ground.set_double_value
        self._ground = True  # whether contacts are looked at
        self._elevation = runway.elevation
        self._initial = [(setter(manager, wanted), wanted.factor) for wanted in properties.INITIAL]
        self._write = control_writer(manager)
        self._set_flaps = setter(manager, properties.FLAPS_COMMAND)
        self._set_gear = setter(manager, properties.GEAR_COMMAND)
        self._brakes = [setter(manager, wanted) for wanted in properties.BRAKES]
        self._steer = setter(manager, properties.STEERING)
        self._wind = [setter(manager, wanted) for wanted in properties.WIND]
        self._blowing: SteadyWind | None = None  # what the model was told last and keeps
        self._settle: Callable[[], None] | None = None
        self._controls = Controls(0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        self._last: AircraftState | None = None
        self._has_flown = False
        self._specific_force = 0.0
        self.full_flaps, flaps, self._flaps_factor = self._full_flaps()
        if has_propellers:
            self._settle = started(executive)
        self._read = state_reader(manager, flaps, self._flaps_factor, self._main_wheels, self._elevation)
        self._time, self._latitude, self._longitude, self._altitude = (
            getter(manager, wanted) for wanted in properties.STATE[: ALTITUDE + 1]
        )
        self._airspeed = getter(manager, properties.STATE[AIRSPEED])

    @property
    def mass(self) -> float:
        """kg; fuel does not burn, so that it is constant."""
        return self._mass() * properties.MASS.factor

    def has(self, name: str) -> bool:
        """Whether the model has a property of this name."""
        return self._manager.get_node(name, False) is not None

    @property
    def wiring(self) -> Wiring:
        """What is read and written of this model."""
        share = properties.FLAPS_OF_FULL
        by_share = self._flaps_factor == UNTOLD_FLAPS
        throttles: list[str] = []
        while self.has(name := f"{properties.THROTTLE.name}[{len(throttles)}]"):
            foreign = properties.FOREIGN_THROTTLE.name.format(len(throttles))
            throttles.append(foreign if self.has(foreign) else name)
        return Wiring(
            properties.STATE,
            share._replace(factor=UNTOLD_FLAPS) if by_share else properties.FLAPS,
            tuple(point.node for point in self._points if point.part == MAIN_WHEEL),
            tuple(throttles),
            self.full_flaps,
        )

    @property
    def wing_area(self) -> float:
        """m2, of the wing to which the model refers its coefficients."""
        return getter(self._manager, properties.WING_AREA)() * properties.WING_AREA.factor

    def begin(self, initial: InitialCondition, wind: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> AircraftState:
        """Put the aircraft into a steady state in a steady horizontal wind and return that state.

        A trimmed start stays trimmed in any wind: the initial velocity is the one through the air plus the wind.
        """
        if self._has_flown:
            raise FlightError("an airframe flies once: load a fresh one for the next flight")
        if not all(map(math.isfinite, (*initial[:9], *initial.controls, *initial[10:], *wind))):
            raise FlightError("the initial condition must be finite")
        if initial.height < 0.0:
            raise FlightError(f"the flight would begin {-initial.height:.0f} m below the runway")
        wind_north, wind_east, _ = wind
        u, v, w = _body_velocity(initial, wind_north, wind_east)
        elevation = self._elevation
        values = (
            elevation,
            initial.north,
            initial.east,
            initial.height + elevation,
            initial.heading,
            initial.pitch,
            initial.bank,
            math.hypot(wind_north, wind_east),
            math.atan2(wind_east, wind_north) % (2.0 * math.pi),
            u,
            v,
            w,
            initial.roll_rate,
            initial.pitch_rate,
            initial.yaw_rate,
        )
        for (write, factor), value in zip(self._initial, values, strict=True):
            write(value / factor)
        self._command(initial.controls)
        self._executive.set_trim_status(True)
        try:
            for _ in range(3):  # the rate of the angle of attack is one frame old
                self._executive.run_ic()
            if self._settle is not None:
                self._settle()
                self._executive.set_sim_time(0.0)
        except jsbsim.BaseError as error:
            raise FlightError(f"the model cannot begin a flight: {sentence([str(error)])}") from None
        self._executive.set_trim_status(False)
        self._specific_force = properties.POUND_PER_SLUG / self._mass()
        self._last = self._blowing = None
        return self.read()

    def step(self, controls: Controls, substeps: int, wind: Wind | None = None) -> None:
        """Fly ``substeps`` steps of 1/rate s with these controls; a changing ``wind`` is asked before every one.

        Within one call the wind sees the position and airspeed of its beginning.
        """
        self._has_flown = True
        height = self._altitude() * FOOT - self._elevation
        # far from the ground the contacts cost a quarter of a step and give nothing
        near = not height > self._reach + FASTEST * substeps / self.rate
        if near is not self._ground and self._set_ground is not None:
            self._set_ground(float(near))
            self._ground = near
        run = self._run if height > HIGHEST_WHEEL else self._run_and_feel
        try:
            self._command(controls)
            if wind is None or wind is self._blowing:
                for _ in range(substeps):
                    run()
            elif isinstance(wind, SteadyWind):
                self._blow(*wind)
                self._blowing = wind
                for _ in range(substeps):
                    run()
            else:
                self._blowing = None
                began, rate = self._time(), self.rate
                position = (self._latitude() * EARTH_RADIUS, self._longitude() * EARTH_RADIUS, height)
                airspeed = self._airspeed() * FOOT
                blow, velocity = self._blow, wind.velocity
                for substep in range(substeps):
                    blow(*velocity(began + substep / rate, position, airspeed))
                    run()
        except jsbsim.BaseError as error:
            raise FlightError(f"the model gives up: {sentence([str(error)])}") from None

    def _run_and_feel(self) -> None:
        """One step near the ground: two parts that touch it between two records do so in their order."""
        self._run()
        touching = 0
        for weight, part in self._contacts:
            if weight():
                touching |= part
        self._first_contact = self._first_contact or touching
        self._touched |= touching
        self._contact = (float(self._first_contact), float(self._touched))

    def set_wheels(self, wheels: WheelControls) -> None:
        """Brakes and steering from now on."""
        left, right, steering = wheels
        for brake, value in zip(self._brakes, (left, right, 0.5 * (left + right)), strict=True):
            brake(value)
        self._steer(steering)

    def read(self) -> AircraftState:
        """The state now; raises ``FlightError`` with the last good one when a number is not finite."""
        state = self._read(self._controls, self._contact, self._specific_force)
        if not math.isfinite(sum(state[MOTION])):
            raise FlightError(f"the motion is not finite at {state.time:.2f} s", state.time, self._last)
        self._last = state
        return state

    def accelerations(self) -> tuple[float, float, float, float, float, float]:
        """Rates of the body-axis velocity (m/s2) and of the body rates (rad/s2)."""
        u, v, w, p, q, r = (get() for get in self._accelerations)
        return u * FOOT, v * FOOT, w * FOOT, p, q, r

    def _blow(self, north: float, east: float, up: float) -> None:
        set_north, set_east, set_down = self._wind
        set_north(north / FOOT)
        set_east(east / FOOT)
        set_down(-up / FOOT)

    def _command(self, controls: Controls) -> None:
        if controls is self._controls:
            return
        self._write(controls)
        levers = flaps, gear = controls[4:]
        if levers != self._controls[4:] or not self._has_flown:  # they are moved a few times a flight
            self._set_flaps(flaps / self.full_flaps if self.full_flaps else 0.0)
            self._set_gear(gear)
        self._controls = controls

    def _full_flaps(self) -> tuple[float, Callable[[], float], float]:
        """Deflection at full command (rad, 0 without flaps), reader and its factor, asked of the model itself."""
        in_degrees = getter(self._manager, properties.FLAPS)
        of_full = getter(self._manager, properties.FLAPS_OF_FULL)
        self._executive["ic/h-sl-ft"] = 10000.0  # clear of the ground, or the wheels would remember it
        self._executive.set_trim_status(True)
        self._set_flaps(1.0)
        self._executive.run_ic()
        deflection, share = in_degrees() * properties.FLAPS.factor, of_full()
        self._set_flaps(0.0)
        self._executive.run_ic()
        self._executive.set_trim_status(False)
        if deflection == 0.0 and share > 0.0:  # the model knows its flaps by their share only
            return UNTOLD_FLAPS, of_full, UNTOLD_FLAPS
        return deflection, in_degrees, properties.FLAPS.factor


def load(
    model: str | Path,
    mass: float | None = None,
    centre_of_gravity_mac: float | None = None,
    factors: Mapping[str, float] | None = None,
    runway: Runway | None = None,
    air: Air | None = None,
    rate: float | None = None,
    repaired: bool = False,
) -> Airframe:
    """A fresh aircraft: ours or a stock one by name, or a user's folder by path.

    Parameters
    ----------
    mass : total, kg; None = as the model says.
    centre_of_gravity_mac : share of the mean aerodynamic chord; needs an aircraft that states its chord.
    factors : scales of groups of coefficients, by the names that the aircraft declares.
    air : over the runway; None = the standard atmosphere.
    rate : of the equations of motion, Hz; None = that of the aircraft's data.
    repaired : what waits for another simulator is mended as in stock models, see ``Airframe.repairs``.

    Raises ``ModelError`` with one sentence for anything that cannot be loaded.
    """
    source = model_files.read(model)
    aircraft = describe(source, model)
    if rate is not None:
        aircraft = dataclasses.replace(aircraft, rate=rate)
    if factors:
        loading.apply_factors(source, factors)
    if mass is not None:
        if not aircraft.mass_min <= mass <= aircraft.mass_max:
            raise ModelError(
                f"mass of '{source.name}' must lie between {aircraft.mass_min:.0f} and {aircraft.mass_max:.0f} kg, "
                f"not {mass} kg"
            )
        loading.apply_mass(source, mass)
    if centre_of_gravity_mac is not None:
        if not aircraft.mean_chord > 0.0:
            raise ModelError(
                f"the data of '{source.name}' state no mean aerodynamic chord, so its centre of gravity stays"
            )
        if not aircraft.centre_of_gravity_min <= centre_of_gravity_mac <= aircraft.centre_of_gravity_max:
            raise ModelError(
                f"centre_of_gravity_mac of '{source.name}' must lie between {aircraft.centre_of_gravity_min} and "
                f"{aircraft.centre_of_gravity_max}, not {centre_of_gravity_mac}"
            )
        loading.apply_centre_of_gravity(
            source, aircraft.chord_leading_edge + centre_of_gravity_mac * aircraft.mean_chord
        )
    return _built(source, aircraft, runway or Runway(), air, repaired or repairs.is_stock(model))


def _built(
    source: model_files.Model, aircraft: AircraftData, runway: Runway, air: Air | None, repaired: bool
) -> Airframe:
    """The airframe of a model, mended where it waits for another simulator, or all that it waits for in one error."""
    told = (repairs.drive_directly(source), repairs.free_steering(source)) if repaired else ()
    points, farthest = contacts(source), reach(source)
    propellers = repairs.has_propellers(source)
    while True:
        try:
            executive = fresh_executive(source, aircraft.rate)
            airframe = _airframe(source, executive, aircraft, runway, points, farthest, propellers, air)
        except ModelError as error:
            if repairs.define_missing(source, str(error)):
                continue
            asked = None if repaired else repairs.asked_for(source)
            raise ModelError(f"{error}; besides, {asked}") if asked else error from None
        else:
            asked = repairs.asked_for(source)
            if (asked or repaired) and repairs.define_unread(source, airframe.has):
                continue
            if asked and not repaired:
                raise ModelError(asked)
            airframe.source = source
            airframe.repairs = tuple(text for text in (*told, repairs.defined(source)) if text)
            return airframe


def _airframe(source: model_files.Model, executive: Any, *parts: Any) -> Airframe:
    """The airframe of an executive; raises ``ModelError``."""
    try:
        return Airframe(executive, *parts)
    except (KeyError, jsbsim.BaseError) as error:
        put_aside(executive, source)
        raise ModelError(f"'{source.name}' cannot be used: {sentence([*map(str, error.args)])}") from None


def _body_velocity(initial: InitialCondition, wind_north: float, wind_east: float) -> tuple[float, float, float]:
    """Velocity over the ground in body axes: through the air plus the horizontal wind."""
    cos_alpha, sin_alpha = math.cos(initial.angle_of_attack), math.sin(initial.angle_of_attack)
    cos_beta, sin_beta = math.cos(initial.sideslip), math.sin(initial.sideslip)
    cos_heading, sin_heading = math.cos(initial.heading), math.sin(initial.heading)
    cos_pitch, sin_pitch = math.cos(initial.pitch), math.sin(initial.pitch)
    cos_bank, sin_bank = math.cos(initial.bank), math.sin(initial.bank)
    along = wind_north * cos_heading + wind_east * sin_heading
    across = wind_east * cos_heading - wind_north * sin_heading
    speed = initial.airspeed
    return (
        speed * cos_alpha * cos_beta + cos_pitch * along,
        speed * sin_beta + sin_bank * sin_pitch * along + cos_bank * across,
        speed * sin_alpha * cos_beta + cos_bank * sin_pitch * along - sin_bank * across,
    )
