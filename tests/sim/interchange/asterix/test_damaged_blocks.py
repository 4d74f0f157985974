"""Blocks with something wrong: an answer each, in one sentence, and nothing is read beyond the end."""

from __future__ import annotations

import pytest

from sim.interchange.asterix.plots import read_plots
from tests.asterix_blocks import answer, answers_of, capture, damaged

CHANGED = 200


def test_damaged_blocks_get_an_answer_each():
    answers = [one for content in damaged(CHANGED) for one in answers_of(content)]
    sentences = [one for one in answers if isinstance(one, str)]
    assert 0 < len(sentences) < len(answers)  # some are read, some are refused
    assert all(one and "\n" not in one for one in sentences)


@pytest.mark.parametrize("size", [23, 26, 30, 41, 60, 70, 90])
def test_damaged_captures_get_an_answer_each(size):
    for content in damaged(3, seed=size):
        whole = capture(content, content)
        for changed in (whole[:size], whole[:size] + b"\xff" + whole[size + 1 :], whole[: len(whole) - size % 40]):
            answer(read_plots, changed)
