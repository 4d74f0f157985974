"""The contract of a tracker: what it is given and what it gives back; and the only loop over time.

A kind of tracker is one file of ``tracking/trackers`` with one frozen dataclass that has all members of `Tracker`. The
file's name is the ``kind`` of ``[trackers.NAME]``, its fields are the other keys, in SI and with their unit in the
annotation: ``sub_step: Annotated[float, "s"] = 0.5`` is ``sub_step_s`` in a scenario. Nothing else knows the kind.
`tracking.contract` tries a class on all this. Fields annotated ``"given"`` are absent from files; by their names the
simulation fills

    measurement   how plots become ``z = H x + v``, a `tracking.measurement.MeasurementModel` of all its sensors that
                  give a place (with ``measured``: of those among its sensors that do)
    measured      tuple of the names of the rows of z, "<sensor>.<quantity>", for a tracker that picks rows itself
    zero_azimuth  rad clockwise from north, where the azimuth of its first sensor that measures one is zero
    law           the control law of the autopilot, a `tracking.reference_path.Law`, as it is assumed to be
    alternative_laws   the laws that the autopilot always has too, as designed, a tuple
    bank_limit    rad, the one at which the autopilot flies its turns, for a tracker that knows no law but turns
    route         the route as charted: its legs, their speeds and that of the glide path, the steady wind

and no others: never the true state, the active leg or the phase. A "given" field of another name needs a default.

A look that no algebra can weigh is skipped in its run, told in ``skipped`` of the `Epoch`, and no track turns NaN by
it: a channel beyond `FARTHEST` is taken for absent, and an update that leaves no estimate - twice exact, R = 0, at one
instant - is not made, the run goes on by its prediction.

What a tracker may say besides, each read in one place: ``modes`` (`modes_of`), ``intents`` and ``switched``
(`intents_of`), ``steer`` (`TimeStamped`), ``per_run`` (`per_run_of`), ``recorded`` (`is_recorded`). Trackers that
differ in nothing but ``law`` and what is ``per_run`` are run as one, these stacked over the runs. A kind whose fields
have no usable defaults says in ``example: ClassVar[dict[str, Any]]`` what a scenario would write, without ``kind``; its
contract is tried with that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextvars import copy_context
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from tracking.gaussian import Gaussian, Innovation, Mixture, lift, merge
from tracking.tree import choose

LAW, ACCURACY = "law", "noise"  # how names of hypotheses begin, see `modes_of`
MANUAL, ARMED = "manual", "armed"  # intents of free flight, and of a heading held until a law engages: `intents_of`
# m, or the unit of a channel: a quarter of the Earth's circumference. Squares of what is farther, beside a variance of
# 1 m2, have no digits left in double precision (1e14 of 1e16), and covariances turn negative.
FARTHEST = 1e7


@dataclass(frozen=True)
class Measurements:
    """A record of measurements at the union of the epochs of a tracker's sensors.

    z = NaN where a channel is absent at that epoch; its row and column of R say nothing then. ``B`` is the batch of
    noise draws; R has no draw axis where the accuracy is the same for all draws. Raises ``ValueError`` for what is no
    record of measurements, in one sentence.
    """

    channels: tuple[str, ...]  # m names, "<sensor>.<quantity>"
    time: Any  # (k,) s, when it was true
    arrival: Any  # (k,) s, when it was known
    z: Any  # (k, m, *B)
    R: Any  # (k, m, m, *C)
    candidates: Any = None  # (k, c, m, *B) plots among which the target's may be, NaN = fewer than c; for association

    def __post_init__(self) -> None:
        m = len(self.channels)
        time, arrival, z, R = (np.asarray(value) for value in (self.time, self.arrival, self.z, self.R))
        _require(time.ndim == 1 and time.shape == arrival.shape, "time and arrival must be vectors of one length")
        k = len(time)
        _require(bool(np.isfinite(time).all() and np.isfinite(arrival).all()), "times must be finite")
        _require(bool((arrival >= time).all()), "a measurement cannot arrive before it was taken")
        _require(z.shape[:2] == (k, m), f"z must have the shape ({k}, {m}, runs), not {z.shape}")
        _require(R.shape[:3] == (k, m, m), f"R must have the shape ({k}, {m}, {m}, runs), not {R.shape}")
        _require(R.ndim <= z.ndim + 1, "R has more batch axes than z")
        _require(not np.isinf(z).any(), "a measurement is infinite; an absent one is NaN")
        _check_covariances(self)

    def __repr__(self) -> str:
        """One line; the arrays have thousands of epochs."""
        return f"<Measurements of {', '.join(self.channels)}: {len(self.time)} epochs>"

    def runs(self, chosen: slice) -> Measurements:
        """The measurements of some runs (a slice of the last axis)."""
        R = self.R if np.ndim(self.R) == 3 or self.R.shape[-1] == 1 else self.R[..., chosen]
        candidates = None if self.candidates is None else self.candidates[..., chosen]
        return self._part(self.time, self.arrival, self.z[..., chosen], R, candidates)

    def rows(self, chosen: slice) -> Measurements:
        """The measurements of some epochs: views of a record that was checked when it was made."""
        candidates = None if self.candidates is None else self.candidates[chosen]
        return self._part(self.time[chosen], self.arrival[chosen], self.z[chosen], self.R[chosen], candidates)

    def _part(self, *arrays: Any) -> Measurements:
        """Some of a record that was checked when it was made, without a check of its own."""
        part = object.__new__(Measurements)
        for field, kept in zip(fields(self), (self.channels, *arrays), strict=True):
            object.__setattr__(part, field.name, kept)
        return part


def _check_covariances(record: Measurements) -> None:
    """Raise ``ValueError`` where R is not the covariance of what was measured."""
    R, m = np.asarray(record.R, dtype=float), len(record.channels)
    said: Any = None if np.isfinite(np.sum(R)) else _said(record, R)  # the usual case, cheaply
    if said is not None:
        bad = said & ~np.isfinite(R)
        if bad.any():
            row, i = np.argwhere(bad)[0][:2]
            raise ValueError(
                f"R of '{record.channels[i]}' is not finite at {record.time[row]:g} s, where it was measured"
            )
    pairs: Any = 0  # of channels that are correlated
    for i in range(m):
        _require(not (R[:, i, i] < 0.0).any(), f"the variance of '{record.channels[i]}' is negative")
        for j in range(i):
            upper, lower = R[:, j, i], R[:, i, j]
            if not (upper.any() or lower.any()):
                continue
            said = _said(record, R) if said is None else said
            both, scale = said[:, i, j], np.sqrt(np.abs(R[:, i, i])) * np.sqrt(np.abs(R[:, j, j]))
            _require(not (both & (np.abs(upper - lower) > 1e-9 * scale)).any(), "R is not symmetric")
            excess = np.abs(upper) > (1.0 + 1e-9) * scale
            _require(not (both & excess).any(), "R is not a covariance: a correlation exceeds 1")
            pairs = pairs + (both & (upper != 0.0))
    if np.any(pairs > 1):  # with one, or none, the correlation has said it all
        matrices = np.moveaxis(np.where(said, R, 0.0), (1, 2), (-2, -1))[np.asarray(pairs) > 1]
        deviations = np.sqrt(np.einsum("...ii->...i", matrices))
        scale = np.where(deviations > 0.0, deviations, 1.0)
        correlation = matrices / scale[:, None] / scale[:, :, None]
        negative = np.linalg.eigvalsh(correlation).min() < -1e-9
        _require(not negative, "R is not a covariance: it is negative in some direction")


def _said(record: Measurements, R: Any) -> Any:
    """Whether both channels of an entry of R were measured (k, m, m, *C), in any of the runs that share it."""
    plots = np.asarray(record.z) if record.candidates is None else np.asarray(record.candidates)
    present = ~np.isnan(plots)
    present = present if record.candidates is None else present.any(axis=1)
    shared = R.ndim < present.ndim + 1 or R.shape[3:] != present.shape[2:]
    present = present.any(axis=tuple(range(2, present.ndim))) if shared else present
    return lift(present[:, :, None] & present[:, None], 3, R.ndim - 3) > 0.0


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
    skipped: Any | None = None  # (k, *B) whether something measured could not be used; None = everything could

    def __repr__(self) -> str:
        """One line; the arrays have thousands of updates."""
        draws = "" if np.ndim(self.mean) < 3 else f", {np.shape(self.mean)[2]} draws"
        return f"<Track of {', '.join(self.channels)}: {len(self.time)} updates{draws}>"


class Tracker(Protocol):
    """Anything that turns measurements into estimates; its state is passed, never hidden.

    Every array has its matrix axes first and the runs of an ensemble last; a prior or an R without the axis serves all
    runs. A run's estimate is the same whatever other runs stand beside it.
    """

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the components of ``estimate``, on which the prior is given as well.

        ("north", "north_rate", "east", "east_rate") for cartesian; else a quantity of a sensor, "<sensor>.azimuth",
        or ``cross_track``, each with "", "_rate" or "_acceleration" behind it.
        """
        ...

    def begin(self, prior: Gaussian) -> Any:
        """State before the first measurement, from a prior over ``channels``: mean (n, *B), cov (n, n, *C).

        A state is made of (nested tuples of) arrays whose last axis is the runs, or of what all runs share.
        """
        ...

    def step(self, state: Any, dt: float, z: Any | None, R: Any | None) -> tuple[Any, Innovation | None]:
        """The state dt (s) later, then updated with z (m, *B) of the covariance R (m, m, *C).

        z = None is pure prediction, and gives no innovation. NaN in z is a channel that was not measured in that run:
        it changes nothing there, and its row and column of R say nothing. White is NaN where nothing was measured, NIS
        and log likelihood are 0 in a run without any measurement. The state that is passed in is not changed, because a
        look-ahead starts from it as well.

        dt = 0 is a mere update: no time, no noise. A tracker that is not given ``measured`` comes out the same when it
        predicts first and then updates over no time, because association among false plots does so.
        """
        ...

    def estimate(self, state: Any) -> Gaussian | Mixture:
        """What is believed now over ``channels``; the covariance is symmetric and nowhere negative."""
        ...


