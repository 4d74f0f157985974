"""The airframe: six-degree-of-freedom flight by JSBSim, and the point mass of the papers behind the same interface.

- ``state``: what passes to and from autopilot and sensors; ``units``: suffix -> SI; ``ranges``: what a
  parameter may be, as a note on its field; ``errors``: sentences for users
- ``model_files``, ``safe_xml``, ``repairs``, ``loading``: from somebody's model to one that can be flown here;
  ``data``, ``stock``, ``landing_gear``, ``runway``: what is known besides; ``identity``: a digest of all that;
  ``models``: aircraft of our own, made by ``handbook``
- ``executive``, ``properties``, ``link``, ``power_plant``, ``airframe``: JSBSim for one flight; ``point_mass``: that of
  the papers
- ``trim``, ``minimum_speed``, ``slowest``, ``linearise``, ``modes``, ``actuators``: what is computed from an airframe
- ``air``: density, temperature, pressure; ``wind``, ``wind_shear``, ``turbulence``, ``turbulence_intensity``: motion of
  the air; ``wind_events``: one file for each kind, ``wind_event`` their contract

Conventions of motion, used by every package
---------------------------------------------
**Units.** SI, radians, seconds. Feet, pounds and degrees exist only in ``properties`` and in the model files.

**Earth.** A flight happens over a sphere that does not rotate, with standard gravity (9.80665 m/s2) at sea level. The
runway threshold lies on its equator, so north = R dlatitude and east = R dlongitude are metric to 3e-6 within 15 km,
"down" is exactly the direction of gravity, and there is no Coriolis acceleration: an aircraft trimmed straight and
level stays so, in every direction. The height is measured along the local vertical. What is
neglected against the rotating ellipsoid is 2 omega V sin(latitude) = 0.008 m/s2 at 72 m/s, which any lateral autopilot
takes up with 0.05 deg of bank. The runway's own latitude and longitude serve maps and exports only.

**Runway frame.** Position (north, east, height) in metres from the threshold; velocity (north, east, up) over the
ground; wind (north, east, up) is the way the air moves. The terrain is level at the elevation of the threshold.

**Attitude.** Heading clockwise from north, pitch up, bank right, in the order heading - pitch - bank. Body axes are
forward, right, down; so roll_rate > 0 rolls right, pitch_rate > 0 pitches up, yaw_rate > 0 yaws right. Sideslip > 0 is
wind from the right.

**Airspeed** is the true one unless it is called equivalent or indicated; see ``air``. Heights are true heights,
whatever an altimeter shows in warm or cold air.

**Load factor.** Specific force (all but gravity) over standard gravity, in wind axes: forward along the velocity
through the air, right, up. (0, 0, 1) in steady level flight. The aerodynamic bank is the angle about that velocity.
The flight-path angle and course of the AIR path differ from those of the ground track in wind: load factors turn into
earth-axes accelerations only with the former.

**Controls.** Elevator > 0 pitches up, rudder > 0 yaws right, aileron > 0 rolls right, each -1..1; throttle 0..1 is the
power lever; flaps in radians; gear 0 up, 1 down.

**A flight**, and how to ask for its linear model::

    airframe = load("an26", mass=21000.0)
    steady = trim(airframe, airspeed=72.0, flaps=math.radians(15.0))
    model = linearise(airframe, steady)
    state = airframe.begin(steady.at(north=-9000.0, east=0.0, height=400.0, heading=0.0), wind=(0.0, 5.0, 0.0))
    while state.time < 60.0:
        airframe.step(steady.controls, substeps=4)  # of 1 / airframe.rate s
        state = airframe.read()
"""
