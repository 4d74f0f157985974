"""Captures of networks (pcap): data blocks as UDP datagrams over IPv4, as recorders of feeds keep them."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from sim.interchange.asterix.blocks import AsterixError, Blocks

MAGIC = {  # how a capture begins -> the byte order of its numbers
    b"\xd4\xc3\xb2\xa1": "<",
    b"\xa1\xb2\xc3\xd4": ">",
    b"\x4d\x3c\xb2\xa1": "<",  # stamps in nanoseconds, which are not read
    b"\xa1\xb2\x3c\x4d": ">",
}
NEXT_GENERATION = b"\x0a\x0d\x0d\x0a"
HEAD, PACKET, VERSION = "IHHiIII", "IIII", (2, 4)
ETHERNET, RAW, COOKED, RAW_IPV4 = 1, 101, 113, 228  # types of link
BEFORE = {ETHERNET: 14, RAW: 0, COOKED: 16, RAW_IPV4: 0}  # octets before the datagram of IP
IPV4, TAGS = 0x0800, (0x8100, 0x88A8)  # what an Ethernet frame says that it holds
UDP = 17
LARGEST = 1 << 18  # octets of a packet
PORT = 8600  # which dissectors take for ASTERIX
FROM, TO = bytes((192, 0, 2, 1)), bytes((192, 0, 2, 2))  # addresses for documents, which nobody has [RFC 5737]
MADE_UP = bytes((2, 0, 0, 0, 0, 2)) + bytes((2, 0, 0, 0, 0, 1))  # locally administered: receiver, sender


class Datagram(NamedTuple):
    """What a UDP datagram carries."""

    begin: int  # octet of the file
    end: int


def is_capture(content: bytes) -> bool:
    """Whether a file begins as a capture does."""
    return content[:4] in MAGIC or content[:4] == NEXT_GENERATION


def datagrams(content: bytes) -> tuple[list[Datagram], int]:
    """The datagrams of a capture, and how many of its packets are none (of another protocol, or a fragment).

    Raises ``AsterixError`` in one sentence for what is no capture, is cut off, or is of a link that is not read.
    """
    if content[:4] == NEXT_GENERATION:
        raise AsterixError("is a capture in the format pcapng: write it as pcap ('editcap -F pcap')")
    order = MAGIC[content[:4]]
    head, packet = struct.Struct(order + HEAD), struct.Struct(order + PACKET)
    if len(content) < head.size:
        raise AsterixError("is cut off within the head of the capture")
    link = head.unpack_from(content)[6] & 0x0FFFFFFF
    if link not in BEFORE:
        raise AsterixError(f"is a capture of the link type {link}; read are {', '.join(map(str, BEFORE))}")
    found, others, at = [], 0, head.size
    while at < len(content):
        if len(content) - at < packet.size:
            raise AsterixError(f"at octet {at}: the capture is cut off within the head of a packet")
        _, _, kept, _ = packet.unpack_from(content, at)
        at += packet.size
        if kept > LARGEST or at + kept > len(content):
            raise AsterixError(f"at octet {at}: a packet of {kept} octets is cut off after {len(content) - at}")
        one = _datagram(content, at, at + kept, link)
        if one is None:
            others += 1
        elif one.end > at + kept:
            raise AsterixError(
                f"at octet {at}: of a datagram of {one.end - one.begin} octets {at + kept - one.begin} were captured"
            )
        else:
            found.append(one)
        at += kept
    return found, others


def _datagram(content: bytes, begin: int, end: int, link: int) -> Datagram | None:
    """Of a packet; None where it holds none; one that was cut ends beyond it."""
    at = begin + BEFORE[link]
    if link in (ETHERNET, COOKED):
        kind = content[at - 2 : at] if at <= end else b""
        while link == ETHERNET and len(kind) == 2 and int.from_bytes(kind, "big") in TAGS and at + 4 <= end:
            at += 4
            kind = content[at - 2 : at]
        if int.from_bytes(kind, "big") != IPV4:
            return None
    if at + 20 > end or content[at] >> 4 != 4 or content[at + 9] != UDP:
        return None
    if int.from_bytes(content[at + 6 : at + 8], "big") & 0x3FFF:  # more fragments, or not the first one
        return None
    after = at + 4 * (content[at] & 0x0F)
    if after < at + 20 or after + 8 > end:
        return None
    last = after + int.from_bytes(content[after + 4 : after + 6], "big")
    return Datagram(after + 8, last) if after + 8 <= last else None


def capture_of(blocks: Blocks) -> Iterator[bytes]:
    """The octets of a capture with a datagram for each block, stamped when it is sent, in parts."""
    yield struct.pack("<" + HEAD, 0xA1B2C3D4, *VERSION, 0, 0, LARGEST, ETHERNET)
    octets = blocks.octets.tobytes()
    micro = np.rint(blocks.stamps * 1e6).astype(np.int64)
    ends = np.cumsum(blocks.lengths).tolist()
    head = MADE_UP + struct.pack(">H", IPV4)
    for number, (end, length) in enumerate(zip(ends, blocks.lengths.tolist(), strict=True)):
        ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 28 + length, number & 0xFFFF, 0, 64, UDP, 0, FROM, TO)
        ip = ip[:10] + _checksum(ip) + ip[12:]
        udp = struct.pack(">HHHH", PORT, PORT, 8 + length, 0)  # 0: no checksum
        seconds, rest = divmod(int(micro[number]), 1_000_000)
        size = len(head) + 28 + length
        yield struct.pack("<" + PACKET, seconds, rest, size, size) + head + ip + udp + octets[end - length : end]


def _checksum(head: bytes) -> bytes:
    """Of a head of IP: the complement of the sum of its words in ones' complement."""
    total = sum(struct.unpack(f">{len(head) // 2}H", head))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return int(~total & 0xFFFF).to_bytes(2, "big")
