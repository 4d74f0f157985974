"""CAT021, reports of ADS-B, edition 2.6 [EUROCONTROL-SPEC-0149-12]."""

from __future__ import annotations

from sim.interchange.asterix.categories.units import (
    ADDRESS,
    DEGREE,
    EXPLICIT,
    FEET_PER_MINUTE,
    FLIGHT_LEVEL,
    FOOT,
    IDENTIFICATION,
    SOURCE,
    SPEED,
    TIME,
    TURN,
)
from sim.interchange.asterix.category import Category, Item
from sim.interchange.asterix.items import Compound, Extended, Field, Fixed, Repetitive, fixed, spare

COARSE, FINE = DEGREE * 180.0 / 2**23, DEGREE * 180.0 / 2**30  # of a latitude or longitude
RATE = 6.25 * FEET_PER_MINUTE

DESCRIPTOR = (
    (Field("atp", 3), Field("arc", 2), Field("rc", 1), Field("rab", 1)),
    (Field("dcr", 1), Field("gbs", 1), Field("sim", 1), Field("tst", 1), spare(3)),
)
QUALITY = (
    (Field("velocity", 3), Field("integrity", 4)),  # NACv, NIC
    (Field("nic_baro", 1), Field("sil", 2), Field("position", 4)),  # NACp
)
RATE_OF_CLIMB = fixed(Field("re", 1), Field("rate", 15, RATE, signed=True))
INTENT = Compound((("tis", Extended()), ("tid", Repetitive(15))))
WEATHER = Compound((("ws", Fixed(2)), ("wd", Fixed(2)), ("tmp", Fixed(2)), ("trb", Fixed(1))))
DATA_AGES = 23

CAT021 = Category(
    21,
    "2.6",
    (
        Item("010", SOURCE),
        Item("040", Extended(DESCRIPTOR)),
        Item("161", fixed(spare(4), Field("number", 12))),
        Item("015", Fixed(1)),
        Item("071", TIME),
        Item("130", fixed(Field("latitude", 24, COARSE, True), Field("longitude", 24, COARSE, True, cyclic=True))),
        Item("131", fixed(Field("latitude", 32, FINE, True), Field("longitude", 32, FINE, True))),
        Item("072", TIME),
        Item("150", Fixed(2)),
        Item("151", Fixed(2)),
        Item("080", ADDRESS),
        Item("073", TIME),
        Item("074", Fixed(4)),
        Item("075", TIME),
        Item("076", Fixed(4)),
        Item("140", fixed(Field("height", 16, 6.25 * FOOT, signed=True))),
        Item("090", Extended(QUALITY)),
        Item("210", fixed(spare(1), Field("vns", 1), Field("vn", 3), Field("ltt", 3))),
        Item("070", fixed(spare(4), Field("code", 12))),
        Item("230", Fixed(2)),
        Item("145", fixed(Field("level", 16, FLIGHT_LEVEL, signed=True))),
        Item("152", Fixed(2)),
        Item("200", Fixed(1)),
        Item("155", RATE_OF_CLIMB),
        Item("157", RATE_OF_CLIMB),
        Item("160", fixed(Field("re", 1), Field("speed", 15, SPEED), Field("course", 16, TURN, cyclic=True))),
        Item("165", Fixed(2)),
        Item("077", TIME),
        Item("170", IDENTIFICATION),
        Item("020", Fixed(1)),
        Item("220", WEATHER),
        Item("146", Fixed(2)),
        Item("148", Fixed(2)),
        Item("110", INTENT),
        Item("016", Fixed(1)),
        Item("008", Fixed(1)),
        Item("271", Extended()),
        Item("132", Fixed(1)),
        Item("250", Repetitive(8)),
        Item("260", Fixed(7)),
        Item("400", Fixed(1)),
        Item("295", Compound(tuple((f"age{number}", Fixed(1)) for number in range(DATA_AGES)))),
        *(None,) * 5,
        Item("RE", EXPLICIT),
        Item("SP", EXPLICIT),
    ),
)
