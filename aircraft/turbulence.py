"""Dryden turbulence: random gusts with the spectra and intensities of MIL-F-8785C, frozen in the air flown through."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aircraft.turbulence_intensity import intensity
from aircraft.wind import SteadyWind

BLOCK = 12  # steps between two looks at height and airspeed: 0.1 s, 6 m of flight
ROOT_THREE = math.sqrt(3.0)


def along_spectrum(frequency: Any, airspeed: float, sigma: float, length: float) -> Any:
    """Density of the gust along the mean wind over circular frequency >= 0, (m/s)2/(rad/s) [MIL-F-8785C, 3.7.2.2]."""
    x = length * frequency / airspeed
    return 2.0 * sigma * sigma * length / (np.pi * airspeed) / (1.0 + x * x)


def across_spectrum(frequency: Any, airspeed: float, sigma: float, length: float) -> Any:
    """Density of the gusts across the mean wind and upwards, (m/s)2/(rad/s) [MIL-F-8785C, 3.7.2.2]."""
    x = length * frequency / airspeed
    return sigma * sigma * length / (np.pi * airspeed) * (1.0 + 3.0 * x * x) / (1.0 + x * x) ** 2


class Turbulence:
    """Dryden turbulence [MIL-F-8785C, 3.7.2.2 and 3.7.3] on a steady wind; one object per flight.

    Along, across and up are those of ``course``: the mean wind's where there is one, else the runway's. Shaping filters
    are discretised exactly for white noise: each state keeps unit variance whatever the step, the airspeed or the
    height, so changing conditions only rescale. Rows of the noise belong to steps of 1/``rate`` s, however the time is
    asked for. The gradient of the gust over the span (rolling gusts) is left out.

    Parameters
    ----------
    wind_at_20_ft : mean wind at 20 ft that sets the intensity, m/s; ``turbulence_intensity.INTENSITIES`` has the
        standard three. It is independent of the wind that drifts the aircraft.
    generator : source of all its noise.
    mean : wind added to the turbulence.
    course : of the longitudinal axis, rad; None = the way ``mean`` moves.
    rate : steps per second, Hz.
    """

    def __init__(
        self,
        wind_at_20_ft: float,
        generator: np.random.Generator,
        mean: SteadyWind | None = None,
        course: float | None = None,
        rate: float = 120.0,
    ) -> None:
        if not wind_at_20_ft >= 0.0 or not math.isfinite(wind_at_20_ft):
            raise ValueError(f"wind_at_20_ft must not be negative, not {wind_at_20_ft} m/s")
        if not rate > 0.0:
            raise ValueError(f"rate must be positive, not {rate} Hz")
        self._wind_at_20_ft = wind_at_20_ft
        self._generator = generator
        self._mean = mean or SteadyWind()
        axis = math.atan2(self._mean.east, self._mean.north) if course is None else course
        self._axis = (math.cos(axis), math.sin(axis))
        self._rate = rate
        self._next = 0  # step that the next block begins with
        self._state: tuple[float, float, float, float, float] | None = None
        self._block: list[tuple[float, float, float]] = []

    def velocity(
        self, time: float, position: tuple[float, float, float], airspeed: float
    ) -> tuple[float, float, float]:
        """(north, east, up), m/s, at ``time`` (s), which may go back by up to 0.1 s but not to an earlier block."""
        step = math.floor(time * self._rate + 0.5)
        while step >= self._next:
            self._advance(position[2], airspeed)
        return self._block[step - self._next]  # counted from the end of the block

    def _advance(self, height: float, airspeed: float) -> None:
        """The next block of steps, all with the intensity and airspeed of its beginning.

        Along is a first-order filter, across and up are second-order filters with a zero.
        """
        now = intensity(height, self._wind_at_20_ft)
        speed = max(airspeed, 1.0) / self._rate
        decay = math.exp(-speed / now.length_along)
        noise = math.sqrt(1.0 - decay * decay)
        fa, ha, a11, a21, a22 = _second_order(speed / now.length_along)
        fu, hu, u11, u21, u22 = _second_order(speed / now.length_up)
        sigma, sigma_up = now.sigma_along, now.sigma_up
        cosine, sine = self._axis
        north, east, rising = self._mean
        rows = iter(self._generator.standard_normal((BLOCK, 5)).tolist())
        block = []
        if self._state is None:  # stationary from the first step: the states are drawn from their own covariance
            x, n1, n2, n3, n4 = self._generator.standard_normal(5).tolist()
            across, across2, up, up2 = n1 * _P11, n1 * _P21 + n2 * _P22, n3 * _P11, n3 * _P21 + n4 * _P22
        else:
            x, across, across2, up, up2 = self._state
        for n1, n2, n3, n4, n5 in rows:
            x = decay * x + noise * n1
            across, across2 = fa * across + a11 * n2, fa * (ha * across + across2) + a21 * n2 + a22 * n3
            up, up2 = fu * up + u11 * n4, fu * (hu * up + up2) + u21 * n4 + u22 * n5
            along = sigma * x
            right = sigma * (ROOT_THREE * across + (1.0 - ROOT_THREE) * across2)
            block.append(
                (
                    north + cosine * along - sine * right,
                    east + sine * along + cosine * right,
                    rising + sigma_up * (ROOT_THREE * up + (1.0 - ROOT_THREE) * up2),
                )
            )
        self._state = (x, across, across2, up, up2)
        self._block = block
        self._next += BLOCK


# Second-order filter (1 + sqrt(3) s) / (1 + s)^2 in time over (length / airspeed): x1 = 1/(1+s) noise, x2 = 1/(1+s) x1,
# output sqrt(3) x1 + (1 - sqrt(3)) x2. Its stationary covariance is [[1/2, 1/4], [1/4, 1/4]], which gives the output
# unit variance; these are the entries of its Cholesky factor.
_P11, _P21, _P22 = math.sqrt(0.5), 0.25 / math.sqrt(0.5), math.sqrt(0.125)


def _second_order(step: float) -> tuple[float, float, float, float, float]:
    """Transition exp(-h) [[1, 0], [h, 1]] and Cholesky factor of the noise P - Phi P Phi' for a step h."""
    f = math.exp(-step)
    square = f * f
    q11 = 0.5 * (1.0 - square)
    q12 = 0.25 - square * (0.25 + 0.5 * step)
    q22 = 0.25 - square * (0.25 + 0.5 * step + 0.5 * step * step)
    root = math.sqrt(q11)
    return f, step, root, q12 / root, math.sqrt(max(q22 - q12 * q12 / q11, 0.0))