@runtime_checkable
class TimeStamped(Protocol):
    """A tracker that knows how old a measurement is and steers it to now by its own prediction."""

    def steer(self, state: Any, z: Any, age: float) -> Any:
        """z (m, *B) of ``age`` seconds ago as it would read now, with the state predicted to now."""
        ...


def modes_of(tracker: Any) -> tuple[str, ...]:
    """What a tracker calls its hypotheses, in the order of the weights of its mixture; () = it names none.

    Names that begin with `LAW` are drawn as control laws, those that begin with `ACCURACY` as accuracies of what is
    measured, the stated one first.
    """
    return tuple(getattr(tracker, "modes", ()))


def intents_of(tracker: Any) -> tuple[str, ...]:
    """Whom each hypothesis of a tracker says the aircraft follows, the assumed law first; () = it says nothing of that.

    One among them that is `ARMED` says that the law need not be flown from the start. A tracker that has intents also
    answers ``switched(probabilities (k, M, *B), dt (k, 1, 1) s, mean (k, n, *B))``: what they are dt later, from these
    estimates, before anything is measured.
    """
    return tuple(getattr(tracker, "intents", ()))


def is_recorded(tracker: Any) -> bool:
    """Whether a tracker, or a class of them, brings estimates that were made elsewhere.

    Such a one has ``recorded = True``, ``channels`` and ``estimates``, and is judged by what it brings. It is not run:
    it has no ``begin``, ``step`` and ``estimate``.
    """
    return bool(getattr(tracker, "recorded", False))


