"""Writes ``an26.xml``: geometry of the An-26 and closed forms in, JSBSim model out.

Run ``python -m aircraft.models.an26.build`` after a change; a test compares the result with the committed file.

Every number of ``FACTS`` states what it is: *public* (museum sheet, manual, published polar), *formula* (see
``aircraft.handbook``), *memory* (not confirmed), or *chosen* (and why). The lift table is shaped by the published polar
of the An-24, which has the same wing; that polar therefore cannot also judge it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from aircraft import handbook
from aircraft.state import STANDARD_GRAVITY

POUND_FORCE = 4.4482216152605
FOOT = 0.3048
SEA_LEVEL_DENSITY = 0.0023769117527742576  # slug/ft3, of JSBSim's standard atmosphere


class Fact(NamedTuple):
    """A number that the model starts from."""

    value: float
    source: str


FACTS = {
    "span": Fact(29.20, "public: museum sheets, manual; m"),
    "area": Fact(74.98, "public; m2"),
    "chord": Fact(2.813, "public: mean aerodynamic chord; m"),
    "length": Fact(23.8, "public; m"),
    "incidence": Fact(math.radians(3.0), "public: wing to body"),
    "taper": Fact(0.31, "memory"),
    "half_chord_sweep": Fact(0.0, "chosen: 3 deg at the quarter chord is next to none at mid-chord"),
    "outer_dihedral": Fact(math.radians(-2.0), "public: outer panels only"),
    "outer_share": Fact(0.5, "memory: share of the rolling moment of a full-span dihedral that the outer panels give"),
    "oswald": Fact(0.80, "chosen: typical of high-wing twins"),
    "tail_area": Fact(19.83, "memory: Jane's; m2"),
    "tail_span": Fact(9.97, "memory; m"),
    "tail_arm": Fact(12.25, "cross-check: An-24; m"),
    "tail_height": Fact(1.0, "memory: above the wing's wake; m"),
    "tail_dynamic_pressure": Fact(0.95, "chosen: textbook value outside the slipstream"),
    "elevator_area": Fact(5.16, "memory: Jane's; m2"),
    "fin_area": Fact(15.85, "memory: Jane's, with dorsal fin; m2"),
    "fin_height": Fact(5.0, "memory; m"),
    "fin_arm": Fact(11.3, "cross-check: An-24; m"),
    "fin_centre_height": Fact(2.9, "memory: above the centre of gravity; m"),
    "fin_end_plate": Fact(1.6, "chosen: tailplane and body as end plates, on the aspect ratio"),
    "rudder_area": Fact(5.00, "memory: Jane's; m2"),
    "aileron_chord_share": Fact(0.25, "memory: behind the hinge; 76 % of the 6.12 m2 of Jane's, nose balance and all"),
    "aileron_inner": Fact(9.0, "memory; m from the plane of symmetry"),
    "aileron_outer": Fact(14.3, "memory; m"),
    "flap_area": Fact(15.0, "memory: Jane's; m2"),
    "flap_chord_share": Fact(0.30, "memory"),
    "flap_induced": Fact(0.20, "chosen: Roskam VI, part-span flaps with a body between"),
    "fuselage_width": Fact(2.9, "memory; m"),
    "fuselage_volume_share": Fact(0.75, "chosen: of the enclosing cylinder"),
    "wing_height": Fact(1.1, "memory: wing above the axis of the body; m"),
    "nacelle_shift": Fact(0.10, "chosen: forward shift of the aerodynamic centre by nacelles and propellers, chords"),
    "nacelle_yaw": Fact(-0.013, "chosen: Cnb of two nacelles and propellers ahead of the wing"),
    "zero_lift_drag": Fact(0.0245, "public: polar of the An-24"),
    "gear_drag": Fact(0.014, "public: polar of the An-24"),
    "power": Fact(2103e3, "public: 2820 hp, AI-24VT; W per engine"),
    "idle_power": Fact(200e3, "chosen: flight idle near zero thrust on the glide path; W"),
    "power_lag": Fact(0.8, "memory: s"),
    "propeller_diameter": Fact(3.90, "public: AV-72T; m"),
    "propeller_profile_power": Fact(240e3, "formula: blade elements at 1245 rpm, within 15 % from 58 to 100 m/s; W"),
    "leading_edge": Fact(8.97, "chosen: 8 % of the weight on the nose wheel at 0.24 MAC; m behind the nose"),
    "reference_cg": Fact(0.24, "memory: middle of the range"),
    "mass": Fact(20000.0, "chosen: landing mass of the default scenario; kg"),
    "nose_wheel": Fact(2.42, "cross-check: An-24; m behind the nose"),
    "main_wheels": Fact(10.27, "cross-check: An-24; m behind the nose"),
    "wheel_track": Fact(7.9, "public; m"),
    "steering": Fact(10.0, "memory: of the nose wheel from the pedals, in take-off and landing; deg"),
    "wheel_depth": Fact(2.45, "memory: extended wheels below the centre of gravity; m"),
    "engine_x": Fact(5.94, "cross-check: An-24; m behind the nose"),
    "engine_y": Fact(3.95, "cross-check: An-24; m"),
    "engine_z": Fact(0.5, "memory: thrust line above the centre of gravity; m"),
    "elevator_up": Fact(math.radians(30.0), "public"),
    "elevator_down": Fact(math.radians(15.0), "public"),
    "aileron_up": Fact(math.radians(24.0), "public"),
    "aileron_down": Fact(math.radians(16.0), "public"),
    "aileron_travel": Fact(math.radians(20.0), "public: mean of 24 up and 16 down"),
    "aileron_up_lift": Fact(0.72, "public: Roskam VI fig. 8.13, what flow that separates leaves at 24 deg, 25 % chord"),
    "aileron_down_lift": Fact(0.96, "public: the same at 16 deg"),
    "rudder_travel": Fact(math.radians(25.0), "public"),
    "actuator_bandwidth": Fact(20.0, "chosen: rad/s"),
    "actuator_rate": Fact(0.8, "chosen: rad/s"),
    "flap_time": Fact(15.0, "public: s, 0 to 38 deg"),
    "gear_time": Fact(10.0, "memory: s"),
}
POLAR = {  # flaps, deg: (CL at zero, CLmax, its angle of attack in deg, all at the wing); public: polar of the An-24
    0.0: (0.084, 1.53, 19.0),
    15.0: (0.474, 2.00, 18.0),
    38.0: (1.157, 2.51, 16.0),
}
ALPHAS = (*range(-20, 5, 4), *range(5, 31), 35, 40)  # deg, at the wing
CRUISE_OF_FORMS = 65.0  # m/s, for the Mach number and the lift coefficient of the closed forms


def fact(name: str) -> float:
    """Value of a fact."""
    return FACTS[name].value


def derivatives() -> dict[str, float]:
    """Stability and control derivatives, per rad, about the quarter chord; signs of JSBSim for the controls."""
    area, span, chord = fact("area"), fact("span"), fact("chord")
    aspect_ratio = span**2 / area
    mach = CRUISE_OF_FORMS / 340.0
    lift = fact("mass") * STANDARD_GRAVITY / (0.5 * 1.225 * CRUISE_OF_FORMS**2 * area)
    wing = handbook.lift_curve_slope(aspect_ratio, fact("half_chord_sweep"), mach)
    tail = handbook.lift_curve_slope(fact("tail_span") ** 2 / fact("tail_area"), 0.0, mach)
    tail *= fact("tail_dynamic_pressure") * fact("tail_area") / area
    downwash = handbook.downwash_slope(aspect_ratio, fact("taper"), fact("tail_arm"), fact("tail_height"), span)
    arm = fact("tail_arm") / chord
    body = handbook.fuselage_pitch_stiffness(fact("fuselage_width"), fact("length"), chord, area)
    elevator = handbook.flap_effectiveness(fact("elevator_area") / fact("tail_area"))
    rudder = handbook.flap_effectiveness(fact("rudder_area") / fact("fin_area"))
    fin_aspect_ratio = fact("fin_end_plate") * fact("fin_height") ** 2 / fact("fin_area")
    fin = handbook.lift_curve_slope(fin_aspect_ratio, 0.0, mach)
    fin *= fact("tail_dynamic_pressure") * fact("fin_area") / area
    fin_arm, fin_up = fact("fin_arm") / span, fact("fin_centre_height") / span
    width = fact("fuselage_width")
    volume = fact("fuselage_volume_share") * math.pi / 4.0 * width**2 * fact("length")
    half_span, up, down = 0.5 * span, fact("aileron_up"), fact("aileron_down")
    aileron = handbook.aileron_power(
        aspect_ratio,
        fact("taper"),
        fact("aileron_inner") / half_span,
        fact("aileron_outer") / half_span,
        handbook.flap_effectiveness(fact("aileron_chord_share")),
    )
    aileron *= (up * fact("aileron_up_lift") + down * fact("aileron_down_lift")) / (up + down)
    of_flaps = -0.20 + tail * arm * downwash / wing  # the flap's own nose-down moment, and its downwash at the tail
    return {
        "CLa": wing + tail * (1.0 - downwash),
        "CLq": 2.0 * tail * arm,
        "CLadot": 2.0 * tail * arm * downwash,
        "CLde": tail * elevator,
        "Cma": body + wing * fact("nacelle_shift") - tail * arm * (1.0 - downwash),
        "Cmq": -2.2 * tail * arm**2,
        "Cmadot": -2.0 * tail * arm**2 * downwash,
        "Cmde": -tail * arm * elevator,
        "Cm_flap_lift": of_flaps,
        "Cm_ground": -tail * arm * downwash / wing,
        "CYb": -fin - 0.10,
        "CYp": -2.0 * fin * fin_up,
        "CYr": 2.0 * fin * fin_arm,
        "CYdr": fin * rudder,
        "Clb": handbook.wing_height_effect(aspect_ratio, fact("wing_height"), width, width, span)
        + fact("outer_share") * handbook.dihedral_effect(wing, fact("taper"), fact("outer_dihedral"))
        - fin * fin_up,
        "Clp": handbook.roll_damping(aspect_ratio, fact("taper")) - 2.0 * fin * fin_up**2,
        "Clr": lift / 4.0 + 2.0 * fin * fin_up * fin_arm,
        "Clda": aileron,
        "Cldr": fin * rudder * fin_up,
        "Cnb": fin * fin_arm + handbook.fuselage_yaw_stiffness(volume, width, width, area, span) + fact("nacelle_yaw"),
        "Cnp": -lift / 8.0 + 2.0 * fin * fin_up * fin_arm,
        "Cnr": -2.0 * fin * fin_arm**2,
        "Cnda": -0.04 * aileron,
        "Cndr": -fin * rudder * fin_arm,
    }


def lift_coefficient(alpha: float, flaps: float, slope: float) -> float:
    """Lift at wing angle of attack ``alpha`` (rad) and a flap setting of ``POLAR`` (deg), the tail included.

    Straight with the handbook's slope, then the parabola that touches it and has its top at the published maximum; a
    soft stall beyond.
    """
    at_zero, top, alpha_top = POLAR[flaps][0], POLAR[flaps][1], math.radians(POLAR[flaps][2])
    knee = 2.0 * (top - at_zero) / slope - alpha_top
    if alpha < knee:
        return at_zero + slope * alpha
    parabola = top - slope / (2.0 * (alpha_top - knee)) * (alpha - alpha_top) ** 2
    return parabola if alpha < alpha_top else max(parabola, 0.8 * top - 0.5 * (alpha - alpha_top))


def extra_drag(alpha: float, flaps: float, slope: float) -> float:
    """Drag of the flaps, profile and induced, and of separated flow: the lift lost times the sine of the angle."""
    deflection = math.radians(flaps)
    area_share = fact("flap_area") / fact("flap_chord_share") / fact("area")
    profile = handbook.flap_profile_drag(fact("flap_chord_share"), area_share, deflection)
    induced = fact("flap_induced") ** 2 * (POLAR[flaps][0] - POLAR[0.0][0]) ** 2
    lost = POLAR[flaps][0] + slope * alpha - lift_coefficient(alpha, flaps, slope)
    return profile + induced + max(0.0, lost) * math.sin(max(0.0, alpha))


def pitch_moment_at_zero(values: dict[str, float]) -> float:
    """Cm that leaves the elevator near neutral at 72 m/s, flaps 15 deg, level, 20 t: the stabiliser is set so."""
    pressure = 0.5 * 1.225 * 72.0**2
    lift = fact("mass") * STANDARD_GRAVITY / (pressure * fact("area"))
    alpha = (lift - POLAR[15.0][0]) / values["CLa"] - fact("incidence")
    flaps = values["Cm_flap_lift"] * (POLAR[15.0][0] - POLAR[0.0][0])
    return -values["Cma"] * alpha - flaps + lift * (0.25 - fact("reference_cg"))


def table(rows: list[tuple[float, ...]], *variables: str) -> str:
    """A JSBSim table; the first row of a two-dimensional one holds its columns."""
    kinds = ("row", "column") if len(variables) == 2 else ("row",)
    heads = "".join(f'<independentVar lookup="{k}">{v}</independentVar>' for k, v in zip(kinds, variables, strict=True))
    body = "\n".join("  ".join(f"{value:.6g}" for value in row) for row in rows)
    return f"<table>{heads}<tableData>\n{body}\n</tableData></table>"


def product(*terms: str | float) -> str:
    """A JSBSim product of numbers, property names and ready XML."""
    return f"<product>{''.join(map(_term, terms))}</product>"


def total(*terms: str | float) -> str:
    """A JSBSim sum."""
    return f"<sum>{''.join(map(_term, terms))}</sum>"


def _term(term: str | float) -> str:
    if isinstance(term, float):
        return f"<value>{term:.8g}</value>"
    return term if term.startswith("<") else f"<property>{term}</property>"


def function(name: str, body: str) -> str:
    """A named JSBSim function."""
    return f'<function name="{name}">{body}</function>\n'


def aerodynamics() -> str:
    """The <aerodynamics> section."""
    values = derivatives()
    slope, incidence = values["CLa"], fact("incidence")
    flaps = tuple(POLAR)
    aspect_ratio = fact("span") ** 2 / fact("area")
    k = handbook.induced_drag_factor(aspect_ratio, fact("oswald"))

    def over_alpha(form: Callable[[float, float], float]) -> str:
        rows: list[tuple[float, ...]] = [flaps]
        for at_wing in ALPHAS:
            alpha = math.radians(at_wing)
            rows.append((at_wing - math.degrees(incidence), *(form(alpha, flap) for flap in flaps)))
        return table(rows, "aero/alpha-deg", "fcs/flap-pos-deg")

    heights = (0.0, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.5)
    above = fact("wing_height") / fact("span")  # the wing is higher than the reference point

    def over_height(form: Callable[[float], float]) -> str:
        return table([(height, form(height + above)) for height in heights], "aero/h_b-mac-ft")

    at_zero = table([(flap, POLAR[flap][0]) for flap in flaps], "fcs/flap-pos-deg")
    of_flaps = table([(flap, POLAR[flap][0] - POLAR[0.0][0]) for flap in flaps], "fcs/flap-pos-deg")
    q, pitching = "velocities/q-aero-rad_sec", "aero/ci2vel"
    p, r, turning = "velocities/p-aero-rad_sec", "velocities/r-aero-rad_sec", "aero/bi2vel"
    alpha, alpha_rate, beta = "aero/alpha-rad", "aero/alphadot-rad_sec", "aero/beta-rad"
    elevator, aileron, rudder = "fcs/elevator-pos-rad", "fcs/aileron-pos-rad", "fcs/rudder-pos-rad"
    force = ("aero/qbar-psf", "metrics/Sw-sqft")
    coefficient = "aero/coefficient/"
    text = [
        function("aero/ground-effect-induced", over_height(handbook.ground_effect_on_induced_drag)),
        function(
            "aero/ground-effect-lift", over_height(lambda height: handbook.ground_effect_on_lift(height, aspect_ratio))
        ),
        function(
            coefficient + "CL-wing",
            product(
                "aero/ground-effect-lift",
                total(
                    at_zero,
                    product(
                        "factors/lift-slope",
                        over_alpha(lambda angle, flap: lift_coefficient(angle, flap, slope) - POLAR[flap][0]),
                    ),
                ),
            ),
        ),
        function(
            coefficient + "CL",
            total(
                coefficient + "CL-wing",
                product(values["CLq"], q, pitching),
                product(values["CLadot"], alpha_rate, pitching),
                product(values["CLde"], "factors/elevator-power", elevator),
            ),
        ),
        function(
            coefficient + "CD",
            product(
                "factors/drag",
                total(
                    fact("zero_lift_drag"),
                    product(fact("gear_drag"), "gear/gear-pos-norm"),
                    over_alpha(lambda angle, flap: extra_drag(angle, flap, slope)),
                    product(k, "aero/ground-effect-induced", coefficient + "CL-wing", coefficient + "CL-wing"),
                ),
            ),
        ),
        function(
            coefficient + "CY",
            total(
                product(values["CYb"], beta),
                product(values["CYp"], p, turning),
                product(values["CYr"], r, turning),
                product(values["CYdr"], "factors/rudder-power", rudder),
            ),
        ),
        function(
            coefficient + "Cl",
            total(
                product(values["Clb"], "factors/dihedral", beta),
                product(values["Clp"], "factors/roll-damping", p, turning),
                product(values["Clr"], r, turning),
                product(values["Clda"], "factors/aileron-power", aileron),
                product(values["Cldr"], "factors/rudder-power", rudder),
            ),
        ),
        function(
            coefficient + "Cm",
            total(
                pitch_moment_at_zero(values),
                product(values["Cm_flap_lift"], of_flaps),
                product(values["Cma"], "factors/pitch-stiffness", alpha),
                product(values["Cmq"], "factors/pitch-damping", q, pitching),
                product(values["Cmadot"], "factors/pitch-damping", alpha_rate, pitching),
                product(values["Cmde"], "factors/elevator-power", elevator),
                product(
                    values["Cm_ground"],
                    coefficient + "CL-wing",
                    "<difference><value>1</value><property>aero/ground-effect-induced</property></difference>",
                ),
            ),
        ),
        function(
            coefficient + "Cn",
            total(
                product(values["Cnb"], "factors/yaw-stiffness", beta),
                product(values["Cnp"], p, turning),
                product(values["Cnr"], "factors/yaw-damping", r, turning),
                product(values["Cnda"], "factors/aileron-power", aileron),
                product(values["Cndr"], "factors/rudder-power", rudder),
            ),
        ),
    ]
    for axis, name, length in (
        ("LIFT", "CL", None),
        ("DRAG", "CD", None),
        ("SIDE", "CY", None),
        ("ROLL", "Cl", "metrics/bw-ft"),
        ("PITCH", "Cm", "metrics/cbarw-ft"),
        ("YAW", "Cn", "metrics/bw-ft"),
    ):
        terms = (*force, coefficient + name) if length is None else (*force, length, coefficient + name)
        text.append(f'<axis name="{axis}">{function(f"aero/{axis.lower()}", product(*terms))}</axis>\n')
    return f"<aerodynamics>\n{''.join(text)}</aerodynamics>\n"


def flight_control() -> str:
    """The <flight_control> section: factors, actuators, flaps, gear, and the lag of the power."""
    factors = "".join(f'<property value="1">factors/{name}</property>\n' for name in FACTORS)
    levers = "".join(f'<property value="0">fcs/throttle-cmd-norm[{engine}]</property>\n' for engine in (0, 1))

    def surface(name: str, gain: float, low: float, high: float) -> str:
        return (
            f'<pure_gain name="fcs/{name}-demand-rad"><input>fcs/{name}-cmd-norm</input><gain>{gain:.8g}</gain>'
            f"<clipto><min>{low:.8g}</min><max>{high:.8g}</max></clipto></pure_gain>\n"
            f'<actuator name="fcs/{name}-actuator"><input>fcs/{name}-demand-rad</input>'
            f"<lag>{fact('actuator_bandwidth'):g}</lag><rate_limit>{fact('actuator_rate'):g}</rate_limit>"
            f"<output>fcs/{name}-pos-rad</output></actuator>\n"
        )

    def travel(name: str, output: str, settings: tuple[tuple[float, float], ...]) -> str:
        steps = "".join(f"<setting><position>{p:g}</position><time>{t:g}</time></setting>" for p, t in settings)
        return (
            f'<kinematic name="{name}-actuator"><input>{name}-cmd-norm</input><traverse>{steps}</traverse>'
            f"<output>{output}</output></kinematic>\n"
        )

    power = "".join(
        function_component(
            f"fcs/power-demand-kw[{engine}]",
            total(
                fact("idle_power") / 1e3,
                product((fact("power") - fact("idle_power")) / 1e3, f"fcs/throttle-cmd-norm[{engine}]"),
            ),
        )
        + f'<actuator name="fcs/power-actuator[{engine}]"><input>fcs/power-demand-kw[{engine}]</input>'
        f"<lag>{1.0 / fact('power_lag'):g}</lag><output>fcs/power-kw[{engine}]</output></actuator>\n"
        for engine in (0, 1)
    )
    first = 15.0 / 38.0 * fact("flap_time")
    channels = {
        "pitch": surface("elevator", fact("elevator_up"), -fact("elevator_up"), fact("elevator_down")),
        "roll": surface("aileron", fact("aileron_travel"), -fact("aileron_travel"), fact("aileron_travel")),
        "yaw": surface("rudder", fact("rudder_travel"), -fact("rudder_travel"), fact("rudder_travel")),
        "flaps": travel("fcs/flap", "fcs/flap-pos-deg", ((0, 0), (15, first), (38, fact("flap_time") - first))),
        "gear": travel("gear/gear", "gear/gear-pos-norm", ((0, 0), (1, fact("gear_time")))),
        "power": power,
    }
    body = "".join(f'<channel name="{name}">\n{text}</channel>\n' for name, text in channels.items())
    return f'<flight_control name="An-26">\n{factors}{levers}{body}</flight_control>\n'


def function_component(name: str, body: str) -> str:
    """A function inside a control channel."""
    return f'<fcs_function name="{name}"><function>{body}</function></fcs_function>\n'


def thrust() -> str:
    """The <external_reactions> section: each propeller's thrust over speed and power, both falling with density.

    At one speed thrust over density depends on power over density only, so the curves of sea level serve at every
    height once the power of a lever falls with the density too, which is assumed here. The density is that over the
    standard sea level: JSBSim's own ``sigma`` divides by that of the day's sea level, which in hot air gives the
    engines the power of a cool day.
    """
    speeds = (0, 10, 20, 30, 40, 50, 55, 60, 65, 70, 75, 80, 90, 100, 120, 150)
    powers = (150, 200, 240, 300, 400, 500, 600, 700, 800, 1000, 1200, 1400, 1700, 2103)
    rows: list[tuple[float, ...]] = [powers]
    for speed in speeds:
        row = [
            handbook.propeller_thrust(
                power * 1e3, float(speed), propeller_loss(speed, power * 1e3), fact("propeller_diameter")
            )
            for power in powers
        ]
        rows.append((speed / FOOT, *(value / POUND_FORCE for value in row)))
    text = ""
    density = f"<quotient>{_term('atmosphere/rho-slugs_ft3')}<value>{SEA_LEVEL_DENSITY!r}</value></quotient>"
    for engine, side in ((0, -1.0), (1, 1.0)):
        curve = table(rows, "velocities/vt-fps", f"fcs/power-kw[{engine}]")
        text += (
            f'<force name="propeller-{engine}" frame="BODY"><function>{product(density, curve)}</function>'
            f'<location unit="M"><x>{fact("engine_x")}</x><y>{side * fact("engine_y")}</y><z>{fact("engine_z")}</z>'
            "</location><direction><x>1</x><y>0</y><z>0</z></direction></force>\n"
        )
    return f"<external_reactions>\n{text}</external_reactions>\n"


def propeller_loss(speed: float, power: float) -> float:
    """Power that the blades' profile takes, W; below 50 m/s stalled blades lose up to 40 % of what they get."""
    return fact("propeller_profile_power") + max(0.0, 1.0 - speed / 50.0) * 0.4 * max(0.0, power - 400e3)


