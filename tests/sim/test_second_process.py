"""The figures that a second process draws are those of the first, also where the second is lost."""

from __future__ import annotations

import os
import signal

import pytest

from sim.experiment import fly
from sim.preparation import prepare
from sim.reporting.report import charts
from sim.reporting.second_process import FEW, draughtsman
from sim.scenario import read


@pytest.fixture(scope="module")
def flown():
    prepared = prepare(read("route_capture_point_mass", {"until_s": 60}))
    return fly(prepared), prepared.scenario, prepared.law


@pytest.fixture(scope="module")
def expected(flown):
    return charts(*flown)


def test_a_second_process_draws_the_same_bytes(flown, expected):
    with draughtsman(FEW) as drawing:
        if drawing.pool is None:
            pytest.skip("a second process needs a second processor")
        drawing.draw(*flown)
        assert drawing.charts() == expected


def test_what_a_lost_process_owes_is_drawn_here(flown, expected):
    with draughtsman(FEW) as drawing:
        if drawing.pool is None:
            pytest.skip("a second process needs a second processor")
        worker = drawing.pool.submit(os.getpid).result()
        os.kill(worker, signal.SIGKILL)
        drawing.draw(*flown)
        assert drawing.charts() == expected


def test_few_trackers_are_not_worth_a_process(flown, expected):
    with draughtsman(FEW - 1) as drawing:
        assert drawing.pool is None
        drawing.draw(*flown)
        assert drawing.charts() == expected
