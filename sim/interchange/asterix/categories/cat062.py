"""CAT062, system tracks, edition 1.20 [EUROCONTROL-SPEC-0149-9]."""

from __future__ import annotations

from sim.interchange.asterix.categories.units import (
    ADDRESS,
    DEGREE,
    EXPLICIT,
    FEET_PER_MINUTE,
    FLIGHT_LEVEL,
    FOOT,
    SOURCE,
    TIME,
)
from sim.interchange.asterix.category import Category, Item
from sim.interchange.asterix.items import Chained, Compound, Extended, Field, Fixed, Form, Repetitive, fixed, spare

PLACE = DEGREE * 180.0 / 2**25  # of a latitude or longitude
RATE = 6.25 * FEET_PER_MINUTE
HEIGHT = 6.25 * FOOT

STATUS = (
    (Field("mon", 1), Field("spi", 1), Field("mrh", 1), Field("src", 3), Field("cnf", 1)),
    (Field("sim", 1), Field("tse", 1), Field("tsb", 1), spare(4)),
)
DERIVED: tuple[tuple[str, Form] | None, ...] = (
    ("adr", ADDRESS),
    ("id", Fixed(6)),
    *((name, Fixed(2)) for name in ("mhg", "ias", "tas", "sal", "fss")),
    ("tis", Extended()),
    ("tid", Repetitive(15)),
    ("com", Fixed(2)),
    ("sab", Fixed(2)),
    ("acs", Fixed(7)),
    *((name, Fixed(2)) for name in ("bvr", "gvr", "ran", "tar", "tan", "gs")),
    ("vun", Fixed(1)),
    ("met", Fixed(8)),
    ("emc", Fixed(1)),
    ("pos", Fixed(6)),
    ("gal", Fixed(2)),
    ("pun", Fixed(1)),
    ("mb", Repetitive(8)),
    *((name, Fixed(2)) for name in ("iar", "mac", "bps")),
)
PLAN: tuple[tuple[str, Form] | None, ...] = (
    ("tag", Fixed(2)),
    ("cs", Fixed(7)),
    ("ifi", Fixed(4)),
    ("fct", Fixed(1)),
    ("tac", Fixed(4)),
    ("wtc", Fixed(1)),
    ("dep", Fixed(4)),
    ("dst", Fixed(4)),
    ("rds", Fixed(3)),
    ("cfl", Fixed(2)),
    ("ctl", Fixed(2)),
    ("tod", Repetitive(4)),
    ("ast", Fixed(6)),
    ("sts", Fixed(1)),
    ("std", Fixed(7)),
    ("sta", Fixed(7)),
    ("pem", Fixed(2)),
    ("pec", Fixed(7)),
)
ACCURACY = (  # standard deviations
    ("apc", fixed(Field("x", 16, 0.5), Field("y", 16, 0.5))),
    ("cov", fixed(Field("xy", 16, 0.5, signed=True))),  # sign and root of the covariance of x and y
    ("apw", fixed(Field("latitude", 16, PLACE), Field("longitude", 16, PLACE))),
    ("aga", Fixed(1)),
    ("aba", Fixed(1)),
    ("atv", fixed(Field("x", 8, 0.25), Field("y", 8, 0.25))),
    ("aa", Fixed(2)),
    ("arc", Fixed(1)),
)
MODE_5 = (("sum", 1), ("pmn", 4), ("pos", 6), ("ga", 2), ("em1", 2), ("tos", 1), ("xp", 1))
MEASURED = (("sid", 2), ("pos", 4), ("height", 2), ("mdc", 2), ("mda", 2), ("typ", 1))
TRACK_AGES = (1, 1, 1, 1, 2, 1, 1, 1, 1, 1)  # octets
DATA_AGES = 31

CAT062 = Category(
    62,
    "1.20",
    (
        Item("010", SOURCE),
        None,
        Item("015", Fixed(1)),
        Item("070", TIME),
        Item("105", fixed(Field("latitude", 32, PLACE, signed=True), Field("longitude", 32, PLACE, signed=True))),
        Item("100", fixed(Field("x", 24, 0.5, signed=True), Field("y", 24, 0.5, signed=True))),
        Item("185", fixed(Field("x", 16, 0.25, signed=True), Field("y", 16, 0.25, signed=True))),
        Item("210", Fixed(2)),
        Item("060", fixed(Field("v", 1), Field("g", 1), Field("ch", 1), spare(1), Field("code", 12))),
        Item("245", fixed(Field("sti", 2), spare(6), Field("letters", 48))),
        Item("380", Compound(DERIVED)),
        Item("040", fixed(Field("number", 16))),
        Item("080", Extended(STATUS)),
        Item("290", Compound(tuple((f"age{number}", Fixed(octets)) for number, octets in enumerate(TRACK_AGES)))),
        Item("200", Fixed(1)),
        Item("295", Compound(tuple((f"age{number}", Fixed(1)) for number in range(DATA_AGES)))),
        Item("136", fixed(Field("level", 16, FLIGHT_LEVEL, signed=True))),
        Item("130", fixed(Field("height", 16, HEIGHT, signed=True))),
        Item("135", fixed(Field("qnh", 1), Field("level", 15, FLIGHT_LEVEL, signed=True))),
        Item("220", fixed(Field("rate", 16, RATE, signed=True))),
        Item("390", Compound(PLAN)),
        Item("270", Extended()),
        Item("300", Fixed(1)),
        Item("110", Compound(tuple((name, Fixed(octets)) for name, octets in MODE_5))),
        Item("120", Fixed(2)),
        Item("510", Chained(3)),
        Item("500", Compound(ACCURACY)),
        Item("340", Compound(tuple((name, Fixed(octets)) for name, octets in MEASURED))),
        *(None,) * 5,
        Item("RE", EXPLICIT),
        Item("SP", EXPLICIT),
    ),
)
