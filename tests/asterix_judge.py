"""Run by an interpreter that has libasterix, which decodes, encodes and walks over records for the acceptance tests.

``decode CATEGORY FILE FIELD...`` prints each field of all records, ``040/RHO:NM``, raw without a unit; ``encode``
makes blocks of CAT062 of values on standard input; ``count CATEGORY`` says of blocks there how many records each has,
or why none.
"""

from __future__ import annotations

import json
import sys

import asterix.generated as specifications
from asterix.base import Bits, RawDatablock

EDITIONS = {
    "21": specifications.Cat_021_2_6, "34": specifications.Cat_034_1_29, "48": specifications.Cat_048_1_32,
    "62": specifications.Cat_062_1_20,
}  # fmt: skip


def records(category, content):
    """All records of a category in a file."""
    found = []
    for block in RawDatablock.parse(Bits.from_bytes(content)):
        if block.get_category() == int(category):
            parsed = EDITIONS[category].cv_uap.parse(block.get_raw_records())
            if isinstance(parsed, ValueError):
                raise parsed
            found += parsed
    return found


def value(record, field):
    path, _, unit = field.partition(":")
    names = path.split("/")
    one = record.get_item(names[0])
    for name in names[1:]:
        one = None if one is None else one.variation.get_item(name)
    if one is None:
        return None
    return one.variation.content.as_quantity(unit) if unit else one.as_uint()


def encoded(one):
    """A block of CAT062; the values are those of `sim.interchange.asterix.writing.system_tracks`, in degrees."""
    octets = EDITIONS["62"]
    record = octets.cv_record.create({
        "010": (("SAC", 0), ("SIC", one["sic"])),
        "070": (one["time"], "s"),
        "105": (("LAT", (one["latitude"], "°")), ("LON", (one["longitude"], "°"))),
        "100": (("X", (one["x"], "m")), ("Y", (one["y"], "m"))),
        "185": (("VX", (one["vx"], "m/s")), ("VY", (one["vy"], "m/s"))),
        "060": (0, 0, 0, 0, ("MODE3A", one["code"])),
        "380": {"ADR": one["address"]},
        "040": one["number"],
        "080": ((1, 0, 0, 0, 0, None), (1, one["last"], one["first"], 0, 0, 0, 0, None)),
        "500": {
            "APC": (("X", (one["sx"], "m")), ("Y", (one["sy"], "m"))),
            "COV": (one["root"], "m"),
            "ATV": (("X", (one["svx"], "m/s")), ("Y", (one["svy"], "m/s"))),
        },
    })  # fmt: skip
    return octets.create([record]).unparse().to_bytes().hex()


def count(category, block):
    """How many records the octets after the head of a block are, or why they are none."""
    found = EDITIONS[category].cv_uap.parse(Bits.from_bytes(block[3:]))
    return str(found) if isinstance(found, ValueError) else len(found)


command, *arguments = sys.argv[1:]
if command == "decode":
    category, path, *fields = arguments
    with open(path, "rb") as file:
        read = records(category, file.read())
    print(json.dumps({field: [value(one, field) for one in read] for field in fields}))
elif command == "encode":
    print(json.dumps([encoded(one) for one in json.load(sys.stdin)]))
elif command == "count":
    print(json.dumps([count(arguments[0], bytes.fromhex(line)) for line in json.load(sys.stdin)]))
