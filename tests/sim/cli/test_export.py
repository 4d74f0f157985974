"""CSV and Parquet against the arrays they were written from, and every way in which a folder can be wrong."""

from __future__ import annotations

import csv
import json
import os
import sys

import numpy as np
import pytest

from sim.cli.export import export
from sim.errors import OutputError
from sim.files import MARK, write_npz
from sim.studies.folder import identity, stamp
from sim.studies.kept.flight_log import line

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
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_contrasts_have_a_row_for_each_figure(run_folder):
    figure = {"ratio": 1 / 3, "low": None, "high": 2.0, "n": 4, "of": 1.0, "against": 3.0}
    tables = {"overall": {"position_m": figure}, "by_phase": {}, "look_ahead": {"20_s": {"position_m": figure}}}
    (run_folder / "metrics.json").write_text(
        json.dumps({"contrasts": [{"of": "a", "against": "b", "name": None, **tables}]})
    )
    assert "contrasts.csv" in [path.name for path in export(run_folder, "csv")]
    first, second = rows(run_folder / "contrasts.csv")
    assert first == {
        "tracker": "a", "other": "b", "name": "", "table": "overall", "part": "", "channel": "position_m",
        "ratio": repr(1 / 3), "low": "", "high": "2.0", "of": "1.0", "against": "3.0", "n": "4",
    }  # fmt: skip
    assert second == {**first, "table": "look_ahead", "part": "20_s"}
    (run_folder / "metrics.json").write_text("{")
    with pytest.raises(OutputError, match=r"metrics.json: damaged; run the scenario again"):
        export(run_folder, "csv")


def test_the_flight_comes_back_to_the_last_bit(run_folder):
    export(run_folder, "csv")
    found = rows(run_folder / "flight.csv")
    assert [float(row["time_s"]) for row in found] == TIME.tolist()
    assert [row["height_m"] for row in found] == ["400.0", "", "399.5"]
    assert [row["phase"] for row in found] == ["final", "glide", "glide"]


def test_a_sensor_has_a_row_for_each_epoch_and_draw_with_units_and_sigmas(run_folder):
    export(run_folder, "csv")
    found = rows(run_folder / "measurements.radar.csv")
    assert list(found[0]) == ["time_s", "draw", "range_m", "range_sigma_m", "azimuth_rad", "azimuth_sigma_rad"]
    assert [(float(r["time_s"]), int(r["draw"])) for r in found] == [(t, d) for t in TIME for d in (0, 1)]
    assert [float(r["azimuth_rad"]) for r in found] == [Z[k, 1, d] for k in range(3) for d in (0, 1)]
    assert {(float(r["range_sigma_m"]), float(r["azimuth_sigma_rad"])) for r in found} == {(60.0, 0.002)}


def test_a_tracker_has_the_sigma_of_each_draw(run_folder):
    export(run_folder, "csv")
    found = rows(run_folder / "tracks.mine.csv")
    assert list(found[0])[2:] == ["north_m", "north_sigma_m", "north_rate_mps", "north_rate_sigma_mps"]
    assert [float(r["north_rate_sigma_mps"]) for r in found] == [5.0, 10.0] * 3


def test_nothing_but_csv_is_added(run_folder):
    before = {path.name for path in run_folder.iterdir()}
    written = export(run_folder, "csv")
    assert {path.name for path in run_folder.iterdir()} - before == {path.name for path in written}
    assert all(path.suffix == ".csv" and path.is_file() for path in written)


def test_a_run_without_sensors_exports_its_flight(run_folder):
    for record in ("measurements", "tracks"):
        write_npz(run_folder / f"{record}.npz", {})
    assert [path.name for path in export(run_folder, "csv")] == ["flight.csv"]


def test_parquet_holds_what_csv_holds_with_its_types(run_folder):
    parquet = pytest.importorskip(
        "pyarrow.parquet", reason="pyarrow is not installed: pip install 'shortfinal[parquet]'"
    )
    names = {path.stem for path in export(run_folder, "csv")}
    assert {path.stem for path in export(run_folder, "parquet")} == names
    flight = parquet.read_table(run_folder / "flight.parquet").to_pydict()
    assert flight == {
        "time_s": TIME.tolist(),
        "height_m": [400.0, None, 399.5],
        "phase": ["final", "glide", "glide"],
    }
    radar = parquet.read_table(run_folder / "measurements.radar.parquet").to_pydict()
    assert radar["draw"] == [0, 1] * 3
    assert radar["azimuth_rad"] == Z[:, 1].ravel().tolist()
    for name in names:
        table = parquet.read_table(run_folder / f"{name}.parquet")
        assert table.num_rows == len(rows(run_folder / f"{name}.csv"))


def test_parquet_without_pyarrow_is_one_sentence(run_folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(OutputError, match=r"--parquet needs pyarrow: pip install 'shortfinal\[parquet\]'"):
        export(run_folder, "parquet")


def test_a_study_has_a_row_for_each_flight(tmp_path):
    (tmp_path / MARK).write_text("")
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache/identity.json").write_text(json.dumps(identity("", 1)))
    log = tmp_path / "flights.jsonl"

    def written(cell, speed, **metrics):
        place = {"cell": cell, "sample": 0, "flight": 0, "values": {"wind.speed_mps": speed}}
        return line({**place, "metrics": metrics, "checks": [], "again": ""}, stamp(tmp_path))

    landed = written(1, 5.0, outcome="landed", reason="", touchdown={"sink_mps": 0.7}, overshoot_m=3.0)
    crashed = written(0, 0.0, outcome="crashed", reason="no worker")
    torn = '{"cell": 2, "samp'
    log.write_text(f"{landed}{crashed}{torn}")
    export(tmp_path, "csv")
    assert (tmp_path / "flights.csv").read_text().splitlines() == [
        "cell,sample,flight,wind.speed_mps,outcome,overshoot_m,touchdown.sink_mps",
        "0,0,0,0.0,crashed,,",
        "1,0,0,5.0,landed,3.0,0.7",
    ]
    assert log.read_text().endswith(torn)  # it may be on its way
    log.write_text("")
    with pytest.raises(OutputError, match="no finished flight yet"):
        export(tmp_path, "csv")


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
    (folder / "flight.csv").symlink_to(folder.parent / "theirs")


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
        (damage_link, r"flight\.csv in it is a link"),
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
    damage(run_folder)
    before = sorted(path.name for path in run_folder.iterdir())
    with pytest.raises(OutputError, match=said) as caught:
        export(run_folder, "csv")
    assert "\n" not in str(caught.value)
    assert sorted(path.name for path in run_folder.iterdir()) == before


def test_no_folder_at_all(tmp_path):
    with pytest.raises(OutputError, match="no such folder"):
        export(tmp_path / "nowhere", "csv")


def test_a_sensor_that_saw_nothing_has_a_header_and_no_rows(run_folder):
    empty = {
        "time_s": np.empty(0),
        "channels": np.array(("range",)),
        "z": np.empty((0, 1, 2)),
        "sigma": np.empty((0, 1, 1)),
    }
    write_npz(run_folder / "measurements.npz", {f"radar.{name}": array for name, array in empty.items()})
    export(run_folder, "csv")
    assert (run_folder / "measurements.radar.csv").read_text() == "time_s,draw,range_m,range_sigma_m\n"
