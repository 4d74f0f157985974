"""Every tracker of the default run written out and judged again, from CSV and from CAT062."""

from __future__ import annotations

import csv
from typing import Any

import numpy as np
import pytest

import sim
from sim.cli.exporting.others import export_asterix
from sim.results.judging import with_track

pytestmark = pytest.mark.acceptance

DRAWS = 30
PLANE = ("north", "north_rate", "east", "east_rate")
HEADER = (
    "time_s", "draw", "north_m", "north_rate_mps", "east_m", "east_rate_mps",
    "north_variance_m2", "east_variance_m2", "north_east_covariance_m2",
)  # fmt: skip
BIT = 0.5  # m, of I062/100: an estimate moves by half of it along each axis at most


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The default run in a folder, with the names of its trackers on the plane."""
    folder = tmp_path_factory.mktemp("judge") / "run"
    result = sim.run("an26_pattern", draws=DRAWS)
    sim.report(result, folder)
    export_asterix(folder, None, None, False, ())
    names = [name for name, one in result.tracks.items() if set(PLANE) <= set(one.track.channels)]
    return folder, result, names


def write(path, tracked) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(HEADER)
        for track in filter(None, (tracked.track, tracked.rollout)):
            rows = [track.channels.index(one) for one in PLANE]
            n, _, e, _ = rows
            cov = np.broadcast_to(np.asarray(track.cov, float), (*track.cov.shape[:3], DRAWS))
            for k, time in enumerate(track.time):
                for draw in range(DRAWS):
                    spread = (cov[k, n, n, draw], cov[k, e, e, draw], cov[k, n, e, draw])
                    values = (*track.mean[k, rows, draw], *spread)
                    writer.writerow([repr(float(time)), draw, *(repr(float(value)) for value in values)])


def compared(own: dict[str, Any], back: dict[str, Any]):
    """Pairs of all figures of errors."""
    for table in ("overall", "by_phase"):
        mine, other = ({"": f[table]} if table == "overall" else f[table] for f in (own, back))
        for part, channels in mine.items():
            for channel, figure in channels.items():
                for key, value in figure.items():
                    yield f"{part}.{channel}.{key}", value, other[part][channel][key]


def again(folder, result, name, file):
    tables = with_track(folder, "back", file, list(result.scenario.trackers[name].sensors))
    tables["trackers"] = {"back": tables["trackers"]["back"]}
    tables["contrasts"], tables["checks"] = [], []
    return sim.run(tables).metrics["trackers"]["back"]


def test_our_own_tracks_come_back(run, row, tmp_path):
    folder, result, names = run
    assert len(names) >= 10
    worst = {"csv": 0.0, "anees": 0.0, "asterix": 0.0}
    figures = 0
    for name in names:
        own = result.metrics["trackers"][name]
        write(tmp_path / f"{name}.csv", result.tracks[name])
        back = again(folder, result, name, tmp_path / f"{name}.csv")
        for place, mine, other in compared(own, back):
            assert (mine is None) == (other is None), f"{name} {place}"
            if mine is not None:
                figures += 1
                worst["csv"] = max(worst["csv"], abs(other - mine) / max(abs(mine), 1e-6))
        worst["anees"] = max(worst["anees"], abs(back["anees"] / own["anees"] - 1.0))
        assert back["lost_fraction"] == own["lost_fraction"]
        back = again(folder, result, name, folder / f"tracks.{name}.ast")
        for place, mine, other in compared(own, back):
            if place.endswith("m.rmse"):
                worst["asterix"] = max(worst["asterix"], abs(other - mine))
    row(
        f"{len(names)} trackers of the default run written as CSV and judged again: {figures} figures of errors, "
        "largest relative difference", "<= 1e-9", f"{worst['csv']:.1e}", worst["csv"] <= 1e-9,
    )  # fmt: skip
    row("their ANEES (covariances are kept in single precision), relative", "<= 1e-6", f"{worst['anees']:.1e}",
        worst["anees"] <= 1e-6)  # fmt: skip
    limit = BIT / 2 * 2**0.5
    row("written as CAT062: largest difference of an RMSE in metres, half a bit along both axes", f"<= {limit:.3f}",
        f"{worst['asterix']:.4f}", worst["asterix"] <= limit)  # fmt: skip
    assert worst["csv"] <= 1e-9
    assert worst["anees"] <= 1e-6
    assert worst["asterix"] <= limit
