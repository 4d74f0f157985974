"""Pseudo-Bayes filter of an angle whose measurement accuracy switches, in the order of Kychak et al. 2011.

Every measurement is taken with one of several accuracies, of which only the probabilities are known. Each step keeps
one Gaussian per accuracy and their probabilities, and the next step starts from the single Gaussian with their
moments. Measurements that were missed belong to the same model: an accuracy that is ever worse is a missing
measurement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from tracking.gaussian import Gaussian, Innovation, Mixture, lift, merge, predict, update_mixture
from tracking.trackers.elevation import PERIOD, increments, pick, row_of

Array = Any


@dataclass(frozen=True)
class BeamNoise:
    """Variance of one angle of a scanning beam, live from the signal-to-noise ratio [Kychak 2011, beam-noise formula].

    The ratio falls by 6 dB per doubling of the distance, from ``snr`` at ``at_distance``. The antenna's and receiver's
    constants are the printed ones; the ratio and the floor are not printed and have to be given: the printed variance
    (0.06 deg)^2 follows from 5.38 dB, and the print's two variances fit no free-space law at all.
    """

    snr: Annotated[float, "dB"]
    at_distance: Annotated[float, "m"]
    floor: Annotated[float, "rad"]  # standard deviation that no signal improves on
    beamwidth: Annotated[float, "rad"] = math.radians(1.0)  # at half power
    slope: float = 2.08  # K_m, of the antenna pattern
    bandwidth: Annotated[float, "Hz"] = 150e3  # of the intermediate-frequency amplifier
    pulse: Annotated[float, "s"] = 100e-6  # both passes of the beam
    detection_loss: float = 1.25  # Z_c

    def __post_init__(self) -> None:
        for name in ("at_distance", "beamwidth", "slope", "bandwidth", "pulse", "detection_loss"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be above 0")
        if not (math.isfinite(self.snr) and self.floor >= 0.0):
            raise ValueError("snr must be finite and floor must not be negative")

    def of_ratio(self, ratio: Array) -> Array:
        """Variance (rad2) of the receiver noise alone at a power ratio of signal to noise."""
        looks = 2.0 * self.bandwidth * self.pulse / self.detection_loss
        return (self.beamwidth / self.slope) ** 2 * (ratio + 1.0) / ratio**2 / looks

    def variance(self, distance: Array) -> Array:
        """Variance (rad2) at a distance (m) from the beacon."""
        ratio = 10.0 ** (0.1 * self.snr) * (self.at_distance / distance) ** 2
        return self.floor**2 + self.of_ratio(ratio)


@dataclass(frozen=True)
class SwitchingNoise:
    """One-step pseudo-Bayes filter of an elevation with switching accuracy [Kychak 2011, eqs. (3)-(14)].

    The i-th hypothesis multiplies the standard deviation of the measurement by ``factors[i]``. The accuracy is a Markov
    chain (11); equal rows of ``switching`` make it independent from step to step, which is (12). The defaults are the
    print's two hypotheses.

    Erratum: (8) printed the sum over the accuracies as denominator, used the integral over the state, because (8) is
    one hypothesis' posterior.
    Erratum: (12) printed the likelihood of y(k) given y up to k, used given y up to k-1, because a measurement does
    not predict itself.
    Erratum: text of (6) sums i = 0..N, used 1..N, because there are N accuracies.

    Parameters
    ----------
    measured : names of the rows of z; the one that ends with ".elevation" is used.
    switching : probabilities of the accuracy one period later, rows "from", columns "to".
    rate_increment, period : the process noise of `tracking.trackers.elevation.Elevation`, order 2.
    """

    measured: Annotated[tuple[str, ...], "given"]
    factors: tuple[float, ...] = (1.0, 30.0)
    switching: tuple[tuple[float, ...], ...] = ((0.8, 0.2), (0.8, 0.2))
    period: Annotated[float, "s"] = PERIOD
    rate_increment: Annotated[float, "rad/s"] = math.radians(0.01)

    def __post_init__(self) -> None:
        count = len(self.factors)
        if not count or not all(math.isfinite(factor) and factor > 0.0 for factor in self.factors):
            raise ValueError("factors must be positive and finite; a missing measurement is NaN in z")
        if len(self.switching) != count or any(len(row) != count for row in self.switching):
            raise ValueError(f"switching must have {count} rows of {count} probabilities")
        if any(p < 0.0 for row in self.switching for p in row):
            raise ValueError("a probability of switching is negative")
        if any(abs(sum(row) - 1.0) > 1e-9 for row in self.switching):
            raise ValueError("the rows of switching must each sum to one")
        if not (self.period > 0.0 and self.rate_increment >= 0.0):
            raise ValueError("period must be above 0 and rate_increment must not be negative")
        row_of("elevation", self.measured)

    @property
    def channels(self) -> tuple[str, ...]:
        name = self.measured[row_of("elevation", self.measured)]
        return name, f"{name}_rate"

    @property
    def modes(self) -> tuple[str, ...]:
        """The accuracies."""
        return tuple(f"noise × {factor:g}" for factor in self.factors)

    @cached_property
    def _switching(self) -> Array:
        return np.array(self.switching)

    @cached_property
    def _variances(self) -> Array:
        return np.square(self.factors)

    def begin(self, prior: Gaussian) -> Mixture:
        """All hypotheses at the prior, with the stationary probabilities of the chain."""
        if len(prior.mean) != 2:
            raise ValueError(f"the prior must have the 2 states {', '.join(self.channels)}")
        return self._split(prior, lift(stationary(self._switching), 1, np.ndim(prior.mean) - 1))

    def step(self, state: Mixture, dt: float, z: Any | None, R: Any | None) -> tuple[Mixture, Innovation | None]:
        weights = state.weights
        if dt > 0.0:
            chain = np.linalg.matrix_power(self._switching, max(1, round(dt / self.period)))
            weights = np.einsum("ji,j...->i...", chain, weights)  # (11)
        moved = predict(merge(state), *increments(2, dt, self.period, self.rate_increment))
        state = self._split(moved, weights)
        if z is None:
            return state, None
        angle, R = pick(z, R, row_of("elevation", self.measured), moved.mean)
        batch = np.ndim(z) - 1
        R = lift(R, 2, batch)[:, :, None] * lift(self._variances, 1, batch)  # (5)
        return update_mixture(state, angle, np.eye(1, 2), R)  # (8)-(10)

    def estimate(self, state: Mixture) -> Mixture:
        """Mixture whose weights are the probabilities of the accuracies and whose moments are (13), (14)."""
        return state

    def _split(self, gaussian: Gaussian, weights: Array) -> Mixture:
        """The same Gaussian under every hypothesis, in a hypothesis axis of size one."""
        cov = lift(gaussian.cov, 2, np.ndim(gaussian.mean) - 1)
        return Mixture(weights, gaussian.mean[:, None], cov[:, :, None])


def stationary(switching: Array) -> Array:
    """Probabilities that a chain keeps; rows of ``switching`` (N, N) are "from"."""
    count = len(switching)
    balance = np.vstack([switching.T - np.eye(count), np.ones(count)])
    solution = np.linalg.lstsq(balance, np.append(np.zeros(count), 1.0), rcond=None)[0]
    return np.clip(solution, 0.0, None) / np.clip(solution, 0.0, None).sum()
