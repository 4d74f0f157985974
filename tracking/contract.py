"""What tries a class on the contract of a tracker, `tracking.track.Tracker`.

It runs the tracker over a short record of several runs and asks what every tracker must be able to answer: is a run the
same beside others as alone, does it survive what is not measured or cannot be true, is no time no change, is a look
ahead harmless, also one over hours?
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from tracking.gaussian import Gaussian, Innovation, Mixture, merge
from tracking.track import (
    Epoch,
    Measurements,
    TimeStamped,
    Tracker,
    TrackerError,
    ask,
    believed,
    follow,
    intents_of,
    is_recorded,
    modes_of,
    stepped,
)

MEMBERS = tuple(name for name in vars(Tracker) if not name.startswith("_"))
RECORDED = ("channels", "estimates")  # members of one that brings its estimates
DEFAULTS: dict[str, Any] = {}  # a tracker has them all
SAME = 1e-11  # of the largest value of a component: rounding, by slopes of a law that are differences over a millimetre
SYMMETRIC, NEGATIVE = 1e-9, -1e-9  # of the scale of a covariance
LOOK, LONG = 5.0, 2e4  # s, of a look ahead
MISSED = 0  # the run in which a measurement is taken away or damaged


class Trial(NamedTuple):
    """A tracker with something to track: two runs or more, three epochs or more in the order of their arrival."""

    tracker: Any
    measurements: Measurements
    prior: Gaussian


class Moments(NamedTuple):
    """Estimates over time."""

    mean: Any  # (k, n, B)
    cov: Any  # (k, n, n, B)

    def of(self, runs: slice) -> Moments:
        """Those of some runs."""
        return Moments(self.mean[..., runs], self.cov[..., runs])

    def epoch(self, row: int) -> Moments:
        """Those of one epoch."""
        return Moments(self.mean[row : row + 1], self.cov[row : row + 1])


def missing_members(tracker: Any) -> list[str]:
    """What of the contract a tracker, or its class, has not at all or cannot say; a sentence each."""
    missing = [
        f"has no '{name}': {(inspect.getdoc(getattr(Tracker, name, None)) or 'what it brings').splitlines()[0]}"
        for name in (RECORDED if is_recorded(tracker) else MEMBERS)
        if inspect.getattr_static(tracker, name, None) is None
    ]
    if not missing and not isinstance(tracker, type):
        try:
            _ = tracker.channels
        except Exception as error:
            missing.append(f"channels raises {type(error).__name__}: {' '.join(str(error).split())[:200]}")
    return missing


def broken_promises(cls: type, make: Callable[[], Trial]) -> list[str]:
    """What a class breaks of the contract, a sentence each; empty for one that keeps it.

    ``make`` gives an instance with a record to run it on, the same each time. Never raises for a class that is wrong.
    """
    fields = set(getattr(cls, "__dataclass_fields__", ()))
    missing = [sentence for sentence in missing_members(cls) if sentence.split("'")[1] not in fields]
    if missing:
        return missing
    try:
        trial = make()
    except TrackerError as error:
        return [str(error)]
    except Exception as error:
        return [f"making one raises {type(error).__name__}: {' '.join(str(error).split())[:200]}"]
    if is_recorded(cls):
        return []  # what it brings is judged as it is
    broken = list(_tried(_runs, trial))  # what does not run at all would only break the rest again
    checks = (_keeps_its_state, _is_the_same_alone, _survives_absence, _survives_damage, _names, _steers)
    for check in () if broken else checks:
        broken += _tried(check, trial)
    return list(dict.fromkeys(broken))


def _tried(check: Callable[[Trial], Iterator[str]], trial: Trial) -> list[str]:
    """The sentences of a check, or the one of what stopped it."""
    try:
        with np.errstate(all="ignore"):
            return list(check(trial))
    except TrackerError as error:
        return [str(error)]
    except Exception as error:  # an answer of so wrong a shape that the check itself fails
        return [f"gives what cannot be worked with: {type(error).__name__}: {' '.join(str(error).split())[:200]}"]


def _runs(trial: Trial) -> Iterator[str]:
    """The whole record, epoch by epoch."""
    tracker, record, prior = trial
    channels = tracker.channels
    if not (isinstance(channels, tuple) and channels and all(isinstance(name, str) for name in channels)):
        yield f"channels gives {channels!r}, not a tuple of names"
        return
    if len(set(channels)) != len(channels):
        yield f"channels names a component twice: {', '.join(channels)}"
    for epoch in follow(tracker, record, prior):
        fault = _unbelievable(epoch.estimate, record.z.shape[2:]) or _no_innovation(epoch, record)
        if not fault and epoch.skipped is not None:
            fault = "step leaves no estimate where something was measured"
        if fault:
            yield f"{fault}, at epoch {epoch.row}"
            return


def _unbelievable(estimate: Gaussian | Mixture, batch: tuple[int, ...], before: Any = None) -> str:
    """What is wrong with an estimate; ``before`` is the covariance from which an exact measurement took its own."""
    if isinstance(estimate, Mixture):
        weights = np.asarray(estimate.weights)
        if not (weights >= 0.0).all() or not np.allclose(weights.sum(axis=0), 1.0, atol=1e-9):
            return "estimate gives weights that are negative or do not sum to one"
        for name, count in (("means", np.shape(estimate.mean)[1]), ("covs", np.shape(estimate.cov)[2])):
            if count not in (1, len(weights)):  # one, where all hypotheses share it
                return f"estimate gives {len(weights)} weights for {count} {name}"
        estimate = merge(estimate)
    mean, cov = np.asarray(estimate.mean), np.asarray(estimate.cov)
    if before is not None:  # what is left of it has the rounding of the whole
        cov = cov - NEGATIVE * np.eye(len(mean))[..., None] * np.abs(before)
    if mean.shape[1:] != batch:
        return f"estimate gives a mean of the shape {mean.shape} for runs {batch}"
    if not (np.isfinite(mean).all() and np.isfinite(cov).all()):
        return "estimate is not finite"
    deviations = np.sqrt(np.maximum(np.einsum("ii...->i...", cov), 0.0))
    scale = deviations[:, None] * deviations
    if (np.abs(cov - cov.swapaxes(0, 1)) > SYMMETRIC * scale).any():
        return "estimate gives a covariance that is not symmetric"
    correlation = np.moveaxis(cov / np.where(scale > 0.0, scale, 1.0), (0, 1), (-2, -1))
    if (np.einsum("ii...->i...", cov) < 0.0).any() or np.linalg.eigvalsh(correlation).min() < NEGATIVE:
        return "estimate gives a covariance that is negative in some direction"
    return ""


def _no_innovation(epoch: Epoch, record: Measurements) -> str:
    """What is wrong with an innovation."""
    measured = np.isfinite(record.z[epoch.row]).any()
    if not measured:
        return "" if epoch.innovation is None else "step gives an innovation where nothing was measured"
    if not isinstance(epoch.innovation, Innovation):
        return f"step gives {type(epoch.innovation).__name__} where something was measured, not an Innovation"
    for name, value in (("nis", epoch.innovation.nis), ("log_likelihood", epoch.innovation.log_likelihood)):
        if not np.isfinite(value).all():
            return f"step gives an innovation whose {name} is not finite"
    return ""


def _keeps_its_state(trial: Trial) -> Iterator[str]:
    """No time is no change, and a look ahead leaves the state as it was."""
    tracker, record, prior = trial
    *_, last = follow(tracker, record, prior)

    def moments(state: Any) -> Moments:
        return _moments(believed(tracker, state), record.z.shape[-1])

    now = moments(last.state)
    ahead, innovation = stepped(tracker, last.state, LOOK)
    if innovation is not None:
        yield "step gives an innovation without a measurement"
    fault = _unbelievable(believed(tracker, ahead), record.z.shape[2:])
    if fault:
        yield f"{fault}, {LOOK:g} s ahead without a measurement"
    fault = _unbelievable(believed(tracker, stepped(tracker, last.state, LONG)[0]), record.z.shape[2:])
    if fault:
        yield f"{fault}, {LONG:g} s ahead without a measurement"
    if not _same(moments(last.state), now):
        yield "step changes the state that is passed to it"
    still, _ = stepped(tracker, stepped(tracker, last.state, 0.0)[0], 0.0)
    if not _same(moments(still), now):
        yield "step over no time, without a measurement, changes the estimate"
    if "measured" in getattr(tracker, "__dataclass_fields__", {}):
        return  # it may take the prediction by what it now hears, and is never fed by association
    z, R = record.z[last.row], record.R[last.row]
    both, apart = stepped(tracker, last.state, LOOK, z, R)[0], stepped(tracker, ahead, 0.0, z, R)[0]
    if not _same(moments(apart), moments(both)):
        yield "step gives another estimate when it predicts first and updates then, over no time"


def _is_the_same_alone(trial: Trial) -> Iterator[str]:
    """A run beside others and the same run alone."""
    tracker, record, prior = trial
    together = _path(tracker, record, prior)
    for run in range(record.z.shape[-1]):
        only = slice(run, run + 1)
        alone = _path(tracker, record.runs(only), _prior_of(prior, only))
        if not _same(alone, together.of(only)):
            yield "a run comes out otherwise alone than beside others"
            return


def _survives_absence(trial: Trial) -> Iterator[str]:
    """One channel, then all of them, missing in one run; then an epoch at which no run measured anything."""
    tracker, record, prior = trial
    whole = _path(tracker, record, prior)
    middle = len(record.time) // 2
    others = slice(MISSED + 1, None)
    rows = np.flatnonzero(np.isfinite(record.z[middle]).any(axis=-1))
    for gone in (rows[:1], rows):
        z = np.array(record.z)
        z[middle, gone, MISSED] = np.nan
        found = _path(tracker, replace(record, z=z), prior)
        if not all(np.isfinite(values).all() for values in found):
            yield "a measurement that is absent in one run makes its estimate not finite"
            return
        if not _same(found.of(others), whole.of(others)):
            yield "a measurement that is absent in one run changes the estimates of other runs"
            return
    for runs, what in ((slice(MISSED, MISSED + 1), "a run"), (slice(None), "an epoch")):
        z = np.array(record.z)
        z[middle, :, runs] = np.nan
        states = [epoch.state for epoch in follow(tracker, replace(record, z=z), prior)]
        ahead, _ = stepped(tracker, states[middle - 1], float(record.arrival[middle] - record.arrival[middle - 1]))
        predicted, came = (_moments(believed(tracker, state), z.shape[-1]) for state in (ahead, states[middle]))
        if not _same(came.of(runs), predicted.of(runs)):
            yield f"{what} without a measurement is not its prediction"


def _survives_damage(trial: Trial) -> Iterator[str]:
    """Looks that cannot be true, in one run or exact in all: each is taken or skipped, and an estimate stays one."""
    tracker, record, prior = trial
    middle = len(record.time) // 2
    whole = _path(tracker, record, prior)
    for name, damaged in damages(record):
        found: list[Moments] = []
        for epoch in follow(tracker, damaged, prior):
            fault = _unbelievable(epoch.estimate, record.z.shape[2:], found[-1].cov[0] if found else None)
            if fault:
                yield f"{fault} once {name}, at epoch {epoch.row}"
                return
            found.append(_moments(epoch.estimate, record.z.shape[-1]))
        if np.array_equal(damaged.R, record.R) and len(found) == len(record.time):
            others = slice(MISSED + 1, None)
            if not _same(found[middle].of(others), whole.epoch(middle).of(others)):
                yield f"other runs change once {name} in one"
                return


def damages(record: Measurements) -> Iterator[tuple[str, Measurements]]:
    """What is wrong with the look in the middle of a record, in words, and the record with it."""
    middle = len(record.time) // 2
    for size in (1e5, 1e11, 1e300):
        z = np.array(record.z)
        z[middle, :, MISSED] += size
        yield f"a look is {size:g} off", replace(record, z=z)
    R = np.array(record.R)
    R[middle] = 0.0
    yield "a look is exact", replace(record, R=R)
    twice = np.sort(np.append(np.arange(len(record.time)), middle))
    yield (
        "two looks at one instant are exact",
        Measurements(record.channels, record.time[twice], record.arrival[twice], record.z[twice], R[twice]),
    )


def _names(trial: Trial) -> Iterator[str]:
    """The hypotheses, where it names them."""
    tracker, record, prior = trial
    *_, last = follow(tracker, record, prior)
    estimate = last.estimate
    weights, mean = (estimate.weights, merge(estimate).mean) if isinstance(estimate, Mixture) else ((), estimate.mean)
    for what, names in (("modes", modes_of(tracker)), ("intents", intents_of(tracker))):
        if names and len(names) != len(weights):
            yield f"{what} names {len(names)} hypotheses, estimate weighs {len(weights)}"
    if intents_of(tracker) and len(weights):
        later = ask(tracker, "switched", np.asarray(weights)[None], np.full((1, 1, 1), LOOK), mean[None])
        if np.shape(later) != (1, *np.shape(weights)) or not np.allclose(np.sum(later, axis=1), 1.0, atol=1e-9):
            yield "switched gives no probabilities of the same hypotheses"


def _steers(trial: Trial) -> Iterator[str]:
    """A value of now needs no steering."""
    tracker, record, prior = trial
    if isinstance(trial.tracker, TimeStamped):
        *_, last = follow(tracker, record, prior)
        z = record.z[last.row]
        if not np.allclose(ask(tracker, "steer", last.state, z, 0.0), z, rtol=1e-9, equal_nan=True):
            yield "steer changes a value of no age"


def _path(tracker: Any, record: Measurements, prior: Gaussian) -> Moments:
    """The estimates over a whole record, NaN where a look was skipped: that is no estimate of the tracker's own."""
    runs = record.z.shape[-1]
    each = []
    for epoch in follow(tracker, record, prior):
        each.append(_moments(epoch.estimate, runs))
        if epoch.skipped is not None:
            each[-1].mean[..., epoch.skipped] = np.nan
    return Moments(np.concatenate([one.mean for one in each]), np.concatenate([one.cov for one in each]))


