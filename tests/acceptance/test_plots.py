"""Recorded plots at full size: the same tracks as of the looks themselves, figures without a truth, damaged files."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sim
from aircraft.runway import Runway as Place
from sim.errors import ScenarioError
from sim.experiment import run_to_folder
from sim.observation.record import SensorRecord
from tests.capture import CAPTURE
from tracking.intervals import proportion
from tracking.motion import planar_constant_velocity

pytestmark = pytest.mark.acceptance
RUNWAY = {"latitude_deg": 50.0, "longitude_deg": 30.0, "heading_deg": 80.0}
MADE, PLOTS, PERIOD, SIGMA, DENSITY = 300, 80, 4.0, 60.0, 1.0  # recordings; plots of each; s, m, m2/s3
DAMAGES = 200
LEVEL, ERRORS = 0.999, 3.3  # of intervals: one seed in a thousand would break them by chance
SAME = 1e-3  # m; azimuths are counted from another zero, and rounded there


def polar_file(path: Path, record: SensorRecord, zero: float) -> str:
    """A file of a radar's looks in draw 0, whole to the last bit; azimuths from north."""
    rows = zip(record.time.tolist(), *record.z[:, :2, 0].T.tolist(), strict=True)
    lines = [f"{time!r},{slant!r},{azimuth + zero!r}" for time, slant, azimuth in rows]
    path.write_text("\n".join(["time,range_m,theta_rad", *lines]) + "\n")
    return str(path)


@pytest.mark.parametrize("name", ["an26_pattern", "a320"])
def test_tracks_of_written_plots_are_those_of_the_looks(name, row, tmp_path):
    """One radar of a bundled scenario is written to a file and read again, all else stays as it is."""
    flown = sim.run(name, draws=1)
    radar = next(
        key for key, table in flown.scenario.tables["sensors"].items() if table["kind"] == "surveillance_radar"
    )
    sensor, place = flown.scenario.sensors[radar], Place(math.radians(50.0), math.radians(30.0))
    north = sensor.zero_azimuth
    table = {
        "kind": "recorded", "file": polar_file(tmp_path / "plots.csv", flown.records[radar], north),
        "position_m": list(sensor.position), "range_sigma_m": sensor.range_sigma,
        "azimuth_sigma_deg": math.degrees(sensor.azimuth_sigma),
        # the file counts from the north of the threshold, which is not quite that of the antenna
        "azimuth_zero_deg": math.degrees(
            (place.geodetic(*sensor.antenna[:2])[1] - place.longitude) * math.sin(place.latitude)
        ),
    }  # fmt: skip
    tables = {**flown.scenario.tables, "sensors": {**flown.scenario.tables["sensors"], radar: table}}
    again = sim.run(tables)
    worst = max(np.abs(one.track.mean - flown.tracks[key].track.mean).max() for key, one in again.tracks.items())
    plots = len(flown.records[radar].time)
    row(
        f"{name}: {plots} plots written and read again, {len(again.tracks)} trackers: largest difference",
        f"<= {SAME:g} m",
        f"{worst:.1e} m",
        bool(worst <= SAME),
    )
    assert worst <= SAME


def made_up(path: Path, generator: Any) -> str:
    """Plots by latitude and longitude of an aircraft whose accelerations are white noise of `DENSITY`."""
    F, Q = planar_constant_velocity(PERIOD, DENSITY, DENSITY)
    state, half = np.array((-30_000.0, 80.0, 5_000.0, -20.0)), np.linalg.cholesky(Q)
    threshold = Place(math.radians(50.0), math.radians(30.0))
    lines = []
    for number in range(PLOTS):
        seen = state[[0, 2]] + SIGMA * generator.standard_normal(2)
        latitude, longitude = np.degrees(threshold.geodetic(*seen)).tolist()
        lines.append(f"2024-05-01T10:{number * 4 // 60:02d}:{number * 4 % 60:02d}Z,{latitude!r},{longitude!r}")
        state = F @ state + half @ generator.standard_normal(4)
    path.write_text("\n".join(["timestamp,latitude,longitude", *lines]) + "\n")
    return str(path)


def alone(file: str, trackers: dict[str, Any], **more: Any) -> dict[str, Any]:
    sensor = {"kind": "recorded", "file": file, "position_sigma_m": SIGMA}
    known = {"name": "plots", "record": {}, "runway": RUNWAY, "sensors": {"radar": sensor}}
    return {**known, "trackers": trackers, **more}