def structure() -> str:
    """Metrics, mass balance and ground contacts, in metres behind the nose, right, up from the centre of gravity."""
    quarter = fact("leading_edge") + 0.25 * fact("chord")
    centre = fact("leading_edge") + fact("reference_cg") * fact("chord")
    ixx, iyy, izz = handbook.radius_of_gyration_inertias(fact("mass"), fact("span"), fact("length"))

    def place(name: str, x: float, y: float = 0.0, z: float = 0.0) -> str:
        return f'<location name="{name}" unit="M"><x>{x:.6g}</x><y>{y:.6g}</y><z>{z:.6g}</z></location>'

    def contact(
        kind: str, name: str, x: float, y: float, z: float, spring: float, damping: float,
        brakes: str = "NONE", steering: float = 0.0,
    ) -> str:  # fmt: skip
        place_of = f'<location unit="M"><x>{x:.6g}</x><y>{y:.6g}</y><z>{z:.6g}</z></location>'
        wheel = f'<rolling_friction>0.02</rolling_friction><max_steer unit="DEG">{steering:g}</max_steer>'
        retract = f"<brake_group>{brakes}</brake_group><retractable>1</retractable>"
        return (
            f'<contact type="{kind}" name="{name}">{place_of}<static_friction>0.8</static_friction>'
            f"<dynamic_friction>0.5</dynamic_friction>{wheel if kind == 'BOGEY' else ''}"
            f'<spring_coeff unit="N/M">{spring:g}</spring_coeff>'
            f'<damping_coeff unit="N/M/SEC">{damping:g}</damping_coeff>{retract if kind == "BOGEY" else ""}</contact>\n'
        )

    half_track, depth = fact("wheel_track") / 2.0, fact("wheel_depth")
    contacts = (
        contact("BOGEY", "nose", fact("nose_wheel"), 0.0, -depth, 130e3, 30e3, steering=fact("steering"))
        + contact("BOGEY", "left", fact("main_wheels"), -half_track, -depth, 735e3, 80e3, "LEFT")
        + contact("BOGEY", "right", fact("main_wheels"), half_track, -depth, 735e3, 80e3, "RIGHT")
        + contact("STRUCTURE", "tail", 20.0, 0.0, -1.0, 500e3, 50e3)
        + contact("STRUCTURE", "belly", centre, 0.0, -1.6, 1e6, 100e3)
        + contact("STRUCTURE", "left tip", centre, -fact("span") / 2.0, 0.6, 200e3, 20e3)
        + contact("STRUCTURE", "right tip", centre, fact("span") / 2.0, 0.6, 200e3, 20e3)
    )
    return (
        f'<metrics><wingarea unit="M2">{fact("area")}</wingarea><wingspan unit="M">{fact("span")}</wingspan>'
        f'<chord unit="M">{fact("chord")}</chord>{place("AERORP", quarter)}{place("EYEPOINT", 2.0, -0.5, 1.0)}'
        f"{place('VRP', centre)}</metrics>\n"
        f'<mass_balance><ixx unit="KG*M2">{ixx:.6g}</ixx><iyy unit="KG*M2">{iyy:.6g}</iyy>'
        f'<izz unit="KG*M2">{izz:.6g}</izz><emptywt unit="KG">{fact("mass"):g}</emptywt>{place("CG", centre)}'
        "</mass_balance>\n"
        f"<ground_reactions>\n{contacts}</ground_reactions>\n"
    )


FACTORS = (
    "lift-slope",
    "drag",
    "pitch-stiffness",
    "pitch-damping",
    "yaw-stiffness",
    "yaw-damping",
    "dihedral",
    "roll-damping",
    "elevator-power",
    "aileron-power",
    "rudder-power",
)


def build() -> str:
    """The whole model."""
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n'
        "<!-- Written by build.py beside this file from public data and handbook forms; do not edit. -->\n"
        '<fdm_config name="An-26" version="2.0" release="ALPHA">\n'
        "<fileheader><author>shortfinal</author><description>An-26 on approach: flaps 0/15/38, gear, ground effect, "
        "soft stall, two AI-24VT as thrust tables. No slipstream, no propeller torque, no fuel burn.</description>"
        "</fileheader>\n"
        f"{structure()}{flight_control()}{aerodynamics()}{thrust()}</fdm_config>\n"
    )


if __name__ == "__main__":
    Path(__file__).with_name("an26.xml").write_text(build(), encoding="utf-8")
