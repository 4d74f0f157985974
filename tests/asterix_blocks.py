"""Data blocks of ASTERIX written out by hand, octet by octet, from the layouts of the specification; and damaged
ones with what the readers answer to them.

The field specification of a record has a bit for each item of the category in the order of its profile, seven to an
octet, whose last bit says that another octet follows.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from sim.interchange.asterix.blocks import AsterixError, Block
from sim.interchange.asterix.decoding import decode
from sim.interchange.asterix.plots import read_plots
from sim.interchange.asterix.reading import READ
from sim.interchange.asterix.tracks import read_estimates, read_flights

# CAT048: items 010 140 020 040 070 090 are the first six bits and 220 161 the bits 8 and 11: 1111110 1, 1001000 0
PLOT = bytes.fromhex(
    "30 0018"  # category 48, 24 octets
    "FD90"
    "0001"  # 010: SAC 0, SIC 1
    "465020"  # 140: 36000.25 s * 128 = 4608032
    "B0"  # 020: TYP 101 (roll call), SIM 1, RDP SPI RAB 0, FX 0
    "0A804000"  # 040: 10.5 NM * 256 = 2688; 90 deg = a quarter of 65536
    "0201"  # 070: V G L 0, code 1001 octal
    "008D"  # 090: V G 0, FL 35.25 * 4 = 141
    "F00003"  # 220
    "0003"  # 161
)

# CAT034: items 010 000 030 041 are bits 1 2 3 5 and 120 is bit 11: 1110100 1, 0001000 0
MARKER = bytes.fromhex(
    "22 0015"
    "E910"
    "0002"  # 010
    "01"  # 000: north marker
    "000200"  # 030: 4 s * 128
    "0200"  # 041: 4 s * 128
    "0136"  # 120: 310 m,
    "200000"  # 45 deg * 2^23 / 180,
    "C00000"  # -90 deg * 2^23 / 180 = -2^22
)

# CAT062: items 010 070 105 100 185 are bits 1 4 5 6 7, 060 380 040 080 bits 9 11 12 13, 500 is bit 27:
# 1001111 1, 0101110 1, 0000000 1, 0000010 0
TRACK = bytes.fromhex(
    "3E 0031"
    "9F5D0104"
    "0005"  # 010
    "A8BFC0"  # 070: 86399.5 s * 128 = 11059136
    "00800000 FF000000"  # 105: 45 deg * 2^25 / 180 = 2^23; -90 deg = -2^24
    "FFF830 0001F5"  # 100: x -1000 m * 2 = -2000, y 250.5 m * 2 = 501
    "FED3 0118"  # 185: -75.25 m/s * 4 = -301, 70 m/s * 4 = 280
    "0201"  # 060: code 1001 octal
    "80 F00003"  # 380: the first subfield, ADR
    "0003"  # 040
    "81 A0"  # 080: MON, FX; SIM, TSB
    "C4 003C0063 FFD8 140D"  # 500: APC 30 and 49.5 m * 2, COV -20 m * 2, ATV 5 and 3.25 m/s * 4: subfields 1 2 6
)

# CAT021: items 010 040 161 131 are bits 1 2 3 7, 080 073 bits 11 12, 090 210 145 bits 17 18 21, 155 160 bits 24 26,
# 170 is bit 29: 1110001 1, 0001100 1, 0011001 1, 0010100 1, 1000000 0
REPORT = bytes.fromhex(
    "15 002D"
    "E319332980"
    "0003"  # 010
    "11 20"  # 040: ATP 0, ARC 2 (unknown), FX; SIM
    "0003"  # 161
    "10000000 E0000000"  # 131: 45 deg * 2^30 / 180 = 2^28; -90 deg = -2^29
    "F00003"  # 080
    "465020"  # 073: 36000.25 s * 128
    "61 14"  # 090: NACv 3, NIC 0, FX; NACp 10
    "12"  # 210: VN 2, LTT 2
    "008D"  # 145: FL 35.25 * 4
    "7F9C"  # 155: RE 0, -625 ft/min / 6.25 = -100 in 15 bits
    "0280 C000"  # 160: 640 * 2^-14 NM/s, 270 deg
    "4C9370C30CE0"  # 170: SIM0003 and a space, six bits each: 010011 001001 001101 110000 110000 110000 110011 100000
)

# CAT048 with an item of every form that is skipped between some that are read. Items 010 140 020 040 130 are bits
# 1 2 3 4 7, 250 161 170 bits 10 11 14, 030 110 120 bits 16 19 20, SP RE bits 27 28:
# 1111001 1, 0011001 1, 0100110 1, 0000011 0
FORMS = bytes.fromhex(
    "30 0041"
    "F3334D06"
    "0001"
    "000080"  # 140: 1 s
    "A1 01 00"  # 020, extended twice
    "0100 8000"  # 040: 1 NM, 180 deg
    "C4 11 22 33"  # 130, compound: subfields 1 2 6
    "02 0102030405060708 090A0B0C0D0E0F10"  # 250, repetitive: two of eight octets
    "0007"  # 161
    "41 00"  # 170, extended once
    "03 04"  # 030, a chain of two
    "0064"  # 110: 2500 ft / 25
    "C0 0001 01 010203040506"  # 120, compound: of two octets, and repetitive
    "03 AABB"  # SP, explicit
    "04 AABBCC"  # RE, explicit
)
ALL = (PLOT, MARKER, TRACK, REPORT, FORMS)


def capture(*payloads: bytes, link: int = 1, order: str = "<", magic: int = 0xA1B2C3D4) -> bytes:
    """A capture with a UDP datagram for each payload, in a link of this type."""
    before = {1: bytes(12) + b"\x08\x00", 101: b"", 113: bytes(14) + b"\x08\x00", 228: b""}[link]
    found = struct.pack(order + "IHHiIII", magic, 2, 4, 0, 0, 65535, link)
    for payload in payloads:
        ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 28 + len(payload), 0, 0, 64, 17, 0, b"\x7f\0\0\1", b"\x7f\0\0\1")
        packet = before + ip + struct.pack(">HHHH", 8600, 8600, 8 + len(payload), 0) + payload
        found += struct.pack(order + "IIII", 0, 0, len(packet), len(packet)) + packet
    return found


def damaged(count: int, seed: int = 1) -> Iterator[bytes]:
    """Blocks with something wrong: octets changed, bits turned over, parts taken out, put in, cut off."""
    chance = random.Random(seed)
    for _ in range(count):
        block = bytearray(b"".join(chance.choices(ALL, k=chance.randint(1, 3))))
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(len(block))
            match chance.randrange(6):
                case 0:
                    block[at] = chance.randrange(256)
                case 1:
                    block[at] ^= 1 << chance.randrange(8)
                case 2:
                    del block[at : at + chance.randint(1, 9)]
                case 3:
                    block[at:at] = chance.randbytes(chance.randint(1, 9))
                case 4:
                    del block[at + 1 :]
                case 5:
                    block[at] = 0xFF
            if not block:
                block = bytearray(b"\x30")
        yield bytes(block)


def answer(read: Callable[..., Any], *arguments: Any) -> Any:
    """What it gives, or the sentence that it says."""
    try:
        return read(*arguments)
    except AsterixError as error:
        return str(error)


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, str) or isinstance(other, str):
        return one == other
    columns = one.columns.keys() | other.columns.keys()
    return one.total == other.total and all(
        np.array_equal(one.columns[name], other.columns[name], equal_nan=True) for name in columns
    )


def answers_of(content: bytes) -> Iterator[Any]:
    """What every reader answers; what follows a block changes none."""
    for category in READ.values():
        block = [Block(category.number, 3, max(len(content), 3))]
        ones, zeros = (answer(decode, category, content.ljust(3) + tail, block) for tail in (b"\xff" * 600, bytes(600)))
        assert _same(ones, zeros)
        yield ones
    for read in (read_plots, read_estimates, read_flights):
        yield answer(read, content)
        yield answer(read, capture(content))
