"""validate: every fault of every layer at once, each with its line."""

import io
import re

import pytest

from sim.cli.validation import faults
from sim.cli.validation.lines import line_of, lines
from sim.scenario.plugins import catalogue_with
from tests.sim.cli.faulty_files import FILES

ALL_LAYERS = """name = "mine"
speed_kt = 5
draws =

[aircraft]
model = "an26"
mass_lb = 20000
[start]
speed_mps = -3
[wind]
speed_kt = 400
[sensors]
radar = { kind = "surveillance_radar", period_s = 4 }
[trackers.a]
kind = "immm"
[trackers.b]
kind = "imm"
sensors = [
  "radra",
]
[[contrasts]]
of = "a"
against = "c"
[[checks]]
metric = "bank_deg"
max = 3
source = "a book"
[[checks]]
metric = "bank_deg"
max = 3
source = "a book"
during = "finall"
"""
TOLD = {  # line -> what is said of it
    2: r"speed_kt: no such key; .*wind\.speed_kt",
    3: "not TOML",
    7: r"mass .* must lie within 35270 and 52910 lb.* \(got mass_lb = 20000\)",
    9: r"\[start\] speed_mps: must be above 0 \(got -3\)",
    11: r"\[wind\] speed_kt: must be at most 194\.384 \(got 400\)",  # 100 m/s
    15: "no kind 'immm'; did you mean 'imm'",
    18: "no sensor 'radra'; did you mean 'radar'",
    23: "no tracker 'c'",
    32: "no phase 'finall'; did you mean 'final'",
}


def told(source):
    return faults.validate(str(source), {}, catalogue_with(())).faults


def test_faults_of_all_layers_each_with_its_line(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(ALL_LAYERS)
    said = told(file)
    assert len(said) == len(TOLD), said
    for fault, (line, words) in zip(said, TOLD.items(), strict=True):
        assert fault.startswith(f"{file}:{line}: ")
        assert re.search(words, fault), fault


@pytest.mark.parametrize("name", FILES)
def test_each_of_five_faults_is_told_with_its_line(tmp_path, name):
    """Written by hand, of each layer some; what is said was read by people before it came here."""
    content, wanted = FILES[name]
    file = tmp_path / "mine.toml"
    file.write_text(content)
    found = [fault.removeprefix(f"{file}:") for fault in told(file)]
    assert len(wanted) >= 5
    assert [fault[: len(f"{line}: {words}")] for fault, (line, words) in zip(found, wanted, strict=True)] == [
        f"{line}: {words}" for line, words in wanted
    ]


def test_values_of_the_command_line_are_told_too():
    verdict = faults.validate("an26_pattern", {"wind.speed_kt": 400, "start.height_m": -1}, catalogue_with(()))
    assert sorted(verdict.faults, reverse=True) == [
        "an26_pattern.toml: --set wind.speed_kt: must be at most 194.384 (got 400)",
        "an26_pattern.toml: --set start.height_m: must be above 0: a flight starts above the ground, and below 30 km "
        "(got -1)",
    ]


def test_a_file_that_is_good_has_no_fault_and_standard_input_is_a_file(tmp_path, monkeypatch):
    good = 'name = "mine"\n[sensors.radar]\nkind = "surveillance_radar"\nperiod_s = 4\n'
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(good.encode())))
    verdict = faults.validate("-", {}, catalogue_with(()))
    assert (verdict.name, verdict.faults) == ("mine", [])
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(good.replace("period_s", "perod_s").encode())))
    assert [fault.partition(": ")[0] for fault in told("-")] == ["stdin:4"]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "says nothing"),
        ("[wind\nspeed_kt = 5\n", r":1: not TOML"),  # of a header that is clear
        ("[wind.\nspeed = 5\n", r":1: not TOML"),  # what follows one that is not is nobody's: no more is said
        ("sensors = [\n", "not TOML"),
        ('name = "a"\nname = "a"\n', r":2: not TOML"),
    ],
)
def test_one_fault_is_one_line(tmp_path, content, said):
    (tmp_path / "a.toml").write_text(content)
    found = told(tmp_path / "a.toml")
    assert len(found) == 1, found
    assert re.search(said, found[0])


def test_lines_of_keys_however_they_are_written():
    text = (
        '# a = 1\na.b = 1\n"c d" = """\n[x]\ne = 2\n"""\n[f.g]  # [h]\nlist = [ # ]\n  "i = 1",\n]\nj = \'#"\'\n'
        "[[k]]\nl = 1\n[[k]]\nl = 2\n[k.m]\nn = 3\n[ o . p ]\n'q' = {r = 1}\n"
    )
    found = lines(text)
    assert found == {
        ("a", "b"): 2,
        ("c d",): 3,
        ("f", "g"): 7,
        ("f", "g", "list"): 8,
        ("f", "g", "j"): 11,
        ("k", 0): 12,
        ("k", 0, "l"): 13,
        ("k", 1): 14,
        ("k", 1, "l"): 15,
        ("k", 1, "m"): 16,
        ("k", 1, "m", "n"): 17,
        ("o", "p"): 18,
        ("o", "p", "q"): 19,
    }
    assert line_of("[[k]] entry 1 l: is wrong", text) == 15
    assert line_of("[o.p.q] r: is wrong", text) == 19  # of what has no line of its own, that of its table
    assert line_of("[nowhere] s: is wrong", text) is None
