"""Azimuth channel aided by downlinked load factors, in the order of Glistin and Panasyuk.

Nine small filters that do not know of each other's errors: range, elevation and azimuth of a radar, and three load
factors, bank, path angle and course from the aircraft. The azimuth's second derivative is computed from all the
others. Each block steps when its own channel is measured - the radar's at the rate of the radar, a downlinked
quantity between scans for itself alone - and is extrapolated where it is looked at in between.

The axes are those of `tracking.azimuth_acceleration`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from tracking.azimuth_acceleration import (
    corrected_azimuth_acceleration,
    horizontal_acceleration,
    intended_azimuth_acceleration,
    published_azimuth_acceleration,
)
from tracking.gaussian import Gaussian, Innovation, lift, predict, update
from tracking.integrators import ahead, integrators
from tracking.measurement import wrap
from tracking.trackers.elevation import row_of

Array = Any

RADAR = ("range", "elevation", "azimuth")
DOWNLINK = (
    "load_factor_forward",
    "load_factor_up",
    "load_factor_right",
    "aerodynamic_bank",
    "flight_path_angle",
    "air_course",
)
BLOCKS = (*RADAR, *DOWNLINK)
ANGLES = frozenset(("elevation", "azimuth", "aerodynamic_bank", "flight_path_angle", "air_course"))
MOST_STEPS = 1000  # of the azimuth, in one silence

Aid = Literal["published", "intended", "corrected", "corrected_residual"]


class Block(NamedTuple):
    """One quantity with its derivatives, as of ``clock`` seconds ago.

    The six downlinked quantities have one structure and stand side by side in the first batch axis, each with its
    own clock.
    """

    gaussian: Gaussian
    clock: Array  # s, () or (*B) where runs missed different measurements; (6, ...) of the downlink

    @property
    def mean(self) -> Array:
        """(n, *B)."""
        return self.gaussian.mean

    @property
    def cov(self) -> Array:
        """(n, n, *C)."""
        return self.gaussian.cov


class Blocks(NamedTuple):
    """All that is estimated."""

    range: Block
    elevation: Block
    azimuth: Block
    downlink: Block


class LoadFactorState(NamedTuple):
    """The blocks, and the azimuth acceleration last computed for each run."""

    blocks: Blocks
    aid: Array  # (*B) rad/s2, NaN = unaided
    clamped: Array  # (*B) bool, where its radicand was negative


@dataclass(frozen=True)
class LoadFactor:
    """Nine decoupled filters, the azimuth driven by the others [Glistin, eqs. (1)-(19) and the algorithms after them].

    Gains come from each block's own Riccati recursion and do not look at the data. The third state of the azimuth
    block is its acceleration. ``published``, ``intended`` and ``corrected`` set it to the value computed one step
    earlier, as printed (its gain is then exactly zero); ``corrected_residual`` computes it for now and adds a
    first-order Markov residual with a gain of its own, of which the others are the limit of no correlation. When the
    downlink falls silent the residual takes over the last computed value and the block goes on with kinematic noise;
    when it speaks again the computed value measures the acceleration up to the residual.

    Erratum: printed eps_o(k) + K in the first three lines of the azimuth block, used the extrapolated values, because
    the residual is taken against them.
    Erratum: printed no residual of the bank, used measured minus extrapolated, because its gain multiplies it.

    Parameters
    ----------
    measured : names of the rows of z: range, azimuth and elevation of one radar, and the six of ``DOWNLINK``.
    zero_azimuth : course of the radar's zero azimuth, rad clockwise from north.
    azimuth_density, kinematic_density, range_density : of the unknown part of an acceleration at low frequency, with
        and without aid; elevation_density, angle_density, load_factor_density (1/s3) : of the noise that drives a rate.
    dropout : a downlinked quantity that has been silent for longer no longer aids.
    longest_step : the azimuth is carried on at least so often.
    """

    measured: Annotated[tuple[str, ...], "given"]
    zero_azimuth: Annotated[float, "given"]
    azimuth_acceleration: Aid = "corrected_residual"
    azimuth_density: Annotated[float, "rad2/s3"] = 2e-9
    azimuth_correlation_time: Annotated[float, "s"] = 10.0
    kinematic_density: Annotated[float, "rad2/s3"] = 3e-6
    kinematic_correlation_time: Annotated[float, "s"] = 20.0
    range_density: Annotated[float, "m2/s3"] = 1e4  # the Coriolis term takes a lagging range rate for an acceleration
    range_correlation_time: Annotated[float, "s"] = 20.0
    elevation_density: Annotated[float, "rad2/s3"] = 1e-8
    elevation_correlation_time: Annotated[float, "s"] = 50.0
    angle_density: Annotated[float, "rad2/s3"] = 2e-3
    load_factor_density: float = 1e-3
    downlink_correlation_time: Annotated[float, "s"] = 5.0
    dropout: Annotated[float, "s"] = 2.0
    longest_step: Annotated[float, "s"] = 1.0

    def __post_init__(self) -> None:
        for quantity in BLOCKS:
            row_of(quantity, self.measured)
        if len({self._name(quantity).rpartition(".")[0] for quantity in RADAR}) != 1:
            raise ValueError("range, azimuth and elevation must be those of one radar")
        for name in (
            "azimuth_correlation_time",
            "kinematic_correlation_time",
            "range_correlation_time",
            "elevation_correlation_time",
            "downlink_correlation_time",
            "dropout",
            "longest_step",
        ):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be above 0")
        for name in (
            "azimuth_density",
            "kinematic_density",
            "range_density",
            "elevation_density",
            "angle_density",
            "load_factor_density",
        ):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must not be negative")

    def _name(self, quantity: str) -> str:
        return self.measured[row_of(quantity, self.measured)]

    @property
    def channels(self) -> tuple[str, ...]:
        names = [self._name(quantity) for quantity in ("range", "azimuth", "elevation")]
        return tuple(f"{name}{suffix}" for name in names for suffix in ("", "_rate"))

    @cached_property
    def _rows(self) -> dict[str, int]:
        return {quantity: row_of(quantity, self.measured) for quantity in RADAR}

    @cached_property
    def _downlink(self) -> list[int]:
        return [row_of(quantity, self.measured) for quantity in DOWNLINK]

    @cached_property
    def _dynamics(self) -> dict[str, tuple[int, float, Any]]:
        """Order, correlation time and density of the driving noise of each block but the azimuth's."""
        long = self.range_correlation_time
        densities = [self.angle_density if quantity in ANGLES else self.load_factor_density for quantity in DOWNLINK]
        return {
            "range": (3, long, self.range_density / long**2),
            "elevation": (2, self.elevation_correlation_time, self.elevation_density),
            "downlink": (2, self.downlink_correlation_time, np.array(densities)),
        }

    def begin(self, prior: Gaussian) -> LoadFactorState:
        """Range, azimuth and elevation, each with its rate, at the prior; the downlink not yet heard."""
        if len(prior.mean) != 6:
            raise ValueError(f"the prior must have the 6 states {', '.join(self.channels)}")
        batch = np.ndim(prior.mean) - 1
        accelerations = {
            "range": self.range_density / (2.0 * self.range_correlation_time),
            "azimuth": self.kinematic_density / (2.0 * self.kinematic_correlation_time),
        }
        begun = {}
        for first, quantity in zip((0, 2, 4), ("range", "azimuth", "elevation"), strict=True):
            mean, cov = prior.mean[first : first + 2], prior.cov[first : first + 2, first : first + 2]
            if quantity in accelerations:
                mean = np.concatenate([mean, np.zeros_like(mean[:1])])
                larger = np.zeros((3, 3, *cov.shape[2:]))
                larger[:2, :2], larger[2, 2] = cov, accelerations[quantity]
                cov = larger
            begun[quantity] = Block(Gaussian(mean, cov), 0.0)
        _, memory, densities = self._dynamics["downlink"]
        cov = np.zeros((2, 2, 6))
        cov[0, 0] = [math.pi**2 if quantity == "air_course" else 0.25 for quantity in DOWNLINK]
        cov[1, 1] = 0.5 * densities * memory
        mean = np.zeros((2, 6))
        mean[0] = [float(quantity == "load_factor_up") for quantity in DOWNLINK]
        silence = np.full((6, *(1,) * batch), 2.0 * self.dropout)  # as one that has been silent for too long
        begun["downlink"] = Block(Gaussian(lift(mean, 2, batch), lift(cov, 3, batch)), silence)
        none = np.full(prior.mean.shape[1:], np.nan)
        return LoadFactorState(Blocks(**begun), none, np.zeros(none.shape, dtype=bool))

    def step(
        self, state: LoadFactorState, dt: float, z: Any | None, R: Any | None
    ) -> tuple[LoadFactorState, Innovation | None]:
        blocks = Blocks(*(block._replace(clock=block.clock + dt) for block in state.blocks))
        state = state._replace(blocks=blocks)
        if z is None:
            return state, None
        z = np.asarray(z, dtype=float)
        R = np.asarray(R, dtype=float)
        found: dict[str, Innovation] = {}
        for quantity in ("range", "elevation"):
            heard, block = np.isfinite(z[self._rows[quantity]]), getattr(blocks, quantity)
            if heard.any():
                posterior, found[quantity] = self._update(quantity, self._now(quantity, block), z, R)
                blocks = blocks._replace(**{quantity: _chosen(heard, Block(posterior, 0.0), block)})
        heard = np.isfinite(z[self._downlink])
        if heard.any():
            posterior, found["downlink"] = self._update_downlink(self._now("downlink", blocks.downlink), z, R)
            fresh = Block(posterior, np.zeros_like(blocks.downlink.clock))
            blocks = blocks._replace(downlink=_chosen(_agreed(heard), fresh, blocks.downlink))
        return self._step_azimuth(state._replace(blocks=blocks), z, R, heard.any(axis=0), found)

    def _now(self, quantity: str, block: Block) -> Gaussian:
        """A block other than the azimuth's carried on to now."""
        order, memory, density = self._dynamics[quantity]
        if np.ndim(density):
            density = lift(density, 1, np.ndim(block.clock) - 1)
        return predict(block.gaussian, *integrators(order, memory, density, block.clock))

    def _step_azimuth(
        self, state: LoadFactorState, z: Array, R: Array, heard: Array, found: dict[str, Innovation]
    ) -> tuple[LoadFactorState, Innovation]:
        """The azimuth block, carried on where the radar looked, or where it has waited and the downlink spoke."""
        block = state.blocks.azimuth
        scanned = np.isfinite(z[list(self._rows.values())]).any(axis=0)
        due = scanned | (heard & (block.clock >= self.longest_step))
        if due.any():
            moved, aid, clamped = self._azimuth_now(state)
            posterior, found["azimuth"] = self._update("azimuth", moved, z, R)
            blocks = state.blocks._replace(azimuth=_chosen(due, Block(posterior, 0.0), block))
            if self.azimuth_acceleration != "corrected_residual":
                aid, clamped = self._computed(blocks, posterior.mean, 0.0)
                aid = np.where(self._silent(blocks, 0.0), np.nan, aid)
            state = LoadFactorState(
                blocks, np.where(due, aid, state.aid), np.where(due, clamped & np.isfinite(aid), state.clamped)
            )
        return state, self._joint(found, z)

    def estimate(self, state: LoadFactorState) -> Gaussian:
        """The radar's channels now, block by block."""
        parts = []
        for quantity in ("range", "azimuth", "elevation"):
            if quantity == "azimuth":
                now, _, _ = self._azimuth_now(state)
            else:
                now = self._now(quantity, getattr(state.blocks, quantity))
            parts.append(Gaussian(now.mean[:2], now.cov[:2, :2]))
        batch = np.broadcast_shapes(*(part.mean.shape[1:] for part in parts))
        spread = np.broadcast_shapes(*(part.cov.shape[2:] for part in parts))
        cov = np.zeros((6, 6, *spread))
        for first, part in zip((0, 2, 4), parts, strict=True):
            cov[first : first + 2, first : first + 2] = lift(part.cov, 2, len(spread))
        return Gaussian(np.concatenate([np.broadcast_to(part.mean, (2, *batch)) for part in parts]), cov)

    def _update(self, quantity: str, moved: Gaussian, z: Array, R: Array) -> tuple[Gaussian, Innovation]:
        row = self._rows[quantity]
        one = z[row : row + 1]
        if quantity in ANGLES:
            one = moved.mean[:1] + wrap(one - moved.mean[:1])
        return update(moved, one, np.eye(1, len(moved.mean)), R[row : row + 1, row : row + 1])

    def _update_downlink(self, moved: Gaussian, z: Array, R: Array) -> tuple[Gaussian, Innovation]:
        """All six at once; their errors are taken as independent, as everything here."""
        told, angle = z[self._downlink], lift([quantity in ANGLES for quantity in DOWNLINK], 1, z.ndim - 1) > 0.0
        told = np.where(angle, moved.mean[0] + wrap(told - moved.mean[0]), told)
        return update(moved, told[None], np.eye(1, 2), R[self._downlink, self._downlink][None, None])

    def _joint(self, found: dict[str, Innovation], z: Array) -> Innovation:
        """All channels' innovations in the order of z; the blocks are independent, so their likelihoods multiply."""
        white, nis, log_likelihood = np.full(z.shape, np.nan), np.zeros(z.shape[1:]), np.zeros(z.shape[1:])
        for quantity, innovation in found.items():
            rows = self._downlink if quantity == "downlink" else self._rows[quantity]
            white[rows] = innovation.white[0]
            over = 0 if quantity == "downlink" else ()
            nis = nis + np.sum(innovation.nis, axis=over)
            log_likelihood = log_likelihood + np.sum(innovation.log_likelihood, axis=over)
        return Innovation(white, nis, log_likelihood)

    def _silent(self, blocks: Blocks, ago: Array) -> Array:
        """Whether a downlinked quantity had been silent for too long, ``ago`` seconds before now."""
        return blocks.downlink.clock.max(axis=0) - ago > self.dropout

    def _azimuth_now(self, state: LoadFactorState) -> tuple[Gaussian, Array, Array]:
        """The azimuth block carried on to now, the computed acceleration behind it, and where that was clamped."""
        block, aid = state.blocks.azimuth, state.aid
        moved = block.gaussian
        clamped, left = state.clamped, np.asarray(block.clock, dtype=float)
        longest = np.maximum(self.longest_step, left / MOST_STEPS)  # the downlink is silent then: exact however long
        while True:
            span = np.minimum(left, longest)
            left = left - span
            further = span > 0.0
            if not further.any():
                return moved, aid, clamped
            silent = self._silent(state.blocks, left)
            if silent.all():
                later, new, cut = self._kinematic(moved, span), np.full_like(aid, np.nan), np.zeros_like(clamped)
            else:
                later, new, cut = self._aided(moved, aid, span, left, state.blocks)
                if silent.any():
                    later, new = either(silent, self._kinematic(moved, span), later), np.where(silent, np.nan, new)
            moved = later if further.all() else either(further, later, moved)
            aid, clamped = np.where(further, new, aid), np.where(further, cut, clamped)

    def _kinematic(self, gaussian: Gaussian, span: Array) -> Gaussian:
        """Azimuth with a first-order Markov acceleration: what is left without the downlink."""
        memory = self.kinematic_correlation_time
        return predict(gaussian, *integrators(3, memory, self.kinematic_density / memory**2, span))

    def _aided(
        self, gaussian: Gaussian, aid: Array, span: Array, left: Array, blocks: Blocks
    ) -> tuple[Gaussian, Array, Array]:
        """Azimuth over ``span`` that ends ``left`` before now, driven by the computed acceleration."""
        if self.azimuth_acceleration != "corrected_residual":
            computed, clamped = self._computed(blocks, gaussian.mean, left + span)
            aid = np.where(np.isnan(aid), computed, aid)
            moved = predict(gaussian, *_printed_azimuth(span, self.azimuth_density))
            mean = np.stack(np.broadcast_arrays(moved.mean[0], moved.mean[1], aid))
            return Gaussian(mean, moved.cov), aid, clamped
        memory = self.azimuth_correlation_time
        gaussian, aid = self._joined(gaussian, aid, self._computed(blocks, gaussian.mean, left + span)[0])
        angle, rate, acceleration = np.broadcast_arrays(*gaussian.mean, aid)[:3]
        ahead = np.stack([angle + rate * span + 0.5 * acceleration * span**2, rate + acceleration * span, acceleration])
        computed, clamped = self._computed(blocks, ahead, left)
        known = np.stack([(2.0 * aid + computed) * span**2 / 6.0, 0.5 * (aid + computed) * span, computed])
        residual = Gaussian(np.stack([angle, rate, acceleration - aid]), gaussian.cov)
        moved = predict(residual, *integrators(3, memory, self.azimuth_density / memory**2, span), known)
        return moved, computed, clamped

    def _joined(self, gaussian: Gaussian, aid: Array, computed: Array) -> tuple[Gaussian, Array]:
        """The block where the downlink speaks again: the computed acceleration measures its own up to the residual."""
        fresh = np.isnan(aid)
        if not fresh.any():
            return gaussian, aid
        variance = 0.5 * self.azimuth_density / self.azimuth_correlation_time
        measured = np.where(fresh, computed, np.nan)[None]
        return update(gaussian, measured, np.eye(1, 3, 2), np.array([[variance]]))[0], np.where(fresh, computed, aid)

    def _computed(self, blocks: Blocks, azimuth: Array, ago: Array) -> tuple[Array, Array]:
        """Azimuth acceleration from the other blocks' estimates, and where it was clamped [Glistin, eq. (1)]."""
        seen = {}
        for quantity, (order, memory, _) in self._dynamics.items():
            block = getattr(blocks, quantity)
            seen[quantity] = ahead(block.mean, order, memory, np.maximum(block.clock - ago, 0.0))
        n_x, n_y, n_z, gamma, theta, course = seen["downlink"][0]
        a_X, a_Z = horizontal_acceleration(n_x, n_y, n_z, gamma, theta, self.zero_azimuth - course)
        (distance, distance_rate, line_of_sight), (elevation, elevation_rate) = seen["range"], seen["elevation"]
        if self.azimuth_acceleration == "published":
            return published_azimuth_acceleration(a_X, a_Z, line_of_sight, distance, elevation)
        if self.azimuth_acceleration == "intended":
            return intended_azimuth_acceleration(a_X, a_Z, line_of_sight, distance, elevation)
        corrected = corrected_azimuth_acceleration(
            a_X, a_Z, azimuth[0], azimuth[1], distance, distance_rate, elevation, elevation_rate
        )
        return corrected, np.zeros(np.shape(corrected), dtype=bool)


