"""Python's text translated into a JSBSim system: JSBSim must give what Python gives, or the line must be refused."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import jsbsim
import numpy as np
import pytest

from sim.interchange.jsbsim_system.components import Written
from sim.interchange.jsbsim_system.terms import Refused, Terms
from sim.interchange.jsbsim_system.translation import translated
from sim.interchange.jsbsim_system.values import leaves

BODY = """<fdm_config name="still" version="2.0"><metrics/><mass_balance><emptywt unit="LBS">1</emptywt></mass_balance>
<ground_reactions/>{}<aerodynamics/></fdm_config>"""
TABLE = ((2.0, "far"), (5.0, "near"), (11.0, "here"))


class Pair(NamedTuple):
    first: float
    second: float

    @property
    def total(self):
        return self.first + self.second


@dataclass(frozen=True)
class Law:
    gain: float
    limit: float = 3.0

    def __call__(self, x):
        return limited(self.gain * x, self.limit)


def limited(value, limit):
    if value.__class__ is limit.__class__ is float:
        return limit if value > limit else -limit if value < -limit else value
    return np.minimum(np.maximum(value, np.negative(limit)), limit)


def branches(x, y):
    kind, size = "none", 0.0
    if x > 1.0:
        kind, size = "right", x
        if y < 0.0 or x > 4.0:
            size *= 2.0
    elif -1.0 <= x <= 1.0 and not y > 3.0:
        kind = "level"
    else:
        size -= y
    if kind == "right":
        return size, kind in ("right", "level")
    return -size, kind != "none"


def early(x, y):
    if x < 0.0:
        if y < 0.0:
            return -1.0
        x = y
    elif y > 2.0:
        return limited(x, 1)
    total = 0.0
    for weight, word in TABLE:
        total += weight * x if word != "near" else y
    return total + x


def tuples(x, y):
    pair = Pair(x, y)
    low, *rest = (x, y, x * y)
    for below, above in pairwise(TABLE):
        if x > below[0]:
            low = above[0]
    swapped = pair._replace(first=y)
    number = 0 if x < 0.0 else 1 if y < 0.0 else 2
    return pair.total, swapped, low, sum(rest), TABLE[number][0], [2.0 * one for one in rest][-1], tuple(rest[-2:])


def mathematics(x, y):
    length = math.hypot(x, y) + abs(x) ** 0.5
    angle = math.atan2(y, x) + math.remainder(x, math.tau) + (x - 7.0) % math.tau
    steep = math.tan(0.1 * x) + math.asin(max(-1.0, min(0.2 * y, 1.0))) + math.exp(-abs(y)) + math.log(1.0 + x * x)
    return (
        length,
        angle,
        steep,
        math.copysign(x, y),
        float(x > y) + (x or y),
        -x // 1 if not isinstance(x, float) else x,
    )


def calls(x, y):
    law = Law(0.7) if y > 0.0 else Law(1.3, limit=2.0)
    first = next((word for far, word in TABLE if x > far), "none")
    nearest = next(far for far, _ in TABLE if far > 3.0)
    return law(x), first == "near", nearest, any(x > far for far, _ in TABLE), all(far > y for far, _ in TABLE)


def in_jsbsim(function, samples, root: Path) -> np.ndarray:
    """What JSBSim's system gives for each sample (x, y)."""
    terms = Terms()
    found = leaves(translated(terms, function, terms.property("given/x"), terms.property("given/y")))
    channel = Written("test").channel("test", [(f"found/of-{n}", terms.of(one)) for n, (_, one) in enumerate(found)])
    home = root / "aircraft" / "still"
    home.mkdir(parents=True)
    system = ElementTree.Element("system", {"name": "test"})
    for name in "xy":
        ElementTree.SubElement(system, "property").text = f"given/{name}"
    system.append(channel)
    (home / "still.xml").write_text(BODY.format(ElementTree.tostring(system, encoding="unicode")))
    jsbsim.FGJSBBase().debug_lvl = 0
    executive = jsbsim.FGFDMExec(str(root))
    assert executive.load_model("still")
    executive.run_ic()
    rows = []
    for x, y in samples:
        executive["given/x"], executive["given/y"] = x, y
        executive.run()
        rows.append([executive[f"found/of-{n}"] for n in range(len(found))])
    return np.array(rows)


