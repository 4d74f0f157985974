"""Tracks that were made elsewhere: what follows by hand from a truth, an offset, a delay, the plots themselves."""

from __future__ import annotations

import csv
import math

import numpy as np
import pytest

from aircraft.runway import Runway as Place
from sim.errors import ScenarioError
from sim.estimation.setup import check
from sim.estimation.tracking_run import track
from sim.flight.interpolation import truth_at
from sim.flight.loop import fly
from sim.flight.preparation import prepare
from sim.observation.record import observe
from sim.scenario.reading import read

DRAWS = 5
CHANGES = {"draws": DRAWS, "until_s": 80.0, "checks": []}
PLACE = ("north_m", "east_m")
SPREAD = ("north_variance_m2", "east_variance_m2", "north_east_covariance_m2")


class Bench:
    """One flight of the point mass with its plots, and the figures of a file of tracks."""

    def __init__(self, folder, changes=CHANGES):
        self.file, self.changes = folder / "mine.csv", changes
        scenario = read("route_capture_point_mass", changes)
        prepared = prepare(scenario)
        self.flight = fly(
            prepared.vehicle, prepared.controller, prepared.initial, prepared.wind(0), prepared.limits, prepared.phases
        )
        self.records = observe(self.flight, scenario.sensors, scenario.seed, 0, scenario.draws)
        self.time = self.records["radar"].time

    def place(self, time):
        return truth_at(self.flight.whole, np.asarray(time)).position[:2].T

    def write(self, header, rows):
        with self.file.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(header)
            writer.writerows([[repr(v) if isinstance(v, float) else v for v in row] for row in rows])

    def judged(self, **table):
        mine = {"kind": "recorded", "file": str(self.file), **table}
        prepared = prepare(read("route_capture_point_mass", {**self.changes, "trackers.mine": mine}))
        check(prepared)
        tracked, figures = track(prepared, self.flight, self.records, {})
        return tracked, figures

    def figures(self, header, rows, **table):
        self.write(header, rows)
        return self.judged(**table)[1]["mine"]


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    return Bench(tmp_path_factory.mktemp("judged"))


def rows_of(bench, time, offset=(0.0, 0.0), late=0.0, draws=DRAWS):
    """The truth at each time, off by an offset, in every draw."""
    where = bench.place(np.asarray(time) - late) + np.array(offset)
    return [[float(t), d, *map(float, p)] for t, p in zip(time, where, strict=True) for d in range(draws)]


def test_the_truth_as_a_track_has_no_error(bench):
    found = bench.figures(("time_s", "draw", *PLACE), rows_of(bench, bench.time))
    assert found["overall"]["position_m"]["rmse"] == pytest.approx(0.0, abs=1e-9)
    assert found["track"]["completeness"] == 1.0
    assert (found["anees"], found["anis"], found["look_ahead"]) == (None, None, {})
    assert any("covariance" in reason for reason in found["not_known"])


def test_a_known_offset_with_a_known_covariance(bench):
    """30 m and 40 m of standard deviations 30 m and 80 m: 50 m, and (1 + 1/4) / 2 of what it states."""
    rows = [[*row, 900.0, 6400.0, 0.0] for row in rows_of(bench, bench.time, (30.0, 40.0))]
    found = bench.figures(("time_s", "draw", *PLACE, *SPREAD), rows)
    assert found["overall"]["position_m"]["rmse"] == pytest.approx(50.0, abs=1e-9)
    assert found["anees"] == pytest.approx(0.625, abs=1e-9)
    assert found["lost_fraction"] == 0.0


def test_a_covariance_that_is_not_diagonal_counts_whole(bench):
    """P = [[2, 1], [1, 2]] has the inverse [[2, -1], [-1, 2]] / 3: an error (1, 1) has 2/3, half of it a dimension."""
    rows = [[*row, 2.0, 2.0, 1.0] for row in rows_of(bench, bench.time, (1.0, 1.0))]
    found = bench.figures(("time_s", "draw", *PLACE, *SPREAD), rows)
    assert found["anees"] == pytest.approx(1.0 / 3.0, abs=1e-7)  # places of 4 km have 12 digits


def test_the_plots_as_a_track_gain_nothing(bench):
    z = bench.records["radar"].z
    rows = [[float(t), d, *map(float, z[k, :, d])] for k, t in enumerate(bench.time) for d in range(DRAWS)]
    found = bench.figures(("time_s", "draw", *PLACE), rows)["overall"]["position_m"]
    assert (found["gain"], found["gain_low"], found["gain_high"]) == pytest.approx((1.0, 1.0, 1.0))
    assert found["rmse"] == pytest.approx(found["raw"])


