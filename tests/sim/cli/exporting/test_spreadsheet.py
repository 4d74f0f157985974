"""Tables for a spreadsheet: what they hold against the run, harmless cells, bad folders and full disks."""

from __future__ import annotations

import csv
import json
import shutil

import numpy as np
import pytest

import sim
from sim.cli.exporting import spreadsheet
from sim.cli.exporting.formats import write_csv
from sim.cli.exporting.spreadsheet import export_spreadsheet, in_degrees
from sim.errors import OutputError
from sim.files import MARK
from sim.studies.folder import identity, stamp
from sim.studies.kept.flight_log import line
from tests.short_run import TABLES as TABLES_OF_RUN

TABLES = [
    "flight", "measurements.radar", "measurements.cluttered", "measurements.cluttered.plots", "measurements.approach",
    "measurements.needle",
    "tracks.kalman", "tracks.imm", "tracks.angle",
]  # fmt: skip


@pytest.fixture
def folder(short_folder, tmp_path):
    return shutil.copytree(short_folder, tmp_path / "run")


def rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def column(table, name):
    return np.array([float(row[name]) for row in table])


def test_a_run_gives_a_table_for_the_flight_each_sensor_and_each_tracker_in_degrees(short_folder, tmp_path):
    found = export_spreadsheet(short_folder, tmp_path / "tables")
    assert [path.name for path in found.files] == [f"{name}.csv" for name in TABLES]
    names = [name for path in found.files for name in rows(path)[0]]
    assert not [name for name in names if "rad" in name.split("_")[-1]]
    assert found.remarks == ()


def test_the_flight_is_the_flight_in_degrees(short_flown, short_folder, tmp_path):
    export_spreadsheet(short_folder, tmp_path / "t", wanted=["flight"])
    table = rows(tmp_path / "t" / "flight.csv")
    np.testing.assert_array_equal(column(table, "time_s"), short_flown.flight.time)
    np.testing.assert_array_equal(column(table, "bank_deg"), np.degrees(short_flown.flight.state.bank))
    assert {row["phase"] for row in table} == {short_flown.flight.phases[index] for index in short_flown.flight.phase}


def test_a_sensor_has_its_truth_and_error_beside_it(short_flown, short_folder, tmp_path):
    export_spreadsheet(short_folder, tmp_path / "t", draw=2, wanted=["measurements.radar"])
    table, record = rows(tmp_path / "t" / "measurements.radar.csv"), short_flown.records["radar"]
    np.testing.assert_array_equal(column(table, "range_m"), record.z[:, 0, 2])
    np.testing.assert_allclose(column(table, "azimuth_deg"), np.degrees(record.z[:, 1, 2]), rtol=1e-15)
    assert {row["draw"] for row in table} == {"2"}
    # the slant range from its antenna by Pythagoras, along a flight that is straight between records
    state = short_flown.flight.state
    away = [np.interp(record.time, state.time, one) for one in (state.north, state.east, state.height)]
    antenna = short_flown.scenario.sensors["radar"].antenna
    slant = np.sqrt(sum((one - own) ** 2 for one, own in zip(away, antenna, strict=True)))
    np.testing.assert_allclose(column(table, "range_truth_m"), slant, atol=0.05)  # m, of a turn within 1/30 s
    error = column(table, "range_m") - column(table, "range_truth_m")
    np.testing.assert_allclose(column(table, "range_error_m"), error, atol=1e-9)
    assert 1.0 < np.std(error) < 300.0


def test_a_tracker_has_truth_errors_and_the_probabilities_of_its_models(short_flown, short_folder, tmp_path):
    export_spreadsheet(short_folder, tmp_path / "t", draw=1, wanted=["tracks.imm"])
    table, track = rows(tmp_path / "t" / "tracks.imm.csv"), short_flown.tracks["imm"].track
    millimetres = 5e-3  # files keep estimates in single precision
    np.testing.assert_allclose(column(table, "east_m"), track.mean[:, 2, 1], atol=millimetres)
    by_pandas = short_flown.to_dataframe("errors")
    own = by_pandas[(by_pandas["tracker"] == "imm") & (by_pandas["draw"] == 1)]
    np.testing.assert_allclose(column(table, "position_error_m"), own["position_m"], atol=millimetres)
    np.testing.assert_allclose(column(table, "cross_track_error_m"), own["cross_track_m"], atol=millimetres)
    for name, true in (("north_error_m", "north_truth_m"), ("east_error_m", "east_truth_m")):
        quantity = name.partition("_")[0]
        np.testing.assert_allclose(column(table, f"{quantity}_m") - column(table, true), column(table, name), atol=1e-9)
    shares = np.array([column(table, name) for name in table[0] if name.startswith("probability of ")])
    np.testing.assert_array_equal(shares.T, track.model_probabilities[..., 1])
    assert not any(name.startswith("probability of model ") for name in table[0])  # they have names


