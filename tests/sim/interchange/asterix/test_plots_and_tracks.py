"""What of a feed are plots of an aircraft, and estimates of tracks: choices, midnights, what is left out."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from sim.errors import ScenarioError
from sim.interchange.asterix.blocks import AsterixError
from sim.interchange.asterix.plots import read_plots
from sim.interchange.asterix.tracks import identification, letters_of, read_estimates
from sim.interchange.asterix.writing import (
    Estimates,
    address_of,
    code_of,
    north_markers,
    position_reports,
    system_tracks,
    target_reports,
    time_of_day,
)
from sim.interchange.tracks import read_tracks
from tests.asterix_blocks import MARKER, PLOT, REPORT, TRACK, capture

NM, FOOT = 1852.0, 0.3048
DAY = 86400.0


def changed(block, place, octets):
    """A block with other octets from a place on."""
    octets = bytes.fromhex(octets)
    return block[:place] + octets + block[place + len(octets) :]


def later(block, place, seconds):
    """A block of another time of day, which stands at a place."""
    return changed(block, place, format(round(seconds * 128), "06x"))


def at(seconds):
    return later(PLOT, 7, seconds)


# ---- plots ---------------------------------------------------------------------------------------------------------
def test_a_plot_is_what_its_octets_say():
    plots = read_plots(PLOT)
    assert not plots.stamps.dated
    assert plots.stamps.time.tolist() == [36000.25]
    assert plots.range == pytest.approx([10.5 * NM])
    assert plots.azimuth == pytest.approx([math.pi / 2])
    assert plots.pressure_altitude == pytest.approx([3525 * FOOT])
    assert plots.height is plots.latitude is plots.range_sigma is plots.sea_level_height is plots.antenna is None


def test_a_report_of_adsb_is_a_plot_by_latitude_and_longitude():
    plots = read_plots(capture(REPORT))
    assert plots.latitude == pytest.approx([math.pi / 4])
    assert plots.longitude == pytest.approx([-math.pi / 2])
    assert plots.pressure_altitude == pytest.approx([3525 * FOOT])
    assert plots.range is plots.azimuth is None
    assert plots.stamps.time.tolist() == [36000.25]


def test_service_messages_say_where_the_antenna_stands():
    mine = changed(MARKER, 5, "0001")
    assert read_plots(MARKER + PLOT).antenna is None  # of another radar
    assert read_plots(mine + PLOT).antenna == pytest.approx((math.pi / 4, -math.pi / 2, 310.0))


def test_times_of_day_go_on_beyond_midnight_also_where_blocks_are_out_of_order():
    plots = read_plots(at(86396) + at(0.5) + at(86399.5) + at(4))
    assert plots.stamps.time.tolist() == [86396.0, 86399.5, 86400.5, 86404.0]


@pytest.mark.parametrize(
    ("feed", "target", "times"),
    [
        (at(1) + changed(at(2), 19, "F00004"), "f00003", [1.0]),
        (at(1) + changed(at(2), 19, "F00004"), "F00004", [2.0]),
    ],
)
def test_an_aircraft_is_chosen_by_its_address(feed, target, times):
    assert read_plots(feed, target).stamps.time.tolist() == times


def test_without_addresses_an_aircraft_is_chosen_by_track_number_else_by_code():
    made = {"range": np.array([1e4, 2e4]), "azimuth": np.zeros(2)}
    stamps, draw = np.array([1.0, 2.0]), np.array([0, 12])
    primary = target_reports(1, stamps, draw, made, sent=stamps, cooperative=False, numbered=True)
    content = primary.octets.tobytes()
    assert read_plots(content, "12").stamps.time.tolist() == [2.0]
    with pytest.raises(AsterixError, match='plots of 2 aircraft; say target = "0", or another'):
        read_plots(content)
    # the specification 1111100 0 of records without 220 and 161
    code = bytes.fromhex("30 0010 F8 0001 000080 B0 01000000 0201 30 0010 F8 0001 000100 B0 01000000 0C38")
    assert read_plots(code, "6070").stamps.time.tolist() == [2.0]
    one = target_reports(1, stamps, draw, made, sent=stamps, cooperative=False, numbered=False).octets.tobytes()
    assert read_plots(one).stamps.time.tolist() == [1.0, 2.0]
    with pytest.raises(AsterixError, match="does not say whose plots it has, so there is no target 'x'"):
        read_plots(one, "x")


def test_of_several_radars_one_is_chosen():
    feed = at(1) + changed(at(2), 5, "1907")
    assert read_plots(feed, source="25/7").stamps.time.tolist() == [2.0]
    with pytest.raises(AsterixError, match=re.escape('several radars or receivers, 0/1, 25/7; say source = "0/1"')):
        read_plots(feed)
    with pytest.raises(AsterixError, match=re.escape("no plots of the source '1/1'; it has 0/1, 25/7")):
        read_plots(feed, source="1/1")


def test_what_is_no_plot_of_an_aircraft_is_left_out_and_told():
    feed = at(1) + changed(at(2), 10, "10") + changed(at(3), 10, "B2") + at(4) + changed(at(5), 17, "408D")
    plots = read_plots(feed)
    assert plots.stamps.time.tolist() == [1.0, 4.0, 5.0]
    assert np.isnan(plots.pressure_altitude).tolist() == [False, False, True]  # G: garbled
    assert plots.remarks == (
        "1 reports without a detection (predicted, I048/020) are left out",
        "1 reports of field monitors and test targets are left out",
        "1 Mode C heights that are garbled or not validated are taken for unknown",
    )


def test_two_plots_at_one_time_are_refused():
    with pytest.raises(
        AsterixError, match=re.escape("two plots at 7.000 s of the day, and nothing says which is that")
    ):
        read_plots(at(7) + at(7))


def test_a_feed_without_plots_says_why():
    with pytest.raises(AsterixError, match=re.escape("has no plots: 1 reports without a detection")):
        read_plots(changed(PLOT, 10, "10"))
    with pytest.raises(AsterixError, match="categories that are read here, 048, 021: it has 062"):
        read_plots(TRACK)


# ---- tracks --------------------------------------------------------------------------------------------------------
def test_an_estimate_is_what_its_octets_say():
    found = read_estimates(TRACK + later(TRACK, 9, 1.5))
    assert found.time.tolist() == [86399.5, DAY + 1.5]
    assert found.number.tolist() == [3.0, 3.0]
    assert (found.sac[0], found.sic[0], found.address[0], found.code[0]) == (0, 5, 0xF00003, 0o1001)
    assert (found.latitude[0], found.longitude[0]) == pytest.approx((math.pi / 4, -math.pi / 2))
    assert (found.x[0], found.y[0], found.velocity_x[0], found.velocity_y[0]) == (-1000.0, 250.5, -75.25, 70.0)
    np.testing.assert_allclose(found.position_cov[0], [[900.0, -400.0], [-400.0, 49.5**2]])
    np.testing.assert_allclose(found.velocity_sigma[0], [5.0, 3.25])
    assert np.isnan(found.pressure_altitude).all()


def test_an_estimate_of_adsb_has_a_velocity_from_speed_and_course():
    found = read_estimates(REPORT)
    speed = 640 * NM / 2**14
    assert (found.velocity_x[0], found.velocity_y[0]) == pytest.approx((-speed, 0.0), abs=1e-12)
    assert np.isnan(found.x[0])
    assert np.isnan(found.position_cov[0]).all()


def test_a_covariance_that_was_rounded_stays_one():
    cov = np.array([[[100.2], [99.9]], [[99.9], [99.7]]])
    found = read_estimates(system_tracks(1, estimate(position_cov=cov)).octets.tobytes()).position_cov[0]
    assert np.linalg.eigvalsh(found).min() > 0.0
    np.testing.assert_allclose(found, [[100.0, 99.9], [99.9, 100.0]], rtol=1e-3)


def estimate(**changes):
    cov = np.array([[[900.0], [-400.0]], [[-400.0], [49.5**2]]])
    one = Estimates(
        np.array([86399.5]), np.array([3]), np.array([math.pi / 4]), np.array([-math.pi / 2]),
        np.array([[-1000.0], [250.5]]), np.array([[-75.25], [70.0]]), cov, np.array([[5.0], [3.25]]),
        np.array([True]), np.array([False]),
    )  # fmt: skip
    return one._replace(**changes)


def test_a_track_leaves_as_the_octets_that_were_worked_out():
    made = system_tracks(5, estimate()).octets.tobytes()
    assert made == changed(TRACK, 30, "0204")  # the code of draw 3: 1001 octal and 3


def test_accuracies_beyond_their_bits_are_the_largest_there_are_and_a_track_may_have_no_velocity():
    wild = estimate(velocity=np.full((2, 1), np.nan), velocity_sigma=np.full((2, 1), np.nan))
    cov = np.array([[[1e12], [9e11]], [[9e11], [1e12]]])
    found = read_estimates(system_tracks(5, wild._replace(position_cov=cov)).octets.tobytes())
    assert found.position_cov[0, 0, 0] == 32767.0**2
    assert np.isnan(found.velocity_x[0])
    assert np.isnan(found.velocity_sigma[0]).all()


def test_flights_of_a_file_are_those_of_its_aircraft(tmp_path):
    path = tmp_path / "tracks.ast"
    path.write_bytes(TRACK + changed(later(TRACK, 9, 2.0), 33, "F00007") + later(TRACK, 9, 5.0))
    flights = read_tracks(path)
    assert {*flights} == {"f00003", "f00007"}
    one = flights["f00003"]
    assert one.time.tolist() == [86399.5, DAY + 5.0]
    assert one.ground_speed == pytest.approx([math.hypot(75.25, 70.0)] * 2)
    assert one.course == pytest.approx([math.atan2(-75.25, 70.0)] * 2)
    assert "no date" in one.remarks[0]
    path.write_bytes(REPORT)
    (report,) = read_tracks(path).values()
    assert report.name == "SIM0003"
    assert report.vertical_rate == pytest.approx([-625 * FOOT / 60])
    assert report.pressure_altitude == pytest.approx([3525 * FOOT])
    path.write_bytes(PLOT)
    with pytest.raises(
        ScenarioError, match=re.escape("tracks.ast: has no blocks of the categories that are read here")
    ):
        read_tracks(path)


def test_letters_of_six_bits_are_a_text():
    assert letters_of("SIM0003") == 0x4C9370C30CE0
    assert identification(0x4C9370C30CE0) == "SIM0003"
    assert identification(0) == ""


# ---- what leaves ---------------------------------------------------------------------------------------------------
def test_plots_leave_as_the_octets_that_were_worked_out():
    columns = {"range": np.array([10.5 * NM]), "azimuth": np.array([math.pi / 2]), "level": np.array([3525 * FOOT])}
    stamps = np.array([10 * DAY + 36000.25])
    made = target_reports(1, stamps, np.array([3]), columns, sent=stamps, cooperative=True, numbered=True)
    assert made.octets.tobytes() == changed(PLOT, 15, "0204")
    assert made.stamps.tolist() == stamps.tolist()


def test_a_turn_leaves_as_the_octets_that_were_worked_out():
    made = north_markers(2, np.array([4.0]), 4.0, (math.pi / 4, -math.pi / 2, 310.0))
    assert made.octets.tobytes() == MARKER


def test_reports_leave_as_the_octets_that_were_worked_out():
    columns = {
        "latitude": math.pi / 4, "longitude": -math.pi / 2, "level": 3525 * FOOT, "vertical_rate": -625 * FOOT / 60,
        "ground_speed": 640 * NM / 2**14, "course": -math.pi / 2, "position_category": 10.0, "velocity_category": 3.0,
    }  # fmt: skip
    columns = {name: np.array([value]) for name, value in columns.items()}
    made = position_reports(3, np.array([36000.25]), np.array([3]), columns, numbered=True)
    assert made.octets.tobytes() == REPORT


def test_a_time_that_rounds_to_midnight_is_that_of_the_next_day():
    assert time_of_day(np.array([DAY - 0.003, DAY - 0.005, 3 * DAY, DAY + 1.004])).tolist() == [
        0.0, DAY - 1 / 128, 0.0, 1.0 + 1 / 128,
    ]  # fmt: skip


def test_no_two_draws_share_an_address_or_a_code():
    draws = np.arange(0o7000 - 0o1001)
    assert len({*address_of(draws)}) == len({*code_of(draws)}) == len(draws)
    assert code_of(draws).max() < 0o7000 < 0o7500
