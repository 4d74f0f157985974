"""What trackers are given and what they give back, and the only loop over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from tracking.gaussian import Gaussian, Innovation, Mixture


@dataclass(frozen=True)
class Measurements:
    """A record of measurements at the union of the epochs of a tracker's sensors.

    z = NaN where a channel is absent at that epoch. ``B`` is the batch of noise draws; R has no draw axis where the
    accuracy is the same for all draws.
    """

    channels: tuple[str, ...]  # m names, "<sensor>.<quantity>"
    time: Any  # (k,) s, when it was true
    arrival: Any  # (k,) s, when it was known
    z: Any  # (k, m, *B)
    R: Any  # (k, m, m, *C)


class Track(NamedTuple):
    """A tracker's estimates after each update."""

    channels: tuple[str, ...]  # n names of the state components
    time: Any  # (k,)
    mean: Any  # (k, n, *B)
    cov: Any  # (k, n, n, *C)
    white: Any  # (k, m, *B), NaN where nothing was measured
    nis: Any  # (k, *B)
    log_likelihood: Any  # (k, *B)
    model_probabilities: Any | None  # (k, M, *B)


class Tracker(Protocol):
    """Anything that turns measurements into estimates; its state is passed, never hidden."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the components of ``estimate``: ("north", "north_rate", "east", "east_rate") for cartesian."""
        ...

    def begin(self, prior: Gaussian) -> Any:
        """State before the first measurement."""
        ...

    def step(self, state: Any, dt: float, z: Any | None, R: Any | None) -> tuple[Any, Innovation | None]:
        """Predict by dt (s), then update with z (m, *B) where it is not None."""
        ...

    def estimate(self, state: Any) -> Gaussian | Mixture:
        """What is believed now, in the declared space."""
        ...
