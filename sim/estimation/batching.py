"""Batched trackers: those that differ only in the law or noise they assume run as one, their runs side by side.

A law takes arrays for its gains and limits, one value per run, and a tracker for what it calls ``per_run``. A step over
twice the runs costs little more than a step over the runs: most of it is overhead of array operations.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from tracking.gaussian import Gaussian
from tracking.track import Measurements, Track, per_run_of


def can_batch(one: Any, other: Any) -> bool:
    """Whether two trackers can run as one: of one class, with assumed laws of one class, all else equal.

    What differs must take one value per run, as what a law is made of does.

    The bank limit must be equal too, because it plans the turns of the route.
    """
    members = getattr(one, "__dataclass_fields__", {})
    law, fields = "law" in members, {*per_run_of(one)} & {*per_run_of(other)}
    if type(one) is not type(other) or not (law or fields):
        return False
    if law and (type(one.law) is not type(other.law) or one.law.bank_limit != other.law.bank_limit):
        return False
    return all(
        getattr(one, field.name) == getattr(other, field.name)
        for field in dataclasses.fields(one)
        if field.init and field.name not in ("law", *fields)
    )


def stack_trackers(trackers: list[Any], runs: int) -> Any:
    """One tracker for ``runs`` runs of each of several that `can_batch`, those of the first before the others'."""
    if all(tracker is trackers[0] for tracker in trackers):
        return trackers[0]
    own = _stacked(trackers, per_run_of(trackers[0]), runs)
    if "law" in trackers[0].__dataclass_fields__:
        laws = [tracker.law for tracker in trackers]
        fields = {field.name: field.name for field in dataclasses.fields(laws[0])}
        own["law"] = dataclasses.replace(laws[0], **_stacked(laws, fields, runs))
    return dataclasses.replace(trackers[0], **own)


def _stacked(alike: list[Any], fields: dict[str, str], runs: int) -> dict[str, Any]:
    """The fields in which objects of one class differ, one value per run; each is told by a member."""
    stacked = {}
    for field, member in fields.items():
        values = [getattr(one, member) for one in alike]
        if values != [values[0]] * len(values):
            stacked[field] = np.repeat(values, runs)
    return stacked


def repeat_runs(record: Measurements, prior: Gaussian, times: int) -> tuple[Measurements, Gaussian]:
    """The measurements and the prior once for each tracker of a batch."""
    if times == 1:
        return record, prior

    def again(array: Any, matrix_axes: int) -> Any:
        shared = array.ndim == matrix_axes or array.shape[-1] == 1
        return array if shared else np.concatenate([array] * times, axis=-1)

    z = np.concatenate([record.z] * times, axis=-1)
    return (
        Measurements(record.channels, record.time, record.arrival, z, again(record.R, 3)),
        Gaussian(np.concatenate([prior.mean] * times, axis=-1), again(np.asarray(prior.cov), 2)),
    )


def split_track(track: Track, trackers: int) -> list[Track]:
    """The track of each tracker of a batch."""
    runs = track.mean.shape[-1] // trackers
    tracks = []
    for place in range(trackers):
        own = slice(place * runs, (place + 1) * runs)
        parts = {
            name: array if array is None or (name == "cov" and array.shape[-1] == 1) else array[..., own]
            for name, array in track._asdict().items()
            if name not in ("channels", "time")
        }
        tracks.append(track._replace(**parts))
    return tracks


def runs_of(prior: Gaussian, chosen: slice, runs: int) -> Gaussian:
    """The prior of some of so many runs; what serves all of them stays as it is."""
    mean, cov = np.asarray(prior.mean), np.asarray(prior.cov)
    return Gaussian(
        mean[..., chosen] if mean.ndim == 2 and mean.shape[-1] == runs else mean,
        cov[..., chosen] if cov.ndim == 3 and cov.shape[-1] == runs else cov,
    )