def test_what_nobody_knows_has_no_column(short_folder, tmp_path):
    export_spreadsheet(short_folder, tmp_path / "t", wanted=["tracks.angle"])
    (first, *_) = rows(tmp_path / "t" / "tracks.angle.csv")
    assert {"approach.elevation_truth_deg", "approach.elevation_error_deg"} < {*first}
    assert "approach.elevation_rate_truth_degps" not in first
    assert "position_error_m" not in first


def test_one_draw_is_written_unless_all_are_asked_for(short_flown, short_folder, tmp_path):
    looks = len(short_flown.records["radar"].time)
    export_spreadsheet(short_folder, tmp_path / "one", wanted=["measurements"])
    export_spreadsheet(short_folder, tmp_path / "all", every_draw=True, wanted=["measurements"])
    one, every = (rows(tmp_path / name / "measurements.radar.csv") for name in ("one", "all"))
    assert (len(one), len(every)) == (looks, 3 * looks)
    assert [row for row in every if row["draw"] == "0"] == one
    plots = [rows(tmp_path / name / "measurements.cluttered.plots.csv") for name in ("one", "all")]
    assert [{row["draw"] for row in part} for part in plots] == [{"0"}, {"0", "1", "2"}]


def test_tables_can_be_chosen_by_name_and_by_what_they_are_of(short_folder, tmp_path):
    found = export_spreadsheet(short_folder, tmp_path / "t", wanted=["tracks", "measurements.needle"])
    assert [path.stem for path in found.files] == [
        "tracks.kalman", "tracks.imm", "tracks.angle", "measurements.needle",
    ]  # fmt: skip
    with pytest.raises(OutputError, match=r"--tables track: there is no such table; did you mean 'tracks'\?"):
        export_spreadsheet(short_folder, tmp_path / "u", wanted=["track"])
    assert not (tmp_path / "u").exists()


def test_a_run_without_trackers_has_no_tables_of_tracks(tmp_path):
    alone = sim.run({**TABLES_OF_RUN, "trackers": {}}).save(tmp_path / "run")
    assert "tracks" not in "".join(path.name for path in export_spreadsheet(alone).files)
    with pytest.raises(OutputError, match="--tables tracks: there is no such table; allowed: "):
        export_spreadsheet(alone, wanted=["tracks"])


def test_a_text_that_begins_like_a_formula_is_made_harmless_and_a_number_stays(tmp_path):
    texts = ["=1+1", "+1", "-1", "@SUM(A1)", "\tx", "\rx", "plain", "a=b", ""]
    path = tmp_path / "table.csv"
    write_csv(path, {"=name": np.array(texts), "n": -np.arange(9.0), "k": -np.arange(9)})
    found = rows(path)
    assert [row["'=name"] for row in found] == [f"'{text}".replace("\r", " ") for text in texts[:6]] + texts[6:]
    assert [float(row["n"]) for row in found] == [-float(k) for k in range(9)]
    assert [row["k"] for row in found] == ["0", *(f"-{k}" for k in range(1, 9))]


def test_angles_and_their_names_go_together():
    found = in_degrees({"a_rad": np.array([np.pi]), "b_radps": np.array([1.0]), "radius_m": np.array([2.0])})
    assert {name: values.tolist() for name, values in found.items()} == {
        "a_deg": [180.0], "b_degps": [np.degrees(1.0)], "radius_m": [2.0],
    }  # fmt: skip


def test_more_rows_than_a_sheet_has_are_remarked_upon(short_folder, tmp_path, monkeypatch):
    monkeypatch.setattr(spreadsheet, "MOST_ROWS", 100)
    (remark,) = export_spreadsheet(short_folder, tmp_path / "t", wanted=["flight", "tracks"]).remarks
    assert remark == "flight.csv has 601 rows, and a sheet shows 100: say --draw K"