def per_run_of(tracker: Any) -> dict[str, str]:
    """Fields of a tracker that may be an array with one value per run, and the member that tells the value of each."""
    return dict(getattr(tracker, "per_run", {}))


class TrackerError(ValueError):
    """A tracker that does not keep its contract; the sentence begins with the member."""


def ask(tracker: Any, member: str, *arguments: Any) -> Any:
    """What a member of a tracker's contract answers; what it raises becomes a `TrackerError`."""
    try:
        return getattr(tracker, member)(*arguments)
    except MemoryError:
        raise
    except Exception as error:
        raise TrackerError(f"{member} raises {type(error).__name__}: {' '.join(str(error).split())[:200]}") from error


def stepped(tracker: Any, state: Any, dt: float, z: Any = None, R: Any = None) -> tuple[Any, Innovation | None]:
    """``tracker.step``; raises `TrackerError`."""
    answer = ask(tracker, "step", state, dt, z, R)
    if not (
        isinstance(answer, tuple) and len(answer) == 2 and (answer[1] is None or isinstance(answer[1], Innovation))
    ):
        raise TrackerError(f"step gives {type(answer).__name__}, not (state, Innovation or None)")
    return answer


def believed(tracker: Any, state: Any) -> Gaussian | Mixture:
    """``tracker.estimate``; raises `TrackerError`."""
    estimate = ask(tracker, "estimate", state)
    if not isinstance(estimate, (Gaussian, Mixture)):
        raise TrackerError(f"estimate gives {type(estimate).__name__}, not a Gaussian or a Mixture")
    return estimate


