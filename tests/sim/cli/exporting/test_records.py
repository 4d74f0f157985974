"""Parquet against the arrays it was written from, and every way in which a folder can be wrong."""

from __future__ import annotations

import json
import os
import sys

import numpy as np
import pytest

from sim.cli.exporting.records import contrasts, export_records
from sim.errors import OutputError
from sim.files import MARK, write_npz
from sim.reporting.columns import table_of

TIME = np.array((0.0, 1 / 30, 2 / 30))
Z = np.arange(12.0).reshape(3, 2, 2) / 7  # epochs, channels, draws


@pytest.fixture
def run_folder(tmp_path):
    """What a run leaves behind, small enough to be checked by hand."""
    (tmp_path / MARK).write_text("")
    write_npz(
        tmp_path / "flight.npz",
        {
            "time_s": TIME,
            "height_m": np.array((400.0, np.nan, 399.5)),
            "phase": np.array((0, 1, 1)),
            "phases": np.array(("final", "glide")),
        },
    )
    write_npz(
        tmp_path / "measurements.npz",
        {
            "radar.time_s": TIME,
            "radar.channels": np.array(("range", "azimuth")),
            "radar.z": Z,
            "radar.sigma": np.tile(np.array((60.0, 0.002))[:, None], (3, 1, 1)),
        },
    )
    write_npz(
        tmp_path / "tracks.npz",
        {
            "mine.time_s": TIME,
            "mine.channels": np.array(("north", "north_rate")),
            "mine.mean": Z,
            "mine.sigma": np.tile(np.array((10.0, 5.0))[:, None], (3, 1, 2)) * (1.0, 2.0),
        },
    )
    return tmp_path


def rows(path):
    parquet = pytest.importorskip(
        "pyarrow.parquet", reason="pyarrow is not installed: pip install 'shortfinal[parquet]'"
    )
    return parquet.read_table(path).to_pylist()


@pytest.fixture
def written(run_folder):
    """The rows of a table of the folder, by its name."""
    pytest.importorskip("pyarrow", reason="pyarrow is not installed: pip install 'shortfinal[parquet]'")
    export_records(run_folder)
    return lambda name: rows(run_folder / f"{name}.parquet")


def test_contrasts_have_a_row_for_each_figure(run_folder):
    figure = {"ratio": 1 / 3, "low": None, "high": 2.0, "n": 4, "of": 1.0, "against": 3.0}
    tables = {"overall": {"position_m": figure}, "by_phase": {}, "look_ahead": {"20_s": {"position_m": figure}}}
    (run_folder / "metrics.json").write_text(
        json.dumps({"contrasts": [{"of": "a", "against": "b", "name": None, **tables}]})
    )
    (table,) = contrasts(run_folder).values()
    assert {name: column[0] for name, column in table.items()} == {
        "tracker": "a", "other": "b", "name": "", "table": "overall", "part": "", "channel": "position_m",
        "ratio": 1 / 3, "low": pytest.approx(np.nan, nan_ok=True), "high": 2.0, "of": 1.0, "against": 3.0, "n": 4,
    }  # fmt: skip
    assert [table[name][1] for name in ("table", "part")] == ["look_ahead", "20_s"]
    (run_folder / "metrics.json").write_text("{")
    with pytest.raises(OutputError, match=r"metrics.json: damaged; run the scenario again"):
        contrasts(run_folder)


def test_the_flight_comes_back_to_the_last_bit(written):
    found = written("flight")
    assert [row["time_s"] for row in found] == TIME.tolist()
    assert [row["height_m"] for row in found] == [400.0, None, 399.5]
    assert [row["phase"] for row in found] == ["final", "glide", "glide"]


def test_a_sensor_has_a_row_for_each_epoch_and_draw_with_units_and_sigmas(written):
    found = written("measurements.radar")
    assert list(found[0]) == ["time_s", "draw", "range_m", "range_sigma_m", "azimuth_rad", "azimuth_sigma_rad"]
    assert [(row["time_s"], row["draw"]) for row in found] == [(t, d) for t in TIME for d in (0, 1)]
    assert [row["azimuth_rad"] for row in found] == [Z[k, 1, d] for k in range(3) for d in (0, 1)]
    assert {(row["range_sigma_m"], row["azimuth_sigma_rad"]) for row in found} == {(60.0, 0.002)}


def test_a_tracker_has_the_sigma_of_each_draw(written):
    found = written("tracks.mine")
    assert list(found[0])[2:] == ["north_m", "north_sigma_m", "north_rate_mps", "north_rate_sigma_mps"]
    assert [row["north_rate_sigma_mps"] for row in found] == [5.0, 10.0] * 3