def test_figures_without_a_truth_are_what_they_say(row, tmp_path):
    """Of a tracker that is right about all: bounds hold as often as they say, predictions are as good as they say."""
    generator = np.random.default_rng(8)
    right = {"kind": "kalman", "acceleration_density_m2ps3": DENSITY}
    found = []
    for _ in range(MADE):
        figures = sim.run(alone(made_up(tmp_path / "plots.csv", generator), {"right": right})).metrics["trackers"]
        found.append(figures["right"])
    plots = [one["plots"] for one in found]
    within = sum(its["anis_low"] <= one["anis"] <= its["anis_high"] for one, its in zip(found, plots, strict=True))
    white = sum(abs(its["whiteness"]) <= its["whiteness_limit"] for its in plots)
    for what, count in (("ANIS within its bounds", within), ("neighbours correlate less than the limit", white)):
        share = proportion(count, MADE, LEVEL)
        row(
            f"plots alone, {MADE} recordings of a motion that the tracker knows: {what}",
            f"95 %, within the {LEVEL:.1%} interval",
            f"{share.value:.1%} ({share.low:.1%} to {share.high:.1%})",
            share.contains(0.95),
        )
        assert share.contains(0.95)
    lost = sum(its["lost_time_s"] is not None for its in plots)
    for span in ("20_s", "60_s"):
        ahead = np.array([its["look_ahead"][span]["normalised"] for its in plots])
        mean, error = float(ahead.mean()), ERRORS * float(ahead.std(ddof=1)) / math.sqrt(MADE)
        row(
            f"plots alone, {MADE} recordings: normalised look-ahead, {span.replace('_', ' ')}",
            f"1, within {ERRORS:g} standard errors",
            f"{mean:.3f} +- {error:.3f}",
            abs(mean - 1.0) <= error,
        )
        assert abs(mean - 1.0) <= error
    row(f"plots alone, {MADE} recordings: tracks lost", "none", f"{lost}", lost == 0)
    assert lost == 0


def damaged(text: str, generator: Any) -> bytes:
    """A file with one damage of many kinds at a place by chance."""
    lines = text.splitlines()
    line = int(generator.integers(1, len(lines)))
    cells = lines[line].split(",")
    cell = int(generator.integers(0, len(cells)))
    kind = int(generator.integers(0, 12))
    words = ("", "nan", "inf", "-1", "1e300", "x", "NaT", '"', "1,2")
    if kind < 6:
        cells[cell] = words[int(generator.integers(0, len(words)))]
        lines[line] = ",".join(cells)
    elif kind == 6:
        lines.insert(line, lines[line])  # twice
    elif kind == 7:
        lines[line], lines[-1] = lines[-1], lines[line]  # out of order
    elif kind == 8:
        lines = lines[:line]  # cut off
    elif kind == 9:
        header = lines[0].split(",")
        del header[cell]
        lines[0] = ",".join(header)
    elif kind == 10:
        lines = [",".join(part for place, part in enumerate(one.split(",")) if place != cell) for one in lines]
    content = "\n".join(lines).encode()
    return content[: int(generator.integers(0, len(content)))] + b"\xff\x00" if kind == 11 else content


def test_damaged_plots_have_an_answer_each(row, tmp_path):
    generator = np.random.default_rng(5)
    file = Path(made_up(tmp_path / "plots.csv", generator))
    text, refused, tracked = file.read_text(), 0, 0
    for _ in range(DAMAGES):
        file.write_bytes(damaged(text, generator))
        try:
            result = sim.run(alone(str(file), {"imm": {"kind": "imm"}}))
        except ScenarioError as error:
            refused += len(str(error).splitlines()) == 1
        else:
            assert result.metrics["trackers"]["imm"]["plots"]["looks"] > 0
            json.dumps(result.metrics["trackers"]["imm"]["plots"], allow_nan=False)
            tracked += 1
    row(
        f"{DAMAGES} damaged files of plots",
        "an answer each: one sentence, or a track",
        f"{refused} refused in one sentence, {tracked} tracked",
        refused + tracked == DAMAGES,
    )
    assert min(refused, tracked) > 0


def test_a_page_of_plots_alone_has_no_figure_that_needs_a_truth(row, tmp_path):
    file = made_up(tmp_path / "plots.csv", np.random.default_rng(2))
    trackers = {name: {"kind": name} for name in ("kalman", "imm", "intent_imm", "saturated_control")}
    scenario = tmp_path / "plots.toml"
    text = "\n".join(["[record]", "[runway]", *(f"{key} = {value}" for key, value in RUNWAY.items()), ""])
    text += f'[sensors.radar]\nkind = "recorded"\nfile = "{Path(file).name}"\nposition_sigma_m = {SIGMA}\n'
    scenario.write_text(text + "".join(f'[trackers.{name}]\nkind = "{name}"\n' for name in trackers))
    folder, result = run_to_folder(str(scenario), {}, tmp_path / "out")
    page = (folder / "report.html").read_text(encoding="utf-8")
    metrics = json.loads((folder / "metrics.json").read_text())
    again, _ = run_to_folder(str(folder / "scenario.toml"), {}, tmp_path / "again")
    files = ("scenario.toml", "metrics.json", "flight.npz", "measurements.npz", "tracks.npz", "report.html")
    same = all((folder / name).read_bytes() == (again / name).read_bytes() for name in files)
    told = "no truth: figures from the plots alone" in page and "root mean square error" not in page
    keys = {*sim.run(CAPTURE).metrics} == {*metrics}
    row(
        f"plots alone: page, metrics.json and replay of {len(result.tracks)} trackers",
        "says that there is no truth; the keys of metrics.json; again the same bytes",
        ", ".join(
            word if yes else f"not {word}" for word, yes in (("told", told), ("same keys", keys), ("same bytes", same))
        ),
        told and keys and same,
    )
    assert told
    assert keys
    assert same