def test_a_track_that_is_late_is_off_by_what_was_flown_meanwhile(bench):
    time = bench.time[2:]
    found = bench.figures(("time_s", "draw", *PLACE), rows_of(bench, time, late=2.0))
    flown = np.hypot(*(bench.place(time) - bench.place(time - 2.0)).T)
    assert found["overall"]["position_m"]["rmse"] == pytest.approx(math.sqrt(np.mean(flown**2)), rel=1e-9)
    assert 195.0 < flown.mean() < 201.0  # at 100 m/s


def test_the_order_of_rows_does_not_matter(bench):
    rows = [[*row, 900.0, 900.0, 0.0] for row in rows_of(bench, bench.time, (7.0, -3.0))]
    straight = bench.figures(("time_s", "draw", *PLACE, *SPREAD), rows)
    np.random.default_rng(1).shuffle(rows)
    assert bench.figures(("time_s", "draw", *PLACE, *SPREAD), rows) == straight


def test_longitudes_across_the_date_line(tmp_path):
    """A runway at 179.999 degrees east: 300 m to the east of it is in the west."""
    runway = {"latitude_deg": 20.0, "longitude_deg": 179.999, "heading_deg": 0.0}
    bench = Bench(tmp_path, {**CHANGES, "runway": runway, "start.cross_track_m": 3000.0})
    place = Place(math.radians(20.0), math.radians(179.999), 0.0)
    rows = []
    for t, (north, east) in zip(bench.time, bench.place(bench.time), strict=True):
        latitude, longitude = map(math.degrees, place.geodetic(north, east))
        rows += [[float(t), d, latitude, (longitude + 180.0) % 360.0 - 180.0] for d in range(DRAWS)]
    assert any(row[3] < 0.0 for row in rows)
    found = bench.figures(("time_s", "draw", "latitude", "longitude"), rows)
    assert found["overall"]["position_m"]["rmse"] == pytest.approx(0.0, abs=1e-3)  # 15 digits of an angle are 1e-8 m


def test_one_of_our_own_tracks_is_judged_as_it_was(bench):
    tracked, figures = bench.judged()
    ours = tracked["constant_velocity"].track
    north, east = ours.channels.index("north"), ours.channels.index("east")
    cov = np.broadcast_to(ours.cov.astype(float), (*ours.cov.shape[:3], DRAWS))
    rows = [
        [float(t), d, float(ours.mean[k, north, d]), float(ours.mean[k, east, d])]
        + [float(cov[k, i, j, d]) for i, j in ((north, north), (east, east), (north, east))]
        for k, t in enumerate(ours.time)
        for d in range(DRAWS)
    ]
    mine, own = bench.figures(("time_s", "draw", *PLACE, *SPREAD), rows), figures["constant_velocity"]
    for table in ("overall", "by_phase"):
        for name, inner in own[table].items():
            parts = {name: inner} if table == "overall" else inner
            others = {name: mine[table][name]} if table == "overall" else mine[table][name]
            for channel, figure in parts.items():
                assert others[channel] == pytest.approx(figure, rel=1e-9)
    # covariances are kept in single precision
    assert mine["anees"] == pytest.approx(own["anees"], rel=1e-6)
    assert mine["lost_fraction"] == own["lost_fraction"]


def test_a_broken_track_by_hand(bench):
    """Twenty looks of each draw; draw 0 begins at the third and changes its number, draw 1 has a hole of two looks."""
    time = bench.time[:19]
    assert len(bench.time) == 19
    rows = [[*row, 1] for row in rows_of(bench, time)]
    kept = []
    for row in rows:
        k = int(np.flatnonzero(time == row[0])[0])
        if (row[1] == 0 and k < 2) or (row[1] == 1 and k in (7, 8)):
            continue
        kept.append([*row[:4], 2 if row[1] == 0 and k > 9 else 1])
    found = bench.figures(("time_s", "draw", *PLACE, "track_number"), kept)["track"]
    assert found["completeness"] == pytest.approx((17 / 19 + 17 / 19 + 3) / 5)
    assert found["initiation_s"] == pytest.approx(8.0 / 5)  # two looks of 4 s, in one of five draws
    assert found["longest_gap_s"] == pytest.approx(12.0)
    assert found["number_changes"] == pytest.approx(1 / 5)
    assert found["redundant_fraction"] == 0.0


def test_absent_estimates_are_left_out_and_not_counted_as_right(bench):
    """Every second look is off by 10 m and draw 0 has no others: it errs by 10 m, those with all by less."""
    rows = [row for row in rows_of(bench, bench.time) if row[1] > 0 or round(row[0] / 4) % 2]
    for row in rows:
        row[2] += 10.0 if round(row[0] / 4) % 2 else 0.0
    found = bench.figures(("time_s", "draw", *PLACE), rows)["overall"]["position_m"]
    share = np.mean([round(t / 4) % 2 for t in bench.time])
    assert found["rmse"] == pytest.approx(math.sqrt((100.0 + 4 * 100.0 * share) / 5))