class Taken(NamedTuple):
    """A look taken in."""

    state: Any  # of the tracker
    estimate: Gaussian | Mixture
    innovation: Innovation | None
    lost: Any = None  # (*B) runs whose look was not taken; None = there are none


def taken(tracker: Any, state: Any, dt: float, z: Any, R: Any) -> Taken:
    """The state dt (s) later with a look taken in.

    Runs that the update would leave without an estimate go on by their prediction.
    """
    after, innovation = stepped(tracker, state, dt, z, R)
    estimate = believed(tracker, after)
    said = (*estimate, *(() if innovation is None else innovation[1:]))
    if math.isfinite(sum([np.add.reduce(values, axis=None) for values in said])):  # the usual case, cheaply
        return Taken(after, estimate, innovation)
    batch = np.shape(estimate.mean)[2 if isinstance(estimate, Mixture) else 1 :]
    sound: Any = np.ones(batch, dtype=bool)
    for values in said:
        finite = np.isfinite(values)
        sound = sound & finite.all(axis=tuple(range(finite.ndim - min(finite.ndim, len(batch)))))
    if sound.all():
        return Taken(after, estimate, innovation)
    ahead, _ = stepped(tracker, state, dt)
    lost = ~sound
    if innovation is not None:
        innovation = Innovation(
            np.where(lost, np.nan, innovation.white), *(np.where(lost, 0.0, values) for values in innovation[1:])
        )
    state = choose(sound, after, ahead)
    return Taken(state, believed(tracker, state), innovation, lost)


class Epoch(NamedTuple):
    """One turn of the loop."""

    row: int  # of the measurements
    time: float  # s, when the estimate holds
    estimate: Gaussian | Mixture
    innovation: Innovation | None
    state: Any  # of the tracker, from which a look-ahead can be taken
    skipped: Any = None  # (*B) runs in which something measured could not be used; None = there are none


def follow(
    tracker: Tracker, measurements: Measurements, prior: Gaussian, start: float | None = None
) -> Iterator[Epoch]:
    """Run a tracker through a record in the order of arrival, one epoch at a time: the only loop over time.

    Statistics over an ensemble consume the epochs as they come, so that no history is kept. A single run and an
    ensemble take the same path; a prior without batch axes serves every run.

    Parameters
    ----------
    start : s, when the prior holds; by default when the first measurement arrives.

    Raises
    ------
    ValueError : the prior does not fit, or holds after the first arrival.
    TrackerError : the tracker does not keep its contract.
    """
    _check_covariances(measurements)  # arrays can be written to after the record was made
    time, arrival = (np.asarray(times, dtype=float).tolist() for times in (measurements.time, measurements.arrival))
    if not time:
        return
    batch = measurements.z.ndim - 2
    state = ask(tracker, "begin", _checked(prior, batch))
    order = np.argsort(arrival, kind="stable").tolist()
    first = arrival[order[0]]
    now = first if start is None else float(start)
    _require(now <= first, f"the prior holds at {now:g} s, after the first arrival at {first:g} s")
    steers, fits = isinstance(tracker, TimeStamped), False
    plots = measurements.z if measurements.candidates is None else measurements.candidates
    absurd: Any = np.abs(plots) > FARTHEST
    plots = np.where(absurd, np.nan, plots) if absurd.any() else plots
    nothing: Any = np.isnan(plots).all(axis=tuple(range(1, plots.ndim))).tolist()
    unusable: Any = absurd.any(axis=tuple(range(1, plots.ndim - batch)))  # (k, *B)
    told = unusable.any(axis=tuple(range(1, unusable.ndim))).tolist()
    quiet = copy_context()  # a lost run is a result, and goes on as NaN; entered at less than the cost of errstate
    quiet.run(np.seterr, divide="ignore", over="ignore", invalid="ignore")

    def turn(state: Any, dt: float, index: int) -> Taken:
        if nothing[index]:
            state, innovation = stepped(tracker, state, dt)
            return Taken(state, believed(tracker, state), innovation)
        z = plots[index]
        if steers and time[index] < arrival[index]:
            state, _ = stepped(tracker, state, dt)
            z, dt = ask(tracker, "steer", state, z, arrival[index] - time[index]), 0.0
        return taken(tracker, state, dt, z, lift(measurements.R[index], 2, batch))

    for index in order:
        now, before = arrival[index], now
        state, estimate, innovation, skipped = quiet.run(turn, state, now - before, index)
        if told[index]:
            skipped = unusable[index] if skipped is None else unusable[index] | skipped
        if not fits:
            _check_fit(tracker, estimate)
            fits = True
        yield Epoch(index, now, estimate, innovation, state, skipped)


