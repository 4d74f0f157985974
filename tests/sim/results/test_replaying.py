"""A run sent to a FlightGear: a socket and a clock of our own, and addresses that are refused."""

from __future__ import annotations

import dataclasses
import errno
import socket

import numpy as np
import pytest

from aircraft.runway import Runway as Place
from sim.errors import OutputError
from sim.interchange.views.flightgear import PACKET
from sim.results import replaying
from sim.results.replaying import motion_of, replay, resolved


class Clock:
    """A time that passes while somebody sleeps, and by ``slow`` s each time that it is asked for."""

    def __init__(self, slow=0.0):
        self.now, self.slow = 0.0, slow

    def time(self):
        self.now += self.slow
        return self.now

    def sleep(self, seconds):
        assert seconds > 0.0
        self.now += seconds


@pytest.fixture
def listener():
    """A socket on loopback and its address."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as own:
        own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        own.bind(("127.0.0.1", 0))
        own.setblocking(False)
        yield own, f"127.0.0.1:{own.getsockname()[1]}"


def received(own):
    """All packets that wait, as rows."""
    parts = []
    while True:
        try:
            parts.append(own.recv(2048))
        except BlockingIOError:
            return np.frombuffer(b"".join(parts), PACKET)


def test_every_packet_of_the_flight_arrives_and_says_where_it_was(short_flown, listener):
    own, address = listener
    clock = Clock()
    sent = replay(short_flown, address, rate=5.0, clock=clock.time, sleep=clock.sleep)
    found = received(own)
    assert sent == (len(found), pytest.approx(20.0), address)
    assert len(found) == 101
    assert clock.now == pytest.approx(20.0)
    state, runway = short_flown.flight.state, short_flown.scenario.runway
    threshold = Place(runway.latitude, runway.longitude, runway.elevation)
    north, east = threshold.local(found["latitude"], found["longitude"], found["altitude"] - runway.elevation)
    rows = np.argmin(np.abs(state.time - np.linspace(0.0, 20.0, 101)[:, None]), axis=1)
    np.testing.assert_allclose(north, state.north[rows], atol=1e-6)
    np.testing.assert_allclose(east, state.east[rows], atol=1e-6)
    np.testing.assert_allclose(found["phi"], state.bank[rows], atol=1e-6)
    np.testing.assert_allclose(found["psi"], np.mod(state.heading[rows], 2.0 * np.pi), atol=1e-6)


def test_speed_shortens_the_time_and_keeps_the_rate(short_flown, listener):
    own, address = listener
    clock = Clock()
    sent = replay(short_flown, address, rate=5.0, speed=4.0, clock=clock.time, sleep=clock.sleep)
    assert clock.now == pytest.approx(5.0)
    assert len(received(own)) == sent.packets == 26


def test_a_slow_machine_leaves_packets_out_and_ends_in_time_with_the_last(short_flown, listener):
    own, address = listener
    clock = Clock(slow=0.3)  # s a look at the clock, and a packet is due every 0.2 s
    sent = replay(short_flown, address, rate=5.0, clock=clock.time, sleep=clock.sleep)
    found = received(own)
    assert 10 < sent.packets == len(found) < 101
    assert clock.now < 20.0 + 2 * 3 * 0.3  # two turns more, each of three looks at the clock
    whole = motion_of(short_flown, np.array([20.0]))
    assert found["longitude"][-1] == whole.longitude[0]


@pytest.mark.parametrize(
    ("target", "said"),
    [
        ("5501", "write it as HOST:PORT"),
        (":5501", "write it as HOST:PORT"),
        ("localhost:", "write it as HOST:PORT"),
        ("localhost:0", "write it as HOST:PORT"),
        ("localhost:65536", "write it as HOST:PORT"),
        ("localhost:http", "write it as HOST:PORT"),
        ("localhost:٥٥", "write it as HOST:PORT"),
        ("192.0.2.1:5501", r"192\.0\.2\.1 is not this machine; say --remote"),
        ("0.0.0.0:5501", r"0\.0\.0\.0 is not this machine"),
        ("[2001:db8::1]:5501", "2001:db8::1 is not this machine"),
        ("[::ffff:192.0.2.1]:5501", "192.0.2.1 is not this machine"),
    ],
)
def test_addresses_that_cannot_be_are_one_sentence_each(target, said):
    with pytest.raises(OutputError, match=said) as caught:
        resolved(target, False)
    assert "\n" not in str(caught.value)


def answers(monkeypatch, *addresses):
    """Let every name have these addresses."""

    def found(host, port, **kind):
        families = (socket.AF_INET6 if ":" in one else socket.AF_INET for one in addresses)
        return [(family, 0, 0, "", (one, port)) for family, one in zip(families, addresses, strict=True)]

    monkeypatch.setattr(socket, "getaddrinfo", found)


def test_every_address_of_a_name_must_be_of_this_machine(monkeypatch):
    answers(monkeypatch, "127.0.0.1", "192.0.2.7")
    with pytest.raises(OutputError, match=r"192\.0\.2\.7 is not this machine"):
        resolved("name:5501", False)
    assert resolved("name:5501", True).name == "127.0.0.1:5501"


def test_the_address_of_ipv4_comes_first_where_flightgear_listens(monkeypatch):
    answers(monkeypatch, "::1", "127.0.0.1")
    assert resolved("localhost:5501", False).name == "127.0.0.1:5501"
    answers(monkeypatch, "::1")
    assert resolved("localhost:5501", False).name == "[::1]:5501"


def test_a_name_that_nobody_has_is_one_sentence(monkeypatch):
    def none(*_, **__):
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", none)
    with pytest.raises(OutputError, match="there is no host 'nobody'"):
        resolved("nobody:5501", False)


def test_where_nobody_listens_one_sentence_says_so(short_flown, listener):
    own, address = listener
    own.close()
    clock = Clock()
    with pytest.raises(OutputError, match=f"{address}: nobody listens there; start FlightGear first"):
        replay(short_flown, address, clock=clock.time, sleep=clock.sleep)


def test_a_socket_that_cannot_be_used_is_one_sentence(short_flown, monkeypatch):
    def taken(*_):
        raise OSError(errno.EADDRINUSE, "Address already in use")

    monkeypatch.setattr(replaying.socket, "socket", taken)
    with pytest.raises(OutputError, match=r"127\.0\.0\.1:5501: cannot be sent to: Address already in use"):
        replay(short_flown, "127.0.0.1:5501")


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"rate": 0.0}, "--rate 0: must lie within 1 and 200"),
        ({"rate": float("nan")}, "--rate nan: must lie within"),
        ({"speed": 1e6}, r"--speed 1e\+06: must lie within 0.1 and 100"),
    ],
)
def test_rates_and_speeds_that_cannot_be_are_refused_before_any_socket(short_flown, monkeypatch, how, said):
    monkeypatch.setattr(replaying.socket, "socket", None)
    with pytest.raises(OutputError, match=said):
        replay(short_flown, "127.0.0.1:5501", **how)


def test_a_flight_that_nobody_knows_cannot_be_replayed(short_flown):
    unknown = dataclasses.replace(short_flown, flight=dataclasses.replace(short_flown.flight, outcome="unknown"))
    with pytest.raises(OutputError, match="there is no flight to replay"):
        replay(unknown, "127.0.0.1:5501")


def test_the_command_says_what_it_sent(short_folder, listener, command):
    own, address = listener
    told = command("replay", short_folder, "--flightgear", address, "--rate", 2, "--speed", 100)
    assert (told.returncode, told.stderr) == (0, "")
    assert told.stdout == f"sent 2 packets, 20.0 s of the flight, to {address}\n"
    assert len(received(own)) == 2
    for arguments, said in (
        ([short_folder], "missing option '--flightgear'"),
        ([short_folder.parent, "--flightgear", address], "not a run folder"),
        ([short_folder, "--flightgear", "192.0.2.1:5501"], "is not this machine"),
    ):
        told = command("replay", *arguments)
        assert told.returncode == 2
        assert said in told.stderr.lower() or said in told.stderr
        assert told.stderr.count("\n") == 1
