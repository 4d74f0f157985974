"""Closed forms of preliminary design: from the geometry of an aircraft to its stability and control derivatives.

Moments are per radian and per p b/2V, q c/2V, r b/2V; areas m2, lengths m, angles rad. Each form is the textbook's
simplest, good to 10-30 % by comparison with flown aircraft; that is what a built model can honestly claim.
"""

from __future__ import annotations

import math

import numpy as np

HARMONICS = 20  # of the load over the span; ten change no derivative by 1e-5


def lift_curve_slope(aspect_ratio: float, half_chord_sweep: float, mach: float) -> float:
    """Lift curve slope of a wing, 1/rad [DATCOM 4.1.3.2, Polhamus]."""
    beta = 1.0 - mach * mach
    root = math.sqrt(aspect_ratio**2 * beta * (1.0 + math.tan(half_chord_sweep) ** 2 / beta) + 4.0)
    return 2.0 * math.pi * aspect_ratio / (2.0 + root)


def downwash_slope(aspect_ratio: float, taper: float, tail_arm: float, tail_height: float, span: float) -> float:
    """d(downwash)/d(angle of attack) at the tail of an unswept wing [DATCOM 4.4.1]."""
    of_aspect_ratio = 1.0 / aspect_ratio - 1.0 / (1.0 + aspect_ratio**1.7)
    of_taper = (10.0 - 3.0 * taper) / 7.0
    of_place = (1.0 - tail_height / span) / (2.0 * tail_arm / span) ** (1.0 / 3.0)
    slope: float = 4.44 * (of_aspect_ratio * of_taper * of_place) ** 1.19
    return slope


def flap_effectiveness(chord_share: float, viscous_efficiency: float = 0.75) -> float:
    """d(angle of attack)/d(deflection) of a plain control surface [thin aerofoil theory]."""
    root = math.sqrt(chord_share * (1.0 - chord_share))
    return viscous_efficiency * 2.0 / math.pi * (root + math.asin(math.sqrt(chord_share)))


def induced_drag_factor(aspect_ratio: float, oswald: float) -> float:
    """k of CD = CD0 + k CL^2 [Prandtl]."""
    return 1.0 / (math.pi * aspect_ratio * oswald)


def ground_effect_on_induced_drag(height_over_span: float) -> float:
    """Share of the induced angle that is left over the ground [McCormick 1995, eq. (5.78)]."""
    return (16.0 * height_over_span) ** 2 / (1.0 + (16.0 * height_over_span) ** 2)


def ground_effect_on_lift(height_over_span: float, aspect_ratio: float) -> float:
    """Lift curve slope over that of free air, by the lifting line with the induced angle of McCormick."""
    induced = 2.0 / aspect_ratio  # a0 / (pi A) with a0 = 2 pi
    return (1.0 + induced) / (1.0 + induced * ground_effect_on_induced_drag(height_over_span))


def flap_profile_drag(chord_share: float, area_share: float, deflection: float) -> float:
    """Profile drag of slotted flaps [Young 1953, as in McCormick eq. (3.50)]."""
    drag: float = 0.9 * chord_share**1.38 * area_share * math.sin(deflection) ** 2
    return drag


def fuselage_pitch_stiffness(width: float, length: float, chord: float, area: float) -> float:
    """Cm_alpha of a fuselage whose wing quarter chord lies at 0.35-0.4 of its length [Raymer eq. (16.25)]."""
    return 0.018 * width**2 * length / (chord * area) * 180.0 / math.pi


def antisymmetric_slope(aspect_ratio: float) -> float:
    """Section lift slope of a wing whose two halves lift in opposite directions, 1/rad [lifting line, half span]."""
    return 2.0 * math.pi * aspect_ratio / (aspect_ratio + 4.0)


def roll_damping(aspect_ratio: float, taper: float) -> float:
    """Clp of an unswept wing [strip theory with the antisymmetric slope]."""
    return -antisymmetric_slope(aspect_ratio) / 12.0 * (1.0 + 3.0 * taper) / (1.0 + taper)


