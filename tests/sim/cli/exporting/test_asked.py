"""One format a command, and each option with the formats that take it."""

from __future__ import annotations

from pathlib import Path

import pytest

from sim.cli.exporting.asked import KINDS, Asked, export
from sim.errors import OutputError

NOWHERE = Path("nowhere")


def told(*kinds, **given):
    with pytest.raises(OutputError) as caught:
        export({kind: kind in kinds for kind in KINDS}, Asked(NOWHERE, given, (), None))
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_no_format_and_two_are_refused():
    assert told() == "say what: --csv, --parquet, --tracks, --asterix, --kmz or --jsbsim"
    assert told("kmz", "asterix") == "say --asterix or --kmz, not both: one format a command"


@pytest.mark.parametrize(
    ("kind", "option", "goes_with"),
    [
        ("csv", "--pcap", "--asterix"),
        ("parquet", "--draw", "--csv and --asterix and --kmz"),
        ("kmz", "--tables", "--csv"),
        ("asterix", "-o", "--csv and --tracks and --kmz"),
        ("csv", "--date", "--tracks and --asterix and --kmz"),
        ("csv", "--set", "--jsbsim"),
        ("kmz", "-j", "--tracks"),
    ],
)
def test_an_option_of_another_format_is_refused_with_those_that_it_goes_with(kind, option, goes_with):
    assert told(kind, **{option: "x"}) == f"{option} goes with {goes_with}, not with --{kind}"


def test_draws_are_one_or_all():
    assert told("csv", **{"--draw": 1, "--draws": "all"}) == "say --draw K or --draws all, not both"
    assert told("csv", **{"--draws": "7"}) == "--draws 7: say --draws all, or --draw K for one of them"
