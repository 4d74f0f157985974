"""What a helper process does is what the first would have done, also where the helper is lost."""

from __future__ import annotations

import os
import signal
import sys
import time

import numpy as np
import pytest

from sim.estimation.tracking_run import track
from sim.experiment import fly
from sim.flight.preparation import prepare
from sim.observation.record import observe
from sim.reporting.figures.flight import charts
from sim.reporting.page import picture
from sim.scenario.reading import read
from sim.workers.sharing import current, helper


def square(number):
    time.sleep(0.05)
    return number * number, os.getpid()


def drawn(*flown):
    return [picture(chart) for chart in charts(*flown)]


def sulk(number, home):
    """Dies at the sixth call wherever it is not at home."""
    if os.getpid() != home and number == 6:
        os.kill(os.getpid(), signal.SIGKILL)
    return square(number)


class Heavy:
    """Says how often it travels."""

    travels = 0

    def __init__(self, weight):
        self.weight = weight

    def __reduce__(self):
        Heavy.travels += 1
        return Heavy, (self.weight,)


def lift(heavy, number):
    time.sleep(0.05)
    return heavy.weight * number, os.getpid()


def refuse(number):
    if number == 7:
        raise IndexError("seven")
    return number


def has_imported(module):
    return module in sys.modules


@pytest.fixture(scope="module")
def shared():
    with helper() as sharing:
        if sharing.helper is None:
            pytest.skip("a helper process needs a second processor")
        sharing.later(os.getpid)()  # it is ready
        yield sharing


@pytest.fixture
def doomed():
    with helper() as sharing:
        if sharing.helper is None:
            pytest.skip("a helper process needs a second processor")
        sharing.later(os.getpid)()
        yield sharing


@pytest.fixture(scope="module")
def flown():
    prepared = prepare(read("route_capture_point_mass", {"until_s": 60}))
    return fly(prepared), prepared.scenario, prepared.law


@pytest.fixture(scope="module")
def expected(flown):
    return drawn(*flown)


def test_it_draws_the_same_bytes(shared, flown, expected):
    assert shared.later(drawn, *flown)() == expected


def test_what_a_lost_process_owes_is_made_here(doomed, flown, expected):
    os.kill(doomed.helper.process.pid, signal.SIGKILL)
    assert doomed.later(drawn, *flown)() == expected


def test_both_take_their_part(shared):
    found = shared.in_order(square, [(number,) for number in range(8)])
    assert [value for value, _ in found] == [number**2 for number in range(8)]
    assert len({process for _, process in found}) == 2


@pytest.mark.parametrize("weight", [3, 5])
def test_what_all_calls_have_in_common_travels_once(shared, monkeypatch, weight):
    monkeypatch.setattr(Heavy, "travels", 0)
    found = shared.in_order(lift, [(number,) for number in range(8)], (Heavy(weight),))
    assert [value for value, _ in found] == [weight * number for number in range(8)]
    assert len({process for _, process in found}) == 2
    assert Heavy.travels == 1


def test_a_process_that_is_lost_before_it_has_that_costs_no_result(doomed):
    os.kill(doomed.helper.process.pid, signal.SIGKILL)
    found = doomed.in_order(lift, [(number,) for number in range(3)], (Heavy(2),))
    assert found == [(0, os.getpid()), (2, os.getpid()), (4, os.getpid())]


def test_a_process_that_is_lost_half_way_costs_no_result(doomed):
    home = os.getpid()
    found = doomed.in_order(sulk, [(number, home) for number in range(8)])
    assert [value for value, _ in found] == [number**2 for number in range(8)]
    assert found[6][1] == home


@pytest.mark.parametrize("place", [0, 1, 6, 7])
def test_an_error_reaches_the_caller_from_either_end(shared, place):
    calls = [(number,) for number in range(10, 18)]
    calls[place] = (7,)
    with pytest.raises(IndexError, match="seven"):
        shared.in_order(refuse, calls)


def test_who_stops_does_not_wait_for_what_runs_there(doomed):
    """The process ends with the call that it is at, so it takes no other."""
    results = doomed.as_done(time.sleep, [(0.0,), (30.0,)])
    next(results)
    results.close()
    assert doomed.helper.process.wait(5.0) == -signal.SIGKILL


def test_trackers_are_the_same_bytes():
    kinds = {"plain": "kalman", "told": "linear_feedback", "limited": "saturated_control", "many": "imm"}
    tables = {name: {"kind": kind} for name, kind in kinds.items()}
    radar = {"radar": {"kind": "surveillance_radar"}}
    prepared = prepare(
        read("route_capture_point_mass", {"until_s": 60, "draws": 5, "sensors": radar, "trackers": tables})
    )
    flight = fly(prepared)
    records = observe(flight, prepared.scenario.sensors, 1, 0, 5)
    alone, theirs = track(prepared, flight, records, {})
    with helper() as sharing:
        tracks, figures = track(prepared, flight, records, {})
        assert sharing.helper is None or sharing.later(has_imported, "sim.estimation.tracking_run")()
    assert figures == theirs
    assert list(tracks) == list(alone) == list(kinds)
    for name in kinds:
        np.testing.assert_array_equal(tracks[name].track.mean, alone[name].track.mean)
        np.testing.assert_array_equal(tracks[name].track.cov, alone[name].track.cov)


def test_what_is_not_worth_a_process_is_done_here(flown, expected):
    with helper(worth_it=False) as sharing:
        assert sharing.helper is None
        assert sharing.later(drawn, *flown)() == expected
        assert [value for value, _ in sharing.in_order(square, [(2,), (3,)])] == [4, 9]


def test_work_is_shared_within_the_block_and_nowhere_else():
    before = current()
    with helper(worth_it=False) as outer:
        with helper() as inner:
            assert current() is inner is not outer
        assert current() is outer
    assert current() is before


def test_ctrl_c_is_not_the_helper_s_affair(shared):
    os.kill(shared.helper.process.pid, signal.SIGINT)
    assert shared.helper.call(abs, -3) == 3
