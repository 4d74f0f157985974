"""Many draws: an array in a file is the array, a track of parts is the track, and what does not fit is told."""

from __future__ import annotations

import gc
import os
import pickle
import tempfile

import numpy as np
import pytest

from sim.errors import OutputError
from sim.estimation.many_draws.collected import CollectedTrack, filed, joined_errors
from sim.estimation.many_draws.filed_array import FiledArray
from sim.metrics.comparison import Compared
from sim.metrics.contrasts.squares import Squares
from tracking.track import Track


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def a_track(rng, draws: int, shared: bool, skipped: bool) -> Track:
    cov = rng.random((4, 2, 2, 1 if shared else draws))
    return Track(
        ("north", "east"),
        np.arange(4.0),
        rng.random((4, 2, draws)),
        cov,
        rng.random((4, 1, draws)),
        rng.random((4, draws)),
        rng.random((4, draws)),
        None,
        rng.random((4, draws)) > 0.5 if skipped else None,
    )


def test_an_array_in_a_file_is_the_array(rng):
    whole = rng.random((3, 2, 10))
    found = FiledArray(whole[..., :4])
    found.add(whole[..., 4:9])
    found.add(whole[..., 9:])
    assert (found.shape, found.ndim, len(found)) == (whole.shape, 3, 3)
    np.testing.assert_array_equal(np.asarray(found), whole)
    np.testing.assert_array_equal(found[1:, 0, 2:7], whole[1:, 0, 2:7])
    np.testing.assert_array_equal(np.isfinite(found).sum(axis=1), np.isfinite(whole).sum(axis=1))
    assert found.astype(np.float32).dtype == np.float32
    copy = pickle.loads(pickle.dumps(found))
    assert type(copy) is np.ndarray
    np.testing.assert_array_equal(copy, whole)
    with pytest.raises(ValueError, match="does not continue"):
        found.add(whole[:2])


def test_its_file_has_no_name_and_ends_with_it(rng, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    found = FiledArray(rng.random((2, 3)))
    assert not [*tmp_path.iterdir()]
    handle = found._file
    os.fstat(handle)
    del found
    gc.collect()
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(handle)


def test_where_no_file_can_be_written_one_sentence_says_so(rng, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    with pytest.raises(OutputError, match=r"so many draws need room in this folder: No such file.*TMPDIR"):
        FiledArray(rng.random((2, 3)))


@pytest.mark.parametrize(("shared", "later"), [(True, True), (False, False), (True, False)])
def test_a_track_of_parts_is_the_track(rng, shared, later):
    """A covariance that serves all runs still does, unless a later part has one for each; skipped looks may begin."""
    parts = [a_track(rng, 3, shared, False), a_track(rng, 2, later, True)]
    collected = CollectedTrack()
    collected.add(parts[0])
    assert collected.whole().mean is parts[0].mean
    collected.add(parts[1])
    whole = collected.whole()
    for name in ("mean", "white", "nis", "log_likelihood"):
        expected = np.concatenate([getattr(part, name) for part in parts], axis=-1)
        np.testing.assert_array_equal(np.asarray(getattr(whole, name)), expected)
    covs = [np.broadcast_to(part.cov, (4, 2, 2, draws)) for part, draws in zip(parts, (3, 2), strict=True)]
    assert whole.cov.shape[-1] == (1 if later else 5)
    np.testing.assert_array_equal(np.asarray(whole.cov), parts[0].cov if later else np.concatenate(covs, axis=-1))
    np.testing.assert_array_equal(whole.skipped[:, :3], False)
    np.testing.assert_array_equal(whole.skipped[:, 3:], parts[1].skipped)
    assert whole.model_probabilities is None


def test_errors_of_parts_are_those_of_all(rng):
    whole = Compared(rng.random((4, 2, 5)), rng.random((4, 2, 2, 5)))
    parts = [
        {"position_m": Compared(whole.error[..., some], whole.cov[..., some])} for some in (slice(0, 2), slice(2, 5))
    ]
    found = joined_errors(parts)["position_m"]
    np.testing.assert_array_equal(found.error, whole.error)
    np.testing.assert_array_equal(found.cov, whole.cov)
    assert joined_errors([]) == {}


def test_squared_errors_keep_their_tables(rng):
    values = rng.random((3, 4))
    tables = {"overall": {"position_m": Squares(np.arange(3.0), values)}, "by_phase": {"final": {}}}
    found = filed(tables)
    assert found["by_phase"] == {"final": {}}
    np.testing.assert_array_equal(np.asarray(found["overall"]["position_m"].values), values)
