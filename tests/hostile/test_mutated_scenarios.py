"""Judge: chance. A scenario bent at random is flown or answered in sentences, and reaches nothing."""

from __future__ import annotations

from tests.hostile.watched import Sandbox

EXAMPLES = 20  # the acceptance has two thousand


def test_every_bent_scenario_is_answered_and_reaches_nothing(tmp_path):
    sandbox = Sandbox(tmp_path)
    before = sandbox.files()
    answered = sandbox.mutations(EXAMPLES, every=30, time_limit=300.0)
    assert len(answered) == EXAMPLES
    for text, answer in answered:
        assert not answer.trace, f"{answer.trace[-1500:]}\n{text}"
        assert answer.code in (0, 1, 2), text
        assert answer.code != 2 or all(line.startswith("shortfinal: ") for line in answer.err.splitlines()), answer.err
        assert answer.err.replace("\n", "").isprintable(), answer.err
        assert bool(answer.err) == (answer.code == 2), answer.err
    codes = [answer.code for _, answer in answered]
    assert codes.count(0) > EXAMPLES // 20, "nearly nothing flies: the changes are too coarse to find anything"
    assert codes.count(2) > EXAMPLES // 5
    (sandbox.place("cwd") / "bent.toml").unlink()
    assert sandbox.files() == before
    assert sandbox.offences(["bent.toml"]) == []
