"""Records against octets that were worked out by hand, both ways; what is skipped, what is refused."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from sim.interchange.asterix.blocks import AsterixError, blocks_of
from sim.interchange.asterix.categories.cat021 import CAT021
from sim.interchange.asterix.categories.cat034 import CAT034
from sim.interchange.asterix.categories.cat048 import CAT048
from sim.interchange.asterix.categories.cat062 import CAT062
from sim.interchange.asterix.decoding import decode
from sim.interchange.asterix.encoding import encode
from tests.asterix_blocks import FORMS, MARKER, PLOT, REPORT, TRACK

NM, FOOT = 1852.0, 0.3048
KNOWN = {  # category -> a block of it, and what its fields are
    CAT048: (PLOT, {
        "010.sac": 0, "010.sic": 1, "140.time": 36000.25, "020.typ": 5, "020.sim": 1, "040.rho": 10.5 * NM,
        "040.theta": math.pi / 2, "070.code": 0o1001, "090.level": 3525 * FOOT, "220.address": 0xF00003,
        "161.number": 3,
    }),
    CAT034: (MARKER, {
        "010.sac": 0, "010.sic": 2, "000.message": 1, "030.time": 4, "041.period": 4, "120.height": 310,
        "120.latitude": math.pi / 4, "120.longitude": -math.pi / 2,
    }),
    CAT062: (TRACK, {
        "010.sac": 0, "010.sic": 5, "070.time": 86399.5, "105.latitude": math.pi / 4, "105.longitude": -math.pi / 2,
        "100.x": -1000, "100.y": 250.5, "185.x": -75.25, "185.y": 70, "060.code": 0o1001,
        "380.adr.address": 0xF00003, "040.number": 3, "080.mon": 1, "080.sim": 1, "080.tsb": 1,
        "500.apc.x": 30, "500.apc.y": 49.5, "500.cov.xy": -20, "500.atv.x": 5, "500.atv.y": 3.25,
    }),
    CAT021: (REPORT, {
        "010.sac": 0, "010.sic": 3, "040.arc": 2, "040.sim": 1, "161.number": 3, "131.latitude": math.pi / 4,
        "131.longitude": -math.pi / 2, "080.address": 0xF00003, "073.time": 36000.25, "090.velocity": 3,
        "090.position": 10, "210.vn": 2, "210.ltt": 2, "145.level": 3525 * FOOT, "155.rate": -625 * FOOT / 60,
        "160.speed": 640 * NM / 2**14, "160.course": 1.5 * math.pi, "170.letters": 0x4C9370C30CE0,
    }),
}  # fmt: skip
CASES = [pytest.param(category, *known, id=f"{category.number:03d}") for category, known in KNOWN.items()]


def read(category, content):
    return decode(category, content, blocks_of(content))


def columns(values):
    return {name: np.array([float(value)]) for name, value in values.items()}


@pytest.mark.parametrize(("category", "block", "values"), CASES)
def test_octets_are_what_was_worked_out(category, block, values):
    assert encode(category, columns(values)).octets.tobytes() == block[3:]


@pytest.mark.parametrize(("category", "block", "values"), CASES)
def test_values_are_what_was_worked_out(category, block, values):
    found = read(category, block).columns
    for name, value in values.items():
        assert found[name] == pytest.approx([value], rel=1e-14), name
    others = {name: column for name, column in found.items() if name not in values}
    assert all(column.tolist() == [0.0] for column in others.values()), others


def test_items_of_every_form_are_skipped_by_their_lengths():
    found = read(CAT048, FORMS + PLOT)
    assert found.total == 2
    assert found.columns["140.time"].tolist() == [1.0, 36000.25]
    assert found.columns["161.number"].tolist() == [7.0, 3.0]
    assert found.columns["110.height"] == pytest.approx([2500 * FOOT, math.nan], nan_ok=True)
    assert found.columns["020.tst"] == pytest.approx([0.0, math.nan], nan_ok=True)  # only the first is extended


def test_rounding_is_to_the_nearest_and_an_angle_of_nearly_a_turn_is_none():
    step = 2.0 * math.pi / 65536.0
    theta = np.array((0.4 * step, 0.6 * step, 2.0 * math.pi - 0.4 * step, -0.6 * step, 7.0 * math.pi))
    made = encode(CAT048, {"040.rho": np.full(5, 0.6 * NM / 256), "040.theta": theta})
    words = made.octets.reshape(5, -1)[:, 1:].tobytes()  # one octet of the field specification
    assert words.hex(" ", 4) == "00010000 00010001 00010000 0001ffff 00018000"


def test_heights_below_the_sea_are_two_s_complements():
    made = encode(CAT048, {"090.level": np.array((-100.0, -25.0)) * FOOT})
    # -4 and -1 in 14 bits under V and G, which are 0; the field specification is 0000010 0
    assert made.octets.tobytes().hex(" ", 3) == "043ffc 043fff"


def test_records_may_differ_in_their_items_and_keep_their_order():
    level = np.array((np.nan, 100.0, np.nan, -50.0)) * 25 * FOOT
    number = np.array((1.0, 2.0, 3.0, 4.0))
    made = encode(CAT048, {"161.number": number, "090.level": level})
    assert made.lengths.tolist() == [4, 6, 4, 6]
    block = bytes((48, 0, 3 + len(made.octets))) + made.octets.tobytes()
    found = read(CAT048, block).columns
    assert found["161.number"].tolist() == number.tolist()
    np.testing.assert_allclose(found["090.level"], level, rtol=1e-14)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"040.rho": [256.0 * NM], "040.theta": [0.0]}, "I048/040 rho holds 0 to 474105, and 474112 is beyond"),
        ({"090.level": [63000.0]}, "I048/090 level holds -62423 to 62415.4, and 63000 is beyond"),
        ({"040.rho": [1.0, np.nan], "040.theta": [0.0, 0.0]}, "I048/040 is there without some of its fields"),
        ({"042.x": [0.0]}, "I048/042.x is no field that is written"),
    ],
)
def test_what_no_item_holds_is_refused_before_anything_is_made(given, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        encode(CAT048, {name: np.array(values) for name, values in given.items()})


@pytest.mark.parametrize(
    ("category", "content", "said"),
    [
        # 13 octets of items after the specification, of which the block ends after 12
        (CAT048, "30 0011 F0 0001 000080 00 0100", "at octet 3: a record of category 048 goes on beyond the end"),
        (CAT048, "30 0004 01", "at octet 3: a record of category 048 goes on beyond the end of its block"),
        (CAT048, "30 0008 01010101 80", "has the field 29, which edition 1.32 leaves open"),
        (CAT062, "3E 0006 40 0000", "has the field 2, which edition 1.20 leaves open"),
        (CAT034, "22 0006 04 20 00", "has subfield 3, which its specification leaves open: I034/050"),
        (CAT048, "30 0009 01010102 00 00", "says that it is 0 octets long, and its length is one: I048/RE"),
        (CAT048, "30 000A 0120 FF 00000000", "at octet 3: a record of category 048 goes on beyond the end"),
    ],
)
def test_what_cannot_be_a_record_is_one_sentence_that_says_where(category, content, said):
    content = bytes.fromhex(content)
    content = content[:1] + len(content).to_bytes(2, "big") + content[3:]
    with pytest.raises(AsterixError, match=re.escape(said)) as caught:
        read(category, content + PLOT)  # what follows the block must not be taken for a part of it
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("30 0018 FD", "at octet 0: a block of 24 octets is cut off after 4"),
        ("30 0002", "at octet 0: a block says that it is 2 octets long, and its head is 3"),
        ("30 0003 30", "at octet 3: 1 octets are left, and a block begins with 3"),
    ],
)
def test_what_cannot_be_a_block_is_one_sentence(content, said):
    with pytest.raises(AsterixError, match=re.escape(said)):
        blocks_of(bytes.fromhex(content))