def test_nothing_but_parquet_is_added(run_folder):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed: pip install 'shortfinal[parquet]'")
    before = {path.name for path in run_folder.iterdir()}
    found = export_records(run_folder)
    assert {path.name for path in run_folder.iterdir()} - before == {path.name for path in found}
    assert all(path.suffix == ".parquet" and path.is_file() for path in found)


def test_a_run_without_sensors_exports_its_flight(run_folder):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed: pip install 'shortfinal[parquet]'")
    for record in ("measurements", "tracks"):
        write_npz(run_folder / f"{record}.npz", {})
    assert [path.name for path in export_records(run_folder)] == ["flight.parquet"]


def test_parquet_without_pyarrow_is_one_sentence(run_folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(OutputError, match=r"--parquet needs pyarrow: pip install 'shortfinal\[parquet\]'"):
        export_records(run_folder)


def damage_nothing(folder):
    (folder / MARK).unlink()


def damage_missing(folder):
    (folder / "tracks.npz").unlink()


def damage_truncated(folder):
    file = folder / "measurements.npz"
    file.write_bytes(file.read_bytes()[:200])


def damage_inside(folder):
    file = folder / "flight.npz"
    content = bytearray(file.read_bytes())
    content[60:90] = bytes(30)  # within the compressed data of the first array
    file.write_bytes(content)


def damage_text(folder):
    (folder / "flight.npz").write_text("time,height\n")


def damage_objects(folder):
    np.savez(folder / "flight.npz", time_s=np.array([{}], dtype=object))


def damage_version(folder):
    """The byte of a zip file that says which version of the format its first member needs."""
    data = bytearray((folder / "flight.npz").read_bytes())
    data[data.index(b"PK\x01\x02") + 6] = 82
    (folder / "flight.npz").write_bytes(data)


def damage_shapes(folder):
    np.savez(folder / "flight.npz", time_s=np.array(1.0))


def damage_names(folder):
    np.savez(folder / "tracks.npz", **{"../../theirs.time_s": np.zeros(2)})


def damage_link(folder):
    (folder / "flight.parquet").symlink_to(folder.parent / "theirs")


def damage_pipe(folder):
    (folder / "flight.npz").unlink()
    os.mkfifo(folder / "flight.npz")


def damage_figures(folder):
    (folder / "metrics.json").write_text('{"contrasts": [{"of": 1}]}')


def damage_metrics(folder):
    (folder / "metrics.json").write_text("[" * 100_000)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (damage_shapes, r"flight\.npz: damaged"),
        (damage_names, r"tracks\.npz: damaged"),
        (damage_link, r"flight\.parquet in it is a link"),
        (damage_pipe, r"flight\.npz in it is neither a file nor a folder"),
        (damage_figures, r"metrics\.json: damaged"),
        (damage_metrics, r"metrics\.json: damaged"),
        (damage_nothing, "not a run folder"),
        (damage_missing, r"tracks\.npz: missing"),
        (damage_truncated, r"measurements\.npz: damaged"),
        (damage_inside, r"flight\.npz: damaged"),
        (damage_text, r"flight\.npz: damaged"),
        (damage_objects, r"flight\.npz: damaged"),
        (damage_version, r"flight\.npz: damaged"),
    ],
)
def test_a_wrong_folder_is_told_in_one_sentence_and_left_alone(run_folder, damage, said):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed: pip install 'shortfinal[parquet]'")
    damage(run_folder)
    before = sorted(path.name for path in run_folder.iterdir())
    with pytest.raises(OutputError, match=said) as caught:
        export_records(run_folder)
    assert "\n" not in str(caught.value)
    assert sorted(path.name for path in run_folder.iterdir()) == before


def test_no_folder_at_all(tmp_path):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed: pip install 'shortfinal[parquet]'")
    with pytest.raises(OutputError, match="no such folder"):
        export_records(tmp_path / "nowhere")


def test_a_sensor_that_saw_nothing_has_columns_and_no_rows(run_folder):
    empty = {
        "time_s": np.empty(0),
        "channels": np.array(("range",)),
        "z": np.empty((0, 1, 2)),
        "sigma": np.empty((0, 1, 1)),
    }
    table = table_of(empty)
    assert list(table) == ["time_s", "draw", "range_m", "range_sigma_m"]
    assert {len(column) for column in table.values()} == {0}
