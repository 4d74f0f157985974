"""Streams: addressed, independent of order, block size and company."""

from __future__ import annotations

import zlib

import numpy as np

from sim import randomness
from sim.randomness import Streams, stream


def test_row_by_row_equals_one_block(monkeypatch):
    rows = Streams(7, 0, 3, "radar").normal("noise", 2)
    taken = np.stack([rows.row() for _ in range(600)])
    whole = np.stack([stream(7, 0, draw, "radar.noise").standard_normal((600, 2)) for draw in range(3)], axis=-1)
    np.testing.assert_array_equal(taken, whole)
    monkeypatch.setattr(randomness, "BLOCK", 7)
    rows = Streams(7, 0, 3, "radar").normal("noise", 2)
    np.testing.assert_array_equal(np.stack([rows.row() for _ in range(600)]), whole)


def test_more_draws_leave_the_first_ones_as_they_are():
    few, many = (Streams(7, 0, draws, "radar").normal("noise", 2).row() for draws in (2, 5))
    np.testing.assert_array_equal(few, many[:, :2])


def test_seed_flight_draw_and_name_each_change_the_numbers():
    addresses = [(1, 0, 0, "a"), (2, 0, 0, "a"), (1, 1, 0, "a"), (1, 0, 1, "a"), (1, 0, 0, "b")]
    first = {address: stream(*address).standard_normal() for address in addresses}
    assert len(set(first.values())) == len(addresses)


def test_two_names_with_one_checksum_of_32_bits_have_noise_of_their_own():
    names = "spare_main_array_12.noise", "river_upper_beacon_29.noise"
    assert len({zlib.crc32(name.encode()) for name in names}) == 1  # by search
    a, b = (stream(1, 0, 0, name).standard_normal(1000) for name in names)
    assert not np.isin(a, b).any()


def test_independent_streams_do_not_correlate():
    a, b = (stream(1, 0, 0, name).standard_normal(100_000) for name in ("radar.noise", "mls.noise"))
    assert abs(np.mean(a * b)) < 5 / np.sqrt(100_000)  # five standard deviations of the mean of a product