def dihedral_effect(slope: float, taper: float, dihedral: float) -> float:
    """Clb of dihedral [Etkin and Reid, app. B.11, strip theory]."""
    return -slope * dihedral / 6.0 * (1.0 + 2.0 * taper) / (1.0 + taper)


def wing_height_effect(aspect_ratio: float, height: float, depth: float, width: float, span: float) -> float:
    """Clb of a wing ``height`` above the axis of the fuselage [Raymer eq. (16.41), negative for a high wing]."""
    return -1.2 * math.sqrt(aspect_ratio) * height * (depth + width) / span**2


def fuselage_yaw_stiffness(volume: float, depth: float, width: float, area: float, span: float) -> float:
    """Cnb of a fuselage [Raymer eq. (16.50)]."""
    return -1.3 * volume / (area * span) * depth / width


def rolling_load(aspect_ratio: float, taper: float) -> np.ndarray:
    """(n,) even Fourier coefficients A2, A4, ... of the load of an unswept wing whose twist is y / (b/2), 1/rad.

    Lifting line: the circulation is 2 b V sum A_k sin k theta at y = b/2 cos theta [Glauert 1926, ch. XI], with the
    section slope of thin aerofoils. Roll damping is -pi/4 aspect_ratio A2.
    """
    k = np.arange(2, 2 * HARMONICS + 1, 2)
    theta = np.arange(1, HARMONICS + 1) * (math.pi / (2 * HARMONICS + 1))
    spanwise = np.cos(theta)
    chord = 2.0 / (aspect_ratio * (1.0 + taper)) * (1.0 - (1.0 - taper) * spanwise)  # of the span
    mu = 0.5 * math.pi * chord
    induced = np.sin(np.outer(theta, k)) * (np.outer(mu, k) + np.sin(theta)[:, None])
    return np.asarray(np.linalg.solve(induced, mu * spanwise * np.sin(theta)))


def aileron_power(aspect_ratio: float, taper: float, inner: float, outer: float, effectiveness: float) -> float:
    """Clda of both ailerons, each deflected by the full angle, from ``inner`` to ``outer`` (of the half span).

    By the reverse-flow theorem [Heaslet and Spreiter 1952] the rolling moment of a twist is that twist over the load
    of the rolling wing, so the moment of ailerons is as good as the load, however their ends lie.
    """
    load = rolling_load(aspect_ratio, taper)
    k = np.arange(2, 2 * len(load) + 1, 2)

    def up_to(spanwise: float) -> np.ndarray:
        theta = math.acos(spanwise)
        return np.asarray(np.sin((k - 1) * theta) / (k - 1) - np.sin((k + 1) * theta) / (k + 1))

    return effectiveness * aspect_ratio * float(load @ (up_to(inner) - up_to(outer)))


def propeller_thrust(
    power: float, speed: float, profile_power: float, diameter: float, density: float = 1.225
) -> float:
    """Thrust, N, of a propeller that gets ``power`` (W): what its profile takes is lost, the rest feeds the slipstream.

    Momentum theory: power - profile_power = T (V + v) with T = 2 rho A (V + v) v; below idle the propeller brakes.
    """
    useful = power - profile_power
    disc = 2.0 * density * math.pi / 4.0 * diameter**2
    low, high = -0.49 * speed, 400.0
    if useful < disc * (speed + low) ** 2 * low:
        return disc * (speed + low) * low
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if disc * (speed + middle) ** 2 * middle < useful else (low, middle)
    return disc * (speed + low) * low


def radius_of_gyration_inertias(mass: float, span: float, length: float) -> tuple[float, float, float]:
    """(Ixx, Iyy, Izz) kg m2 of a twin turboprop transport [Raymer table 16.1: 0.24, 0.34, 0.39]."""
    return (
        mass * (0.24 * span) ** 2 / 4.0,
        mass * (0.34 * length) ** 2 / 4.0,
        mass * (0.39 * (span + length) / 2.0) ** 2 / 4.0,
    )