def test_of_two_tracks_the_one_that_is_followed_goes_on(bench):
    """Track 7 is there from the third look on, exact; track 3 is off by 90 m and ends at the tenth."""
    near, far = rows_of(bench, bench.time), rows_of(bench, bench.time, (0.0, 90.0))
    rows = [[*row, 7] for row in near if row[0] >= bench.time[2]] + [
        [*row, 3] for row in far if row[0] < bench.time[10]
    ]
    found = bench.figures(("time_s", "draw", *PLACE, "track"), rows)
    assert found["track"]["number_changes"] == 1.0
    assert found["track"]["redundant_fraction"] == pytest.approx(8 / 19)
    assert found["overall"]["position_m"]["rmse"] == pytest.approx(90.0 * math.sqrt(10 / 19))


def test_a_file_without_draws_is_of_the_first(bench):
    rows = [[row[0], *row[2:]] for row in rows_of(bench, bench.time, (30.0, 40.0), draws=1)]
    found = bench.figures(("time_s", *PLACE), rows)
    assert found["overall"]["position_m"]["rmse"] == pytest.approx(50.0)
    assert found["track"]["begun_fraction"] == pytest.approx(1 / DRAWS)


@pytest.mark.parametrize(
    ("header", "row", "said"),
    [
        (("time_s", *PLACE), (500.0, 0.0, 0.0), "estimates are of 500.0 s to 500.0 s, and the flight lasts"),
        (("time_s", *PLACE), (8.0, 9e5, 0.0), "never come nearer to the aircraft than 899 km"),
        (("time_s", "draw", *PLACE), (8.0, 7, 0.0, 0.0), "has estimates of draw 7, and the scenario has draws 0 to 4"),
        (("time_s", "draw", *PLACE), (8.0, 0.5, 0.0, 0.0), "line 2: '0.5' is no number of a draw"),
        (("time_s", *PLACE, *SPREAD), (8.0, 0.0, 0.0, 1.0, 1.0, 2.0), "line 2: its covariance is none"),
        (("time_s", *PLACE, *SPREAD), (8.0, 0.0, 0.0, -1.0, 1.0, 0.0), "line 2: its covariance is none"),
        (("time_s", "north_m"), (8.0, 0.0), "has a column of north and none of east"),
        (("time_s", "speed"), (8.0, 0.0), "no columns say a place"),
        (PLACE, (0.0, 0.0), "no column says the time"),
        (("time_s", *PLACE, "latitude", "longitude"), (8.0, 0.0, 0.0, 1.0, 1.0), "says the place twice"),
        (("time_s", *PLACE), (8.0, "nan", 0.0), "is no place"),
    ],
)
def test_what_cannot_be_judged_is_one_sentence(bench, header, row, said):
    bench.write(header, [row])
    with pytest.raises(ScenarioError, match=said) as told:
        bench.judged()
    assert "\n" not in str(told.value)


def test_the_same_track_twice_at_one_time_is_refused(bench):
    bench.write(("time_s", *PLACE), [(8.0, 0.0, 0.0), (8.0, 1.0, 1.0)])
    with pytest.raises(ScenarioError, match="has two estimates of one track at 8 s in draw 0"):
        bench.judged()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"trackers.other": {"kind": "kalman", "handover": "mine"}}, "'mine' is recorded, and hands nothing over"),
        ({"trackers.mine.handover": "constant_velocity"}, "handover: a recorded track is judged as it is"),
        ({"autopilot.navigation": "mine", "draws": 1}, "'mine' is recorded, and cannot lead an aircraft"),
        ({"study.samples": 3}, "is the track of one flight, and \\[study\\] flies others"),
        ({"trackers.mine.sha256": "0" * 64}, "has changed since: its SHA-256 is not 0000"),
    ],
)
def test_what_a_recorded_track_cannot_be_asked(bench, changes, said):
    bench.write(("time_s", *PLACE), [(8.0, 0.0, 3000.0)])
    mine = {"trackers.mine": {"kind": "recorded", "file": str(bench.file)}}
    with pytest.raises(ScenarioError, match=said):
        check(prepare(read("route_capture_point_mass", {**CHANGES, **mine, **changes})))


def test_a_scenario_keeps_the_path_and_the_digest_of_the_file(bench):
    bench.write(("time_s", *PLACE), [(8.0, 0.0, 3000.0)])
    scenario = read("route_capture_point_mass", {"trackers.mine": {"kind": "recorded", "file": str(bench.file)}})
    table = scenario.tables["trackers"]["mine"]
    assert table["file"] == str(bench.file)
    bench.file.write_text("time_s,north_m,east_m\n8,1,1\n")
    with pytest.raises(ScenarioError, match="has changed since"):
        read(scenario.tables)