@pytest.mark.parametrize("function", [branches, early, tuples, mathematics, calls])
def test_jsbsim_gives_what_python_gives(function, tmp_path):
    samples = [tuple(pair) for pair in np.random.default_rng(7).uniform(-9.0, 12.0, (120, 2)).tolist()]
    expected = np.array([[float(one) for _, one in leaves(as_tuples(function(x, y)))] for x, y in samples])
    assert len(np.unique(expected, axis=0)) > 5  # it does something
    found = in_jsbsim(function, samples, tmp_path)
    assert found == pytest.approx(expected, rel=4e-15, abs=4e-15)  # a hypotenuse by its squares is one rounding off


def as_tuples(value):
    return tuple(map(as_tuples, value)) if isinstance(value, list) else value


def test_all_is_worked_out_before_anything_is_set(tmp_path):
    """Two remembered numbers change places: neither may read the other's new value."""
    terms = Terms()
    a, b = terms.property("remembered/a"), terms.property("remembered/b")
    channel = Written("test").channel("swap", [("remembered/a", b), ("remembered/b", a)])
    order = [component.get("name") for component in channel]
    assert order[-2:] == ["remembered/a", "remembered/b"]
    last = channel[-1].find("function/property")
    assert last is not None
    assert last.text != "remembered/a"


def test_every_assignment_is_a_component_with_its_name():
    terms = Terms()
    value = translated(terms, early, terms.property("given/x"), terms.property("given/y"))
    names = [one.get("name") for one in Written("law").channel("law", [("found", value)])]
    assert "law/early/total" in names
    assert names[-1] == "found"


def a_while(x, y):
    while x > y:
        x -= 1.0
    return x


def a_break(x, y):
    for far, _ in TABLE:
        if x > far:
            break
    return y


def a_try(x, y):
    try:
        return x / y
    except ZeroDivisionError:
        return 0.0


def a_list_that_grows(x, y):
    found = [x]
    found.append(y)
    return found[0]


def a_loop_of_the_flight(x, y):
    return sum(1.0 for _ in range(int(x)))


def a_variable_of_one_branch(x, y):
    if x > y:
        far = x
    return far


def an_unknown_function(x, y):
    return math.gamma(x)


def a_recursion(x, y):
    return a_recursion(x, y)


def a_lambda(x, y):
    return (lambda one: one)(x)


def a_set(x, y):
    return x in {1.0, 2.0}


def an_array(x, y):
    return np.where(x > y, x, y)


def a_raise(x, y):
    if x > y:
        raise ValueError
    return y


WRONG = (
    *(a_while, a_break, a_try, a_list_that_grows, a_loop_of_the_flight, a_variable_of_one_branch),
    *(an_unknown_function, a_recursion, a_lambda, a_set, an_array, a_raise),
)


@pytest.mark.parametrize("function", WRONG)
def test_what_is_not_known_is_refused_with_its_line(function):
    terms = Terms()
    with pytest.raises(Refused) as refused:
        translated(terms, function, terms.property("given/x"), terms.property("given/y"))
    first = function.__code__.co_firstlineno
    told = str(refused.value)
    assert told.startswith(f"{Path(__file__).name}, line "), told
    assert first < int(told.split("line ")[1].split(",")[0]) <= first + 6
    assert f"in {function.__name__}: " in told


def test_source_that_cannot_be_read_is_refused():
    made: dict[str, object] = {}
    exec("def hidden(x): return x + 1", made)
    with pytest.raises(Refused, match="source of 'hidden'"):
        translated(terms := Terms(), made["hidden"], terms.property("given/x"))


def test_a_term_never_decides_in_python():
    with pytest.raises(Refused, match="known in flight only"):
        bool(Terms().property("given/x"))
