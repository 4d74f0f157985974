"""Captures of networks: written as they are read, of every link, and a sentence for each damage."""

from __future__ import annotations

import re
import struct

import numpy as np
import pytest

from sim.interchange.asterix.blocks import AsterixError, Blocks, blocks_of, merged, packed
from sim.interchange.asterix.pcap import capture_of, datagrams
from sim.interchange.asterix.reading import feed_of, is_asterix
from tests.asterix_blocks import MARKER, PLOT, TRACK, capture

OTHER = b"\x41\x00\x05ab"  # a block of category 65


def categories(content):
    return [block.category for block in feed_of(content, (48,)).blocks]


@pytest.mark.parametrize("link", [1, 101, 113, 228])
@pytest.mark.parametrize(("order", "magic"), [("<", 0xA1B2C3D4), (">", 0xA1B2C3D4), ("<", 0xA1B23C4D)])
def test_datagrams_of_every_link_and_byte_order_are_read(link, order, magic):
    content = capture(PLOT, MARKER + PLOT, link=link, order=order, magic=magic)
    assert is_asterix(content[:4])
    assert categories(content) == [48, 34, 48]
    assert feed_of(content, (48,)).records(48).columns["161.number"].tolist() == [3.0, 3.0]


def test_a_frame_may_be_tagged_and_padded_and_what_is_no_datagram_is_told():
    content = capture(PLOT, PLOT, b"\x99 some other protocol", b"")
    head, frames, at = content[:24], [], 24
    while at < len(content):
        size = struct.unpack_from("<I", content, at + 8)[0]
        frames.append(content[at + 16 : at + 16 + size])
        at += 16 + size
    frames[0] = frames[0][:12] + b"\x81\x00\x00\x05" + frames[0][12:] + bytes(9)  # a tag of a network, and padding
    arp = bytes(12) + b"\x08\x06" + bytes(28)
    fragment = bytearray(frames[1])
    fragment[20] |= 0x20  # more fragments follow
    tcp = bytearray(frames[1])
    tcp[23] = 6
    made = [struct.pack("<IIII", 0, 0, len(one), len(one)) + bytes(one) for one in (*frames, arp, fragment, tcp, b"")]
    feed = feed_of(head + b"".join(made), (48,))
    assert [block.category for block in feed.blocks] == [48, 48]
    assert feed.remarks == ("5 packets of the capture hold no data blocks of ASTERIX and are left out",)


def test_a_capture_that_is_written_is_read_again_with_the_stamps_of_its_blocks():
    made = merged([
        packed(48, np.array([21, 21, 21]), np.frombuffer(PLOT[3:] * 3, np.uint8), np.array([1.5, 1.5, 4.0]) + 1.7e9),
        packed(34, np.array([18]), np.frombuffer(MARKER[3:], np.uint8), np.array([3.25]) + 1.7e9),
    ])  # fmt: skip
    content = b"".join(capture_of(made))
    assert categories(content) == [48, 34, 48]
    assert feed_of(content, (48,)).records(48).total == 3
    assert content[24:28] == struct.pack("<I", 1_700_000_001)
    assert content[28:32] == struct.pack("<I", 500_000)
    ip = struct.unpack(">10H", content[24 + 16 + 14 : 24 + 16 + 34])
    total = sum(ip)
    assert (total & 0xFFFF) + (total >> 16) == 0xFFFF  # the words of a head and its checksum add up to ones


def test_records_of_one_stamp_share_a_block_as_far_as_it_reaches():
    lengths = np.array([40, 10, 40, 40, 10])
    octets = np.repeat(np.arange(5, dtype=np.uint8), lengths)
    made = packed(62, lengths, octets, np.array([1.0, 1.0, 1.0, 2.0, 2.0]), most=93)
    content = made.octets.tobytes()
    blocks = blocks_of(content)
    assert [content[block.begin : block.end] for block in blocks] == [
        bytes([0]) * 40 + bytes([1]) * 10, bytes([2]) * 40, bytes([3]) * 40 + bytes([4]) * 10,
    ]  # fmt: skip
    assert made.stamps.tolist() == [1.0, 1.0, 2.0]
    assert made.lengths.tolist() == [53, 43, 53]


def test_no_records_are_no_blocks():
    none = packed(48, np.zeros(0, int), np.zeros(0, np.uint8), np.zeros(0))
    assert merged([none, none]) == Blocks(*(pytest.approx(column) for column in none))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (capture(PLOT)[:20], "is cut off within the head of the capture"),
        (capture(PLOT)[:30], "at octet 24: the capture is cut off within the head of a packet"),
        (capture(PLOT)[:-1], "at octet 40: a packet of 66 octets is cut off after 65"),
        (capture(PLOT)[:20] + b"\x69" + capture(PLOT)[21:], "is a capture of the link type 105; read are 1, 101, 113"),
        (b"\n\r\r\n" + bytes(40), "is a capture in the format pcapng: write it as pcap ('editcap -F pcap')"),
        (capture(PLOT[:-1]), "at octet 82: a block of 24 octets is cut off after 23"),
        (capture(OTHER), "has no blocks of the categories that are read here, 048: it has 065"),
        (TRACK, "has no blocks of the categories that are read here, 048: it has 062"),
        (b"", "has no blocks of the categories that are read here, 048: it has none"),
    ],
)
def test_what_is_no_feed_of_this_kind_is_one_sentence(content, said):
    with pytest.raises(AsterixError, match=re.escape(said)):
        feed_of(content, (48,))


def test_a_packet_of_which_only_the_begin_was_captured_is_refused():
    content = bytearray(capture(PLOT))
    content[32:36] = struct.pack("<I", 60)  # captured of 66
    with pytest.raises(AsterixError, match="at octet 40: of a datagram of 24 octets 18 were captured"):
        datagrams(bytes(content[:-6]))


def test_blocks_of_other_categories_are_told():
    feed = feed_of(OTHER + PLOT + OTHER + TRACK, (48,))
    assert feed.categories == [48, 62, 65]
    assert feed.remarks == ("2 blocks of category 065 are not read",)


def test_texts_and_tables_are_not_taken_for_blocks():
    for content in (b"time,rho,theta\n", b'"time",rho\n', b"0,1\n", b"", b"0", b"PAR1", b"t\0i\0"):
        assert not is_asterix(content, "plots.csv")
    assert is_asterix(PLOT, "plots")
    assert is_asterix(b"", "PLOTS.AST")
