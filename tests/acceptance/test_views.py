"""Views and data before foreign judges: fastkml, GDAL, flightgear-python and Stone Soup; and how long tables are.

The Python packages are those of the interpreter named by VIEWS_PYTHON, else they are installed into a temporary
environment; ogrinfo is looked for on the path. Where a judge is missing its tests are skipped.
"""

from __future__ import annotations

import csv
import json
import math
import os
import re
import shutil
import socket
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import sim
from sim.cli.exporting.others import export_kmz
from sim.cli.exporting.spreadsheet import export_spreadsheet
from sim.results.replaying import replay

pytestmark = pytest.mark.acceptance
ROOT = Path(__file__).resolve().parents[2]
JUDGE = ROOT / "tests" / "views_judge.py"
PACKAGES = ("fastkml==1.4.0", "lxml", "flightgear-python==2.1.0", f"{ROOT}[stonesoup,pandas]")
PLACED = ("runway.latitude_deg", 52.1, "runway.longitude_deg", -7.25, "runway.elevation_m", 87.0)
FOOT, KNOT = 0.3048, 1852.0 / 3600.0
EQUATOR, SQUARE = 6378137.0, 6.69437999014e-3  # m, and eccentricity squared [WGS 84]
DRAWS = 5


@pytest.fixture(scope="module")
def flown() -> Any:
    return sim.run("an26_pattern", overrides=dict(zip(PLACED[::2], PLACED[1::2], strict=True)))