def _printed_azimuth(dt: Array, density: float) -> tuple[Array, Array]:
    """(F, Q) of the azimuth block as printed: its acceleration is replaced, so its gain is exactly zero [Glistin]."""
    dt = np.asarray(dt, dtype=float)
    zero, one = np.zeros_like(dt), np.ones_like(dt)
    F = np.array([[one, dt, 0.5 * dt**2], [zero, one, dt], [zero, zero, zero]])
    Q = np.array([[zero, zero, zero], [zero, zero, zero], [zero, zero, density / np.where(dt > 0.0, dt, 1.0)]])
    return F, Q


def either(mask: Array, new: Gaussian, old: Gaussian) -> Gaussian:
    """The new estimate in some runs, the old one in the others."""
    batch = np.ndim(mask)
    return Gaussian(
        np.where(mask, new.mean, old.mean), np.where(mask, lift(new.cov, 2, batch), lift(old.cov, 2, batch))
    )


def _agreed(mask: Array) -> Array:
    """A mask (6, *B) with one run in place of all where all runs agree: what they share stays shared."""
    if mask.ndim == 1 or (mask != mask[..., :1]).any():
        return mask
    return mask[..., :1]


def _chosen(mask: Array, new: Block, old: Block) -> Block:
    """The new block in some runs, the old one in the others; as it is where they all agree."""
    if mask.all():
        return new
    if not mask.any():
        return old
    return Block(either(mask, new.gaussian, old.gaussian), np.where(mask, new.clock, old.clock))