def track(
    tracker: Tracker,
    measurements: Measurements,
    prior: Gaussian,
    start: float | None = None,
    watch: Callable[[Epoch], None] | None = None,
) -> Track:
    """Run a tracker through a record and keep every estimate; ``watch`` is shown each epoch (see also `follow`)."""
    times, means, covs, weights, innovations, skipped = [], [], [], [], [], []
    for epoch in follow(tracker, measurements, prior, start):
        if watch is not None:
            watch(epoch)
        estimate = epoch.estimate
        if isinstance(estimate, Mixture):
            weights.append(estimate.weights)
            estimate = merge(estimate)
        times.append(epoch.time)
        means.append(estimate.mean)
        covs.append(estimate.cov)
        innovations.append(epoch.innovation)
        skipped.append(epoch.skipped)
    any_skipped = any(one is not None for one in skipped)
    _require(bool(times), "there is no measurement to track")
    batch = measurements.z.shape[2:]
    known = next((innovation for innovation in innovations if innovation is not None), None)
    rows = len(measurements.channels) if known is None else len(known.white)
    nothing = Innovation(np.full((rows, *batch), np.nan), np.zeros(batch), np.zeros(batch))
    white, nis, log_likelihood = zip(*(nothing if i is None else i for i in innovations), strict=True)
    return Track(
        tracker.channels,
        np.array(times),
        _stack(means, batch),
        _stack(covs),
        _stack(white, batch),
        _stack(nis, batch),
        _stack(log_likelihood, batch),
        _stack(weights, batch) if weights else None,
        _stack([np.zeros(1) if one is None else one for one in skipped], batch) > 0.0 if any_skipped else None,
    )


def chunks(runs: int, size: int = 1536) -> Iterator[slice]:
    """Slices that cover the runs of an ensemble; about so many at a time stay in the processor's cache."""
    return (slice(first, min(first + size, runs)) for first in range(0, runs, size))


def _stack(arrays: Any, batch: tuple[int, ...] | None = None) -> Any:
    """Stack over time, broadcasting the batch axes (which may grow on the way) to ``batch`` or to their largest."""
    arrays = [np.asarray(array) for array in arrays]
    shape = np.broadcast_shapes(*{array.shape for array in arrays})
    if batch is not None:
        shape = (*shape[: len(shape) - len(batch)], *batch)
    stacked = np.empty((len(arrays), *shape))
    for row, array in enumerate(arrays):
        stacked[row] = array
    return stacked


def _checked(prior: Gaussian, batch: int) -> Gaussian:
    """The prior with the batch axes of the measurements."""
    mean, cov = np.asarray(prior.mean, dtype=float), np.asarray(prior.cov, dtype=float)
    n = len(mean) if mean.ndim else 0
    _require(n > 0 and cov.shape[:2] == (n, n), f"a prior of {n} states needs a covariance ({n}, {n}), not {cov.shape}")
    _require(mean.ndim - 1 <= batch and cov.ndim - 2 <= batch, "the prior has more batch axes than the measurements")
    _require(bool(np.isfinite(mean).all() and np.isfinite(cov).all()), "the prior must be finite")
    scale = np.sqrt(np.abs(np.einsum("ii...->i...", cov)))
    skew = np.abs(cov - cov.swapaxes(0, 1))
    _require(bool((skew <= 1e-9 * scale[:, None] * scale).all()), "the prior's covariance is not symmetric")
    _require(bool((np.einsum("ii...->i...", cov) >= 0.0).all()), "the prior's covariance has a negative variance")
    return Gaussian(lift(mean, 1, batch), lift(cov, 2, batch))


def _check_fit(tracker: Tracker, estimate: Gaussian | Mixture) -> None:
    """Raise `TrackerError` where an estimate has not the components that its tracker names."""
    n, shape, mean = len(tracker.channels), np.shape(estimate.cov), np.shape(estimate.mean)
    if mean[:1] != (n,) or shape[:2] != (n, n):
        raise TrackerError(f"estimate has a mean of {mean[:1]} and a cov of {shape[:2]} for {n} channels")


def _require(condition: bool, sentence: str) -> None:
    if not condition:
        raise ValueError(sentence)