def test_a_study_has_a_row_for_each_flight(tmp_path):
    (tmp_path / MARK).write_text("")
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache/identity.json").write_text(json.dumps(identity("", 1)))
    log = tmp_path / "flights.jsonl"

    def written(cell, model, **metrics):
        place = {"cell": cell, "sample": 0, "flight": 0, "values": {"aircraft.model": model}}
        return line({**place, "metrics": metrics, "checks": [], "again": ""}, stamp(tmp_path))

    landed = written(1, "=cmd", outcome="landed", reason="", touchdown={"sink_mps": 0.7}, overshoot_m=-3.0)
    crashed = written(0, "an26", outcome="crashed", reason="no worker")
    torn = '{"cell": 2, "samp'
    log.write_text(f"{landed}{crashed}{torn}")
    export_spreadsheet(tmp_path)
    assert (tmp_path / "flights.csv").read_text().splitlines() == [
        "cell,sample,flight,aircraft.model,outcome,overshoot_m,touchdown.sink_mps",
        "0,0,0,an26,crashed,,",
        "1,0,0,'=cmd,landed,-3.0,0.7",
    ]
    assert log.read_text().endswith(torn)  # it may be on its way
    with pytest.raises(OutputError, match="is of a study, which keeps no draws"):
        export_spreadsheet(tmp_path, draw=1)
    log.write_text("")
    with pytest.raises(OutputError, match="no finished flight yet"):
        export_spreadsheet(tmp_path)


def spoiled_foreign(folder):
    (folder / MARK).unlink()


def spoiled_half_written(folder):
    (folder / "tracks.npz").unlink()


def spoiled_truncated(folder):
    file = folder / "measurements.npz"
    file.write_bytes(file.read_bytes()[:300])


def spoiled_arrays(folder):
    np.savez(folder / "tracks.npz", **{"kalman.time_s": np.zeros(2)})


def spoiled_text(folder):
    (folder / "flight.npz").write_text("time,height\n")


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (spoiled_foreign, "not a run folder"),
        (spoiled_half_written, r"half written, tracks\.npz missing"),
        (spoiled_truncated, r"measurements\.npz: damaged"),
        (spoiled_arrays, r"tracks\.npz: damaged"),
        (spoiled_text, r"flight\.npz: damaged"),
    ],
)
def test_a_wrong_folder_is_told_in_one_sentence_and_nothing_is_written(folder, tmp_path, spoil, said):
    spoil(folder)
    with pytest.raises(OutputError, match=said) as caught:
        export_spreadsheet(folder, tmp_path / "tables")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "tables").exists()


@pytest.mark.parametrize("draw", [-1, 3])
def test_a_draw_that_the_run_has_not_is_refused(short_folder, tmp_path, draw):
    with pytest.raises(OutputError, match=f"--draw {draw}: the run has the draws 0 to 2"):
        export_spreadsheet(short_folder, tmp_path / "tables", draw=draw)
    assert not (tmp_path / "tables").exists()


def test_a_target_that_something_else_wrote_is_left_alone(short_folder, tmp_path):
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "flight.csv").write_text("theirs")
    with pytest.raises(OutputError, match="holds files that shortfinal did not write"):
        export_spreadsheet(short_folder, tmp_path / "theirs")
    assert (tmp_path / "theirs" / "flight.csv").read_text() == "theirs"
    with pytest.raises(OutputError, match="holds a run, not tables of a run"):
        export_spreadsheet(short_folder, sim.run(TABLES_OF_RUN, draws=1).save(tmp_path / "other"))
    export_spreadsheet(short_folder, tmp_path / "ours", wanted=["flight"])
    export_spreadsheet(short_folder, tmp_path / "ours", wanted=["flight"])  # again


def test_a_full_disk_leaves_the_old_tables(folder, monkeypatch):
    export_spreadsheet(folder, wanted=["flight"])
    before = (folder / "flight.csv").read_bytes()

    def full(path, columns):
        path.write_text("half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(spreadsheet, "write_csv", full)
    with pytest.raises(OutputError, match="cannot be written: No space left on device"):
        export_spreadsheet(folder, wanted=["flight"])
    assert (folder / "flight.csv").read_bytes() == before
    assert not (folder / ".partial").exists()


def test_the_command_says_what_it_wrote(short_folder, command, tmp_path):
    told = command("export", short_folder, "--csv", "-o", tmp_path / "t", "--tables", "flight,tracks.imm", "--draw", 1)
    assert (told.returncode, told.stderr) == (0, "")
    assert told.stdout.splitlines() == [f"wrote {tmp_path}/t/flight.csv", f"wrote {tmp_path}/t/tracks.imm.csv"]
