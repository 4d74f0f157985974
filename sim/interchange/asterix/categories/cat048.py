"""CAT048, monoradar target reports, edition 1.32 [EUROCONTROL-SPEC-0149-4]."""

from __future__ import annotations

from sim.interchange.asterix.categories.units import (
    ADDRESS,
    EXPLICIT,
    FLIGHT_LEVEL,
    FOOT,
    IDENTIFICATION,
    NAUTICAL_MILE,
    SOURCE,
    TIME,
    TURN,
)
from sim.interchange.asterix.category import Category, Item
from sim.interchange.asterix.items import Chained, Compound, Extended, Field, Fixed, Repetitive, fixed, spare

REPORT = (Field("typ", 3), Field("sim", 1), Field("rdp", 1), Field("spi", 1), Field("rab", 1))
REPORT_EXTENSION = (Field("tst", 1), spare(6))
CODE = (Field("v", 1), Field("g", 1), Field("l", 1), spare(1))

CAT048 = Category(
    48,
    "1.32",
    (
        Item("010", SOURCE),
        Item("140", TIME),
        Item("020", Extended((REPORT, REPORT_EXTENSION))),
        Item("040", fixed(Field("rho", 16, NAUTICAL_MILE / 256.0), Field("theta", 16, TURN, cyclic=True))),
        Item("070", fixed(*CODE, Field("code", 12))),
        Item("090", fixed(Field("v", 1), Field("g", 1), Field("level", 14, FLIGHT_LEVEL, signed=True))),
        Item("130", Compound(tuple((name, Fixed(1)) for name in ("srl", "srr", "sam", "prl", "pam", "rpd", "apd")))),
        Item("220", ADDRESS),
        Item("240", IDENTIFICATION),
        Item("250", Repetitive(8)),
        Item("161", fixed(spare(4), Field("number", 12))),
        Item("042", Fixed(4)),
        Item("200", Fixed(4)),
        Item("170", Extended()),
        Item("210", Fixed(4)),
        Item("030", Chained(1)),
        Item("080", Fixed(2)),
        Item("100", Fixed(4)),
        Item("110", fixed(spare(2), Field("height", 14, 25.0 * FOOT, signed=True))),
        Item("120", Compound((("cal", Fixed(2)), ("rds", Repetitive(6))))),
        Item("230", Fixed(2)),
        Item("260", Fixed(7)),
        Item("055", Fixed(1)),
        Item("050", Fixed(2)),
        Item("065", Fixed(1)),
        Item("060", Fixed(2)),
        Item("SP", EXPLICIT),
        Item("RE", EXPLICIT),
    ),
)
