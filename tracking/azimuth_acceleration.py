"""What load factors and angles of an aircraft say of the second derivative of its azimuth.

Axes of the paper (GOST 20058), used here and in the tracker that is built on it only: X along the radar's zero azimuth,
Y up, Z to the right; course phi counter-clockwise from above, path angle theta up, bank gamma right wing down. Gravity
has no horizontal component, so the horizontal acceleration needs no term of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tracking.motion import GRAVITY

Array = Any


def horizontal_acceleration(
    n_xa: Array, n_ya: Array, n_za: Array, gamma: Array, theta: Array, phi: Array
) -> tuple[Array, Array]:
    """Acceleration (a_X, a_Z), m/s2, from load factors along the path, up and to the right [Glistin, eq. (1)].

    Load factors belong to the wind axes and the angles to the path through the air: with body axes or the ground
    track the result is wrong by tenths of m/s2 in a crosswind.
    """
    up = n_ya * np.cos(gamma) - n_za * np.sin(gamma)
    right = n_ya * np.sin(gamma) + n_za * np.cos(gamma)
    along = n_xa * np.cos(theta) - up * np.sin(theta)
    return (
        GRAVITY * (along * np.cos(phi) + right * np.sin(phi)),
        GRAVITY * (-along * np.sin(phi) + right * np.cos(phi)),
    )


def published_azimuth_acceleration(
    a_X: Array, a_Z: Array, line_of_sight: Array, distance: Array, elevation: Array
) -> tuple[Array, Array]:
    """Azimuth acceleration as printed, and where its radicand had to be clamped [Glistin, eq. (1)].

    The sum of the components is squared, so the value depends on where the axes point; its sign is lost; the
    acceleration along the line of sight misses the centripetal part, and the Coriolis term is absent. It is here to
    be measured.

    Erratum: printed a radicand that is negative on half of a base turn, used zero there, because its root is no number.
    Erratum: first print sets the root's parentheses around the arctangent, used the ratio inside, as in the second
    print, because an angle over a distance is no angle.
    """
    return _root((a_X + a_Z) ** 2, line_of_sight, distance, elevation)


def intended_azimuth_acceleration(
    a_X: Array, a_Z: Array, line_of_sight: Array, distance: Array, elevation: Array
) -> tuple[Array, Array]:
    """Azimuth acceleration by the sum of squares that (1) must have meant, and where it was clamped [Glistin, eq. (1)].

    Erratum: printed (a_X + a_Z)^2, used a_X^2 + a_Z^2, because only that does not depend on the axes. Sign, Coriolis
    and centripetal terms are still missing.
    """
    return _root(a_X**2 + a_Z**2, line_of_sight, distance, elevation)


def _root(square: Array, line_of_sight: Array, distance: Array, elevation: Array) -> tuple[Array, Array]:
    radicand = square - (line_of_sight * np.cos(elevation)) ** 2
    return np.arctan(np.sqrt(np.maximum(radicand, 0.0)) / (distance * np.cos(elevation))), radicand < 0.0


def corrected_azimuth_acceleration(
    a_X: Array,
    a_Z: Array,
    azimuth: Array,
    azimuth_rate: Array,
    distance: Array,
    distance_rate: Array,
    elevation: Array,
    elevation_rate: Array,
) -> Array:
    """Second derivative of the azimuth (rad/s2), from X towards Z, distance slant: exact [Glistin, eq. (1)].

    Erratum: printed an unsigned root without the Coriolis term, used the acceleration across the line of sight less
    2 rho' w over the horizontal distance rho, because that is the derivative of the azimuth of a point.
    """
    rho = distance * np.cos(elevation)
    rho_rate = distance_rate * np.cos(elevation) - distance * np.sin(elevation) * elevation_rate
    across = a_Z * np.cos(azimuth) - a_X * np.sin(azimuth)
    return (across - 2.0 * rho_rate * azimuth_rate) / rho
