"""``shortfinal contract`` says what a kind breaks of the contract of its family, in sentences."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from sim.cli.commands import main

FILE = Path(__file__).parent.parent / "scenario" / "foreign_parts.py"


@pytest.fixture
def tried(capsys, monkeypatch):
    """What the command says of a kind: exit code, standard output, standard error."""

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["shortfinal", "contract", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        return ended.value.code, *capsys.readouterr()

    return call


@pytest.mark.parametrize(
    "kind", ["sensors.beacon", "trackers.calm", "modes.track_hold", "wind_events.thermal", "wind_events.gust"]
)
def test_a_kind_that_keeps_its_contract(tried, kind):
    told = tried(kind, "--plugin", FILE)
    assert told == (0, f"{kind} keeps its contract\n", "")
    assert tried(kind.partition(".")[2], "--plugin", FILE) == told


@pytest.mark.parametrize(
    ("kind", "old", "new", "said"),
    [
        ("wind_events.thermal", "def velocity", "def blow", "has no 'velocity'"),
        ("wind_events.thermal", "return 0.0, 0.0, self.up", "return 0.0, self.up", "velocity gives"),
        ("trackers.calm", "return self.inner.begin(prior)", "return 1 / 0", "begin raises ZeroDivisionError"),
        ("modes.track_hold", "return np.clip(", "return 9.0 * np.clip(", "bank_limit is"),
        ("sensors.beacon", "def step(self, ping", "def stop(self, ping", "'step'"),
        (
            "sensors.beacon",
            'period: Annotated[float, "s"]',
            'period: Annotated[float, "parsec"]',
            "has parameters that cannot be read: the unit 'parsec' of 'period' is not one of m, s, Hz",
        ),
        ("sensors.beacon", "@dataclass(frozen=True)\nclass Beacon", "@dataclass\nclass Beacon", "no frozen dataclass"),
    ],
)
def test_a_kind_that_breaks_its_contract_is_told_what(tried, tmp_path, kind, old, new, said):
    file = tmp_path / "mine.py"
    assert FILE.read_text().count(old) == 1
    file.write_text(FILE.read_text().replace(old, new))
    code, out, err = tried(kind, "--plugin", file)
    assert (code, err) == (1, "")
    assert all(line.startswith(f"{kind}: ") for line in out.splitlines())
    assert said in out


def test_a_kind_that_nobody_has_is_bad_input(tried):
    assert tried("gusty") == (2, "", "shortfinal: contract: no kind 'gusty'; did you mean 'gust'?\n")
    assert tried("wind_event.gust")[2] == "shortfinal: contract: no family 'wind_event'; did you mean 'wind_events'?\n"
    code, _, said = tried("sensors.gust")
    assert code == 2
    assert "contract: no kind 'gust'; allowed: adsb, dme, downlink" in said
    assert tried("gust", "--plugin", "none.py")[0::2] == (2, "shortfinal: none.py: no such file\n")


def test_a_kind_of_two_families_needs_its_family(tried, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(FILE.read_text() + 'SHORTFINAL["sensors"]["thermal"] = Beacon\n')
    assert tried("thermal", "--plugin", file) == (
        2,
        "",
        "shortfinal: contract: say sensors.thermal or wind_events.thermal\n",
    )
