"""CAT034, monoradar service messages, edition 1.29 [EUROCONTROL-SPEC-0149-2b]."""

from __future__ import annotations

from sim.interchange.asterix.categories.units import DEGREE, EXPLICIT, SOURCE, TICK, TIME
from sim.interchange.asterix.category import Category, Item
from sim.interchange.asterix.items import Compound, Field, Fixed, Repetitive, fixed

NORTH_MARKER = 1
PLACE = DEGREE * 180.0 / 2**23  # of a latitude or longitude in 24 bits
STATUS = (("com", Fixed(1)), None, None, ("psr", Fixed(1)), ("ssr", Fixed(1)))

CAT034 = Category(
    34,
    "1.29",
    (
        Item("010", SOURCE),
        Item("000", fixed(Field("message", 8))),
        Item("030", TIME),
        Item("020", fixed(Field("sector", 8, DEGREE * 360.0 / 256.0, cyclic=True))),
        Item("041", fixed(Field("period", 16, TICK))),
        Item("050", Compound((*STATUS, ("mds", Fixed(2))))),
        Item("060", Compound((*STATUS, ("mds", Fixed(1))))),
        Item("070", Repetitive(2)),
        Item("100", Fixed(8)),
        Item("110", Fixed(1)),
        Item(
            "120",
            fixed(
                Field("height", 16, 1.0, signed=True),
                Field("latitude", 24, PLACE, signed=True),
                Field("longitude", 24, PLACE, signed=True, cyclic=True),
            ),
        ),
        Item("090", Fixed(2)),
        Item("RE", EXPLICIT),
        Item("SP", EXPLICIT),
    ),
)
