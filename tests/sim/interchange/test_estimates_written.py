"""Estimates written as comma-separated values and read again: the same to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from sim.errors import OutputError
from sim.interchange.clocks import Stamps
from sim.interchange.estimates import Estimates, read_estimates

RNG = np.random.default_rng(5)
FULL = Estimates(
    Stamps(False, RNG.uniform(0.0, 100.0, 4)),
    np.array([0, 0, 1, 2]),
    np.array(["a", "b", "a", "b"]),
    RNG.normal(0.0, 1e4, (4, 2)),
    None,
    RNG.normal(0.0, 70.0, (4, 2)),
    np.array(((100.0, 1 / 3), (1 / 3, 50.0))) * RNG.uniform(1.0, 2.0, (4, 1, 1)),
)


def same(found, said):
    for own, other in zip(found, said, strict=True):
        if other is None:
            assert own is None
        elif isinstance(other, Stamps):
            assert own.dated == other.dated
            np.testing.assert_array_equal(own.time, other.time)
        else:
            np.testing.assert_array_equal(own, other)


def test_everything_comes_back_to_the_last_bit(tmp_path):
    path = FULL.save(tmp_path / "mine.csv")
    same(read_estimates(path.read_bytes()), FULL)


def test_what_is_not_said_has_no_column(tmp_path):
    bare = FULL._replace(draw=None, number=None, velocity=None, cov=None)
    path = bare.save(str(tmp_path / "mine.csv"))
    assert path.read_text().splitlines()[0] == "time_s,north_m,east_m"
    same(read_estimates(path.read_bytes()), bare)


def test_latitudes_leave_in_degrees_and_come_back(tmp_path):
    told = FULL._replace(local=None, geographic=np.radians(RNG.uniform(-80.0, 80.0, (4, 2))))
    found = read_estimates(told.save(tmp_path / "mine.csv").read_bytes())
    np.testing.assert_allclose(found.geographic, told.geographic, rtol=3e-16)  # two roundings


def test_a_row_without_a_covariance_has_empty_cells(tmp_path):
    told = FULL._replace(cov=FULL.cov.copy())
    told.cov[2] = np.nan
    found = read_estimates(told.save(tmp_path / "mine.csv").read_bytes())
    np.testing.assert_array_equal(found.cov, told.cov)
    assert "nan" not in (tmp_path / "mine.csv").read_text()


def test_a_file_of_somebody_is_left_alone(tmp_path):
    (tmp_path / "mine.csv").write_text("theirs")
    with pytest.raises(OutputError, match=r"mine\.csv: exists already; choose another name"):
        FULL.save(tmp_path / "mine.csv")
    assert (tmp_path / "mine.csv").read_text() == "theirs"
    with pytest.raises(OutputError, match="cannot be written"):
        FULL.save(tmp_path / "none" / "mine.csv")