@pytest.fixture(scope="module")
def folder(flown: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return flown.save(tmp_path_factory.mktemp("views") / "run")


@pytest.fixture(scope="module")
def judge(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    """The foreign packages by another interpreter: its answer to a command."""
    python = os.environ.get("VIEWS_PYTHON")
    if python is None:
        place = tmp_path_factory.mktemp("judge")
        python = str(place / "bin" / "python")
        install = ([sys.executable, "-m", "venv", place], [python, "-m", "pip", "install", "-q", *PACKAGES])
        if any(subprocess.run(command, capture_output=True, check=False).returncode for command in install):
            pytest.skip("the judges cannot be installed here: name an interpreter that has them in VIEWS_PYTHON")

    def asked(*arguments: Any, told: Any = None) -> Any:
        command = [python, JUDGE, *map(str, arguments)]
        own = {**os.environ, "PYTHONPATH": str(ROOT)}
        found = subprocess.run(
            command, input=json.dumps(told), capture_output=True, text=True, env=own, cwd=ROOT, check=False
        )
        assert found.returncode == 0, found.stderr[-2000:]
        return json.loads(found.stdout)

    return asked


@pytest.fixture(scope="module")
def kmz(folder: Path) -> Path:
    export_kmz(folder, None, None, 0, ())
    return folder / "flight.kmz"


def test_fastkml_validates_the_globe(flown, kmz, judge, row):
    found = judge("kml", kmz)
    row("fastkml, strict: the KMZ of the default run is valid KML 2.2 with gx", "valid", str(found["valid"]).lower(),
        found["valid"])  # fmt: skip
    assert found["valid"]
    assert found["names"][:2] == ["runway", "truth"]
    assert {*found["names"][2:]} == {*flown.tracks}


def in_plane(runway, longitude, latitude, altitude) -> np.ndarray:
    """(2, k) m north and east in the plane that touches the ellipsoid at the threshold, from degrees, by vectors."""

    def earth_centred(longitude, latitude, height):
        sine = np.sin(latitude)
        normal = EQUATOR / np.sqrt(1.0 - SQUARE * sine**2)
        ring = (normal + height) * np.cos(latitude)
        return np.array((ring * np.cos(longitude), ring * np.sin(longitude), (normal * (1.0 - SQUARE) + height) * sine))

    own = runway.longitude, runway.latitude
    away = earth_centred(np.radians(longitude), np.radians(latitude), altitude)
    away -= earth_centred(*own, runway.elevation)[:, None]
    east = np.array((-math.sin(own[0]), math.cos(own[0]), 0.0))
    up = np.array((math.cos(own[1]) * math.cos(own[0]), math.cos(own[1]) * math.sin(own[0]), math.sin(own[1])))
    return np.array((np.cross(up, east) @ away, east @ away))


def lines_of(ogrinfo: str, kmz: Path) -> dict[str, np.ndarray]:
    """Longitude, latitude and altitude (k, 3) of each line as GDAL reads it, by name."""
    text = subprocess.run([ogrinfo, "-ro", "-al", kmz], capture_output=True, text=True, check=True).stdout
    assert "LIBKML" in text
    found = re.findall(r"Name \(String\) = (\w+)\n(?:.*\n)*?  LINESTRING Z? ?\((.*)\)\n", text)
    return {name: np.array([point.split() for point in line.split(",")], float) for name, line in found}


def times_of(kmz: Path) -> dict[str, np.ndarray]:
    """Times (k,) s of each track, by name."""
    ns = {"k": "http://www.opengis.net/kml/2.2", "gx": "http://www.google.com/kml/ext/2.2"}
    marks = ElementTree.fromstring(zipfile.ZipFile(kmz).read("doc.kml")).iterfind(".//k:Placemark", ns)
    stamps = {mark.find("k:name", ns).text: [one.text[:-1] for one in mark.iterfind(".//k:when", ns)] for mark in marks}
    return {name: np.array(own, "M8[ms]").astype(float) / 1e3 - 1767225600.0 for name, own in stamps.items() if own}


def place_of(estimate: dict[str, np.ndarray], sensors: Any) -> np.ndarray:
    """(2, k) m north and east of an estimate, of range, azimuth and elevation by hand."""
    if "north" in estimate:
        return np.array((estimate["north"], estimate["east"]))
    name = next(channel for channel in estimate if channel.endswith(".range")).partition(".")[0]
    slant, azimuth, elevation = (estimate[f"{name}.{one}"] for one in ("range", "azimuth", "elevation"))
    course = azimuth + sensors[name].zero_azimuth
    ahead = slant * np.cos(elevation) * np.array((np.cos(course), np.sin(course)))
    return ahead + np.array(sensors[name].antenna[:2])[:, None]


def test_gdal_opens_the_globe_with_everything_where_it_was(flown, kmz, row):
    ogrinfo = shutil.which("ogrinfo")
    if ogrinfo is None:
        pytest.skip("there is no ogrinfo on the path")
    lines, times = lines_of(ogrinfo, kmz), times_of(kmz)
    state, runway = flown.flight.whole.state, flown.scenario.runway
    degree = math.radians(1.0) * EQUATOR * (1.0 - SQUARE)  # m of latitude at the equator, the shortest there is
    worst, points = 0.0, 0
    for name, line in lines.items():
        if name not in times:
            continue
        where = in_plane(runway, *line.T)
        if name == "truth":
            rows = np.argmin(np.abs(state.time - times[name][:, None]), axis=1)
            expected = np.array((state.north[rows], state.east[rows]))
            assert np.abs(line[:, 2] - runway.elevation - state.height[rows]).max() <= 1e-3
        else:
            one = flown.tracks[name]
            parts = [one.track, *(() if one.rollout is None else (one.rollout,))]
            time = np.concatenate([part.time for part in parts])
            rows = np.argmin(np.abs(time - times[name][:, None]), axis=1)
            mean = np.concatenate([part.mean[..., 0] for part in parts])[rows]
            expected = place_of(dict(zip(parts[0].channels, mean.T, strict=True)), flown.scenario.sensors)
        worst = max(worst, float(np.abs(where - expected).max() / (degree * math.cos(runway.latitude))))
        points += len(line)
    assert {*lines} == {"runway", "truth", *flown.tracks}
    row(f"GDAL (LIBKML): places of {len(lines) - 1} tracks with {points} points, largest error, deg", "<= 1e-6",
        f"{worst:.1e}", worst <= 1e-6)  # fmt: skip
    assert worst <= 1e-6


def rotation(bank: np.ndarray, pitch: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """(n, 3, 3) from north, east, down into body axes, one turn after another."""

    def turn(angle, first, second):
        found = np.tile(np.eye(3), (len(angle), 1, 1))
        found[:, first, first] = found[:, second, second] = np.cos(angle)
        found[:, first, second], found[:, second, first] = np.sin(angle), -np.sin(angle)
        return found

    return turn(bank, 1, 2) @ turn(pitch, 2, 0) @ turn(heading, 0, 1)


def told(state: Any, runway: Any, full: float) -> dict[str, np.ndarray]:
    """What the packets of a record have to say, by the names of flightgear-python."""
    down = np.array((state.velocity_north, state.velocity_east, -state.velocity_up))
    body = np.einsum("nij,jn->in", rotation(state.bank, state.pitch, state.heading), down) / FOOT
    turning = state.pitch_rate * np.sin(state.bank) + state.yaw_rate * np.cos(state.bank)
    force = (state.specific_force_forward, state.specific_force_right, state.specific_force_down)
    gear = np.tile(state.gear[:, None], 3)
    wheels = (state.main_wheels > 0)[:, None] * np.array((0.0, 1.0, 1.0))
    return {
        "alt_m": runway.elevation + state.height, "agl_m": state.height,
        "phi_rad": state.bank, "theta_rad": state.pitch, "psi_rad": np.mod(state.heading, 2 * np.pi),
        "alpha_rad": state.angle_of_attack, "beta_rad": state.sideslip,
        "phidot_rad_per_s": state.roll_rate + np.tan(state.pitch) * turning,
        "thetadot_rad_per_s": state.pitch_rate * np.cos(state.bank) - state.yaw_rate * np.sin(state.bank),
        "psidot_rad_per_s": turning / np.cos(state.pitch),
        "vcas": state.equivalent_airspeed / KNOT, "climb_rate_ft_per_s": state.velocity_up / FOOT,
        **dict(zip((f"v_{axis}_ft_per_s" for axis in ("north", "east", "down")), down / FOOT, strict=True)),
        **dict(zip((f"v_body_{axis}" for axis in "uvw"), body, strict=True)),
        **{f"A_{axis}_pilot_ft_per_s_per_s": one / FOOT for axis, one in zip("XYZ", force, strict=True)},
        "elevator": -state.elevator, "left_aileron": state.aileron, "right_aileron": -state.aileron,
        "rudder": state.rudder, "left_flap": state.flaps / full, "right_flap": state.flaps / full,
        "gear_pos": gear, "wow": wheels,
    }  # fmt: skip


def test_flightgear_python_parses_every_packet_of_a_whole_flight(flown, judge, row, tmp_path):
    """Sent over a socket at the record's own instants; the clock of the test empties the socket while it waits."""
    octets: list[bytes] = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as own:
        own.bind(("127.0.0.1", 0))
        own.setblocking(False)

        class Clock:
            now = 0.0

            def sleep(self, seconds: float) -> None:
                self.now += seconds
                while True:
                    try:
                        octets.append(own.recv(2048))
                    except BlockingIOError:
                        return

        clock = Clock()
        port = own.getsockname()[1]
        sent = replay(flown, f"127.0.0.1:{port}", rate=30.0, clock=lambda: clock.now, sleep=clock.sleep)
        clock.sleep(0.0)
    assert len(octets) == sent.packets
    whole, runway = flown.flight.whole, flown.scenario.runway
    state = whole.state
    assert len(octets) == len(state.time)
    wanted = told(state, runway, flown.prepared.autopilot.landing.flaps)
    (tmp_path / "packets").write_bytes(b"".join(octets))
    np.savez(tmp_path / "expected.npz", **wanted)
    found = judge("packets", tmp_path / "packets", tmp_path / "expected.npz")
    name = max(found["worst"], key=found["worst"].get)
    row(
        f"flightgear-python: {found['packets']} packets of a whole flight, {len(wanted)} fields, largest error, "
        "relative above 1", "<= 1e-5", f"{found['worst'][name]:.1e} ({name})", found["worst"][name] <= 1e-5,
    )  # fmt: skip
    assert found["packets"] == sent.packets
    assert found["worst"][name] <= 1e-5
    parsed = np.frombuffer(b"".join(octets), ">u1").reshape(len(octets), -1)[:, 8:24]
    longitude, latitude = np.degrees(np.frombuffer(parsed.tobytes(), ">f8").reshape(-1, 2).T)
    where = in_plane(runway, longitude, latitude, runway.elevation + state.height)
    away = float(np.abs(where - np.array((state.north, state.east))).max())
    row("places in these packets, largest error, m", "<= 1e-3", f"{away:.1e}", away <= 1e-3)
    assert away <= 1e-3


@pytest.fixture(scope="module")
def soup(judge: Callable[..., Any]) -> Any:
    tables = dict(sim.read("an26_pattern").tables)
    for name in ("contrasts", "checks", "designed"):
        tables.pop(name, None)
    tables |= {"draws": DRAWS, "sensors": {"terminal": tables["sensors"]["terminal"]}}
    tables["trackers"] = {
        "kalman": {"kind": "kalman", "sensors": ["terminal"]},
        "imm": {"kind": "imm", "sensors": ["terminal"]},
    }
    return judge("stonesoup", told=tables)


def test_stone_soup_takes_a_run_and_gives_it_back(soup, row):
    row("Stone Soup: tracks there and back, largest difference of mean and covariance", "0", f"{soup['round_trip']:g}",
        soup["round_trip"] == 0.0)  # fmt: skip
    assert soup["round_trip"] == 0.0


def test_stone_soups_metric_is_ours(soup, row):
    """Its position accuracy is a mean distance; of squared distances it is the square of our RMSE."""
    for what, theirs, ours in (
        ("SIAP position accuracy against our mean error", "distance", "mean"),
        ("root of SIAP position accuracy of squared distances against our RMSE", "rms", "ours"),
    ):
        worst = max(abs(soup[theirs][name] / soup[ours][name] - 1.0) for name in soup[theirs])
        row(f"Stone Soup: {what}, {len(soup[theirs])} trackers, {DRAWS} draws, largest relative difference",
            "<= 1e-3", f"{worst:.1e}", worst <= 1e-3)  # fmt: skip
        assert worst <= 1e-3


def test_stone_soups_filter_runs_on_our_detections_and_is_judged(soup, row):
    found = soup["judged"]
    assert found["completeness"] == 1.0
    row(
        "Stone Soup's extended Kalman filter on our detections, judged: position RMSE, m, below that of the plots",
        f"< {found['raw']:.1f}", f"{found['rmse']:.1f}", found["rmse"] < found["raw"],
    )  # fmt: skip
    assert found["rmse"] < found["raw"]


def test_tables_for_a_spreadsheet_are_short(folder, flown, row, tmp_path):
    written = export_spreadsheet(folder, tmp_path / "tables")
    size = sum(path.stat().st_size for path in written.files) / 1e6
    before = 103.0  # MB of all draws in radians
    row(f"the default run for a spreadsheet: {len(written.files)} tables of one draw, MB", f"<= {before / 5:.0f}",
        f"{size:.1f}", size <= before / 5)  # fmt: skip
    assert size <= before / 5
    with (tmp_path / "tables" / "tracks.intent_imm.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    errors = flown.to_dataframe("errors")
    own = errors[(errors["tracker"] == "intent_imm") & (errors["draw"] == 0)]["position_m"].to_numpy()
    found = np.array([float(line["position_error_m"]) for line in table])[: len(own)]
    worst = float(np.abs(found - own).max())
    row("errors in that table against those of the run, m; files keep estimates in single precision", "<= 5e-3",
        f"{worst:.1e}", worst <= 5e-3)  # fmt: skip
    assert worst <= 5e-3
