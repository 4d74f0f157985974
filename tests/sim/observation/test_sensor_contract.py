"""The contract of a sensor says in a sentence what is wrong: one fault planted at a time in a sensor that has none."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from aircraft.state import AircraftState
from sim.flight.interpolation import position_at, state_at
from sim.observation.antenna import inside, sector
from sim.observation.sensor import MEMBERS, QUANTITIES, broken_promises, quantity_of
from sim.scenario import catalogue
from sim.scenario.tables import Runway

TEXT = (Path(__file__).resolve().parents[2] / "parts" / "doppler_radar.py").read_text()


def broken(tmp_path, before, after, **fields):
    """What is said of the documented sensor with one change to its text."""
    assert before in TEXT
    name = "planted_sensor"
    (tmp_path / f"{name}.py").write_text(TEXT.replace(before, after))
    spec = importlib.util.spec_from_file_location(name, tmp_path / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
        cls = module.DopplerRadar
        if isinstance(cls, type):
            catalogue.completed("sensors", cls)
        return broken_promises(cls, lambda: cls(runway=Runway(), **fields))
    finally:
        del sys.modules[name]


def test_the_sensor_as_documented_breaks_nothing(tmp_path):
    assert broken(tmp_path, "", "") == []


FAULTS = {
    "it has no 'truth'": ("def truth(", "def exact("),
    "it has no 'period'": ("    period: Annotated", "    pause: Annotated"),
    "a sensor is a class that is a frozen dataclass": ("@dataclass(frozen=True)\n", ""),
    "it cannot be made with its example or its defaults: ValueError: no": (
        "        check_ranges(self)\n",
        "        raise ValueError('no')\n",
    ),
    "channels must be a tuple of different names": ('("range", "range_rate")  #', '("range", "range")  #'),
    "antenna raises ZeroDivisionError": ("return location(", "return 1 / 0 or location("),
    "antenna must be (north, east, height)": ("return location(self.runway, self.position)", "return (0.0, 1.0)"),
    "gives_place is True, and channels have neither": ("= False, 0.0, None", "= True, 0.0, None"),
    "gives_place must be True or False": ("= False, 0.0, None", "= 'no', 0.0, None"),
    "zero_azimuth must be a number": ("= False, 0.0, None", "= False, 0.0, 'north'"),
    "clutter must be a number of at least 0": ("= False, 0.0, None", "= False, -1.0, None"),
    "recording must be None, or a sim.observation.sensor.Recording": (
        "gives_place, clutter, zero_azimuth = False, 0.0, None",
        "gives_place, clutter, zero_azimuth, recording = False, 0.0, None, 7",
    ),
    "dated gives no sensor of its kind": (
        "    def __post_init__(self)",
        "    def dated(self, utc):\n        return None\n\n    def __post_init__(self)",
    ),
    "it has clutter and no 'detection'": ("= False, 0.0, None", "= False, 1.0, None"),
    "zero_azimuth is None, and azimuth": ('("range", "range_rate")  #', '("range", "azimuth")  #'),
    "truth of one state has the shape (3,), not (2,)": ("np.stack((slant,", "np.stack((slant, slant,"),
    "truth raises TypeError": ("np.stack((slant,", "np.stack((float(slant),"),
    "outline must be a tuple": ("return ()  #", "return ((0.0, 0.0),)  #"),
    "step gives NoneType": ("return looks_until(", "looks_until("),
    "step gives a tuple for a look": ("return Look(epoch, epoch, z, np.diag(sigma**2))", "return (epoch, z)"),
    "step gives z of the shape (2,), not (2, 20)": ("Look(epoch, epoch, z,", "Look(epoch, epoch, z[:, 0],"),
    "step gives R of the shape (2,), not (2, 2)": ("np.diag(sigma**2))", "sigma**2)"),
    "step gives a look that arrives before its epoch": ("Look(epoch, epoch,", "Look(epoch, epoch - 1.0,"),
    "step measures something infinite": ("Look(epoch, epoch, z,", "Look(epoch, epoch, z * np.inf,"),
    "step gives an R that is no covariance": ("np.diag(sigma**2))", "-np.diag(sigma**2))"),
    "step gives candidates where there is no clutter": ("np.diag(sigma**2))", "np.diag(sigma**2), z[None])"),
    "step never measures range_rate": ("Look(epoch, epoch, z,", "Look(epoch, epoch, z * [[1], [np.nan]],"),
    "with 10 times the error that R states": ("np.diag(sigma**2))", "np.diag(sigma**2) / 100)"),
    "step gives looks at other times than multiples of 'period'": (
        "looks_until(state, self.period,",
        "looks_until(state, 1.1 * self.period,",
    ),
    "step measures another thing in a draw when there are more draws": (
        "* state.noise.row()",
        "* np.flip(state.noise.row(), axis=1)",
    ),
    "row k of a stream belongs to epoch k": (
        "        def look(",
        "        state.noise.row()\n\n        def look(",
    ),
}


@pytest.mark.parametrize("said", FAULTS)
def test_a_fault_is_told_in_a_sentence(said, tmp_path):
    found = broken(tmp_path, *FAULTS[said])
    assert any(said in sentence for sentence in found), found
    assert all("\n" not in sentence for sentence in found)


def test_a_sensor_that_sees_nothing_asks_for_an_example(tmp_path):
    (sentence,) = broken(tmp_path, "", "", period=90.0)
    assert sentence.startswith("step sees nothing of a final approach; say in 'example'")


@pytest.mark.parametrize("thing", [None, 3, "DopplerRadar", object, type("Empty", (), {})])
def test_what_is_no_sensor_at_all_is_told_too(thing):
    assert broken_promises(thing, lambda: thing) == ["a sensor is a class that is a frozen dataclass"]


def test_quantities_know_units_turns_and_places():
    assert [quantity_of(name).unit for name in ("dme.range", "x.azimuth", "range_rate")] == ["m", "deg", "mps"]
    assert quantity_of("x.azimuth").factor == 180 / np.pi
    assert quantity_of("load_factor_up").unit == quantity_of("never_heard_of").unit == ""
    assert {name for name, one in QUANTITIES.items() if one.wraps} >= {"azimuth", "elevation", "air_course"}
    assert not quantity_of("range_rate").place
    assert "truth" in MEMBERS


def test_angles_between_records_go_the_shorter_way_round():
    zero = AircraftState(*[0.0] * len(AircraftState._fields))
    before = zero._replace(heading=np.radians(179.0), bank=0.1, airspeed=60.0, velocity_north=60.0)
    after = before._replace(time=1.0, heading=np.radians(-179.0), bank=0.3, airspeed=70.0, north=60.0)
    middle = state_at(before, after, 0.25)
    assert np.degrees(middle.heading) == pytest.approx(179.5)
    assert (middle.bank, middle.airspeed, middle.time) == pytest.approx((0.15, 62.5, 0.25))
    assert (middle.north, middle.east, middle.height) == pytest.approx(tuple(position_at(before, after, 0.25)))


def test_a_sector_is_what_the_angles_say():
    edge = sector((100.0, -50.0, 9.0), 2.0, np.radians(70.0), 5000.0)
    random = np.random.default_rng(3)
    turn, reach = random.uniform(-np.pi, np.pi, 4000), random.uniform(0.0, 7000.0, 4000)
    within = inside(edge, 100.0 + reach * np.cos(2.0 + turn), -50.0 + reach * np.sin(2.0 + turn))
    exact = (np.abs(turn) <= np.radians(35.0)) & (reach <= 5000.0)
    assert np.mean(within != exact) < 1e-3  # the chords of the arc are 0.8 m inside it at most
    circle = sector((0.0, 0.0, 0.0), 0.0, 2 * np.pi, 1000.0)
    assert inside(circle, 999.0 * np.cos(turn), 999.0 * np.sin(turn)).all()
    assert not inside(circle, 1001.0 * np.cos(turn), 1001.0 * np.sin(turn)).any()
    assert inside((), turn, reach).all()