def _moments(estimate: Gaussian | Mixture, runs: int) -> Moments:
    mean, cov = merge(estimate) if isinstance(estimate, Mixture) else estimate
    cov = cov if np.ndim(cov) == 3 else np.asarray(cov)[..., None]
    # copies, because what a tracker does to its state must not reach them
    mean, cov = (np.array(np.broadcast_to(values, (*values.shape[:-1], runs))) for values in (mean, cov))
    return Moments(mean[None], cov[None])


def _prior_of(prior: Gaussian, runs: slice) -> Gaussian:
    cov = prior.cov if np.ndim(prior.cov) == 2 or np.shape(prior.cov)[-1] == 1 else prior.cov[..., runs]
    return Gaussian(prior.mean if np.ndim(prior.mean) == 1 else prior.mean[..., runs], cov)


def _same(one: Moments, other: Moments) -> bool:
    """Whether all means and covariances agree, each within the scale of its components."""
    deviation = np.sqrt(np.einsum("kiin->kin", other.cov).max(axis=(0, 2)))
    size = np.abs(other.mean).max(axis=(0, 2)) + deviation
    means = np.abs(one.mean - other.mean) <= SAME * size[:, None]
    covs = np.abs(one.cov - other.cov) <= SAME * (deviation[:, None] * deviation)[..., None]
    return bool(means.all() and covs.all())
