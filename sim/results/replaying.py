"""replay(): a run sent to a FlightGear as it was flown, in its time, packet by packet over UDP."""

from __future__ import annotations

import ipaddress
import math
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np

from aircraft.runway import Runway as Place
from sim.errors import OutputError
from sim.flight.interpolation import truth_at
from sim.interchange.views.flightgear import Motion, packets
from sim.reporting.replay import nose
from sim.results.result import Result

RATES, SPEEDS = (1.0, 200.0), (0.1, 100.0)  # Hz, and times real time, that can be asked for
RATE, SPEED = 30.0, 1.0


class Sent(NamedTuple):
    """What was sent, and where to."""

    packets: int
    duration: float  # s of the flight
    address: str


class Target(NamedTuple):
    """One address that a socket sends to."""

    family: int
    address: Any
    name: str


def replay(
    result: Result,
    target: str,
    *,
    rate: float = RATE,
    speed: float = SPEED,
    remote: bool = False,
    progress: Any = None,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Sent:
    """Send the flight and its roll-out to ``target``, "HOST:PORT".

    It takes as long as the flight took, divided by ``speed``: where the machine is too slow, packets are left out.

    Parameters
    ----------
    rate : packets a second of real time
    remote : allow a host that is not this machine
    clock, sleep : s; what says the time and what waits

    Raises ``OutputError`` in one sentence for a rate, a speed or an address that cannot be, an address beyond this
    machine unless ``remote``, a flight that nobody knows, and where nobody listens (any more).
    """
    for value, (low, high), option in ((rate, RATES, "--rate"), (speed, SPEEDS, "--speed")):
        if not low <= value <= high:
            raise OutputError(f"{option} {value:g}: must lie within {low:g} and {high:g}")
    place = resolved(target, remote)
    if not result.flight.known or len(result.flight.time) < 2:
        raise OutputError("there is no flight to replay: of one that only plots tell of no motion is known")
    instants = _instants(result, speed / rate)
    octets = packets(motion_of(result, instants))
    due = (instants - instants[0]) / speed
    count = 0
    with _sending(place) as send:
        turns = _turns(due, clock, sleep)
        for number in turns if progress is None else progress(turns, len(due), "packets"):
            send(octets[number].tobytes())
            count += 1
    return Sent(count, float(instants[-1] - instants[0]), place.name)


def _turns(due: np.ndarray, clock: Callable[[], float], sleep: Callable[[float], None]) -> Iterator[int]:
    """Which of the packets to send, each when it is ``due`` (n,) s after the first; what is past is left out."""
    began, number, last = clock(), 0, len(due) - 1
    while number <= last:
        early = float(due[number]) - (clock() - began)
        if early > 0.0:
            sleep(early)
        yield number
        now = int(np.searchsorted(due, clock() - began, "right")) - 1
        number = max(number + 1, min(now, last))


def resolved(target: str, remote: bool) -> Target:
    """The address of "HOST:PORT"; raises ``OutputError`` for none, and for one beyond this machine unless ``remote``.

    Every address that the host has must be of this machine. FlightGear listens to IPv4, so that comes first.
    """
    host, colon, port = target.rpartition(":")
    bare = host.removeprefix("[").removesuffix("]")
    if not colon or not bare or not (port.isascii() and port.isdigit() and 0 < int(port) < 65536):
        raise OutputError(f"--flightgear {target}: write it as HOST:PORT, such as localhost:5501")
    try:
        found = socket.getaddrinfo(bare, int(port), type=socket.SOCK_DGRAM)
    except (OSError, ValueError):
        raise OutputError(f"--flightgear {target}: there is no host '{bare}'") from None
    for _, _, _, _, address in found:
        if not remote and not _of_this_machine(str(address[0])):
            raise OutputError(
                f"--flightgear {target}: {address[0]} is not this machine; say --remote to send the flight there"
            )
    family, _, _, _, address = min(found, key=lambda one: one[0] != socket.AF_INET)
    return Target(family, address, f"{address[0]}:{port}" if family == socket.AF_INET else f"[{address[0]}]:{port}")


def _of_this_machine(address: str) -> bool:
    found = ipaddress.ip_address(address)
    inner = getattr(found, "ipv4_mapped", None)
    return bool((inner or found).is_loopback)


@contextmanager
def _sending(place: Target) -> Iterator[Callable[[bytes], object]]:
    """What sends a packet. A socket that is connected hears when nobody listens."""
    try:
        with socket.socket(place.family, socket.SOCK_DGRAM) as own:
            own.connect(place.address)
            yield own.send
    except ConnectionRefusedError:
        raise OutputError(
            f"{place.name}: nobody listens there; start FlightGear first: "
            f"fgfs --fdm=null --native-fdm=socket,in,30,,{place.name.rpartition(':')[2]},udp"
        ) from None
    except OSError as error:
        raise OutputError(f"{place.name}: cannot be sent to: {error.strerror or error}") from None


def _instants(result: Result, step: float) -> np.ndarray:
    """(n,) s at which the flight is shown, the last record included."""
    time = result.flight.whole.time
    first, last = float(time[0]), float(time[-1])
    count = math.ceil((last - first) / step - 1e-6)  # a last step that rounding left over is none
    return np.append(first + step * np.arange(count), last)


def motion_of(result: Result, instants: np.ndarray) -> Motion:
    """The flight at n instants, s, as FlightGear is told it.

    The airspeed that is shown is the equivalent one, which an indicator without errors shows at low speeds. The ground
    is level at the threshold's elevation. Flaps count from the largest setting of the flight and its landing.
    """
    flight, runway = result.flight.whole, result.scenario.runway
    state = truth_at(flight, instants).state
    heading = np.interp(instants, flight.time, np.unwrap(nose(flight)))
    threshold = Place(runway.latitude, runway.longitude, runway.elevation)
    latitude, longitude = threshold.geodetic(state.north, state.east, state.height)
    landing = result.prepared.autopilot.landing
    full = max(float(np.nan_to_num(flight.state.flaps).max(initial=0.0)), 0.0 if landing is None else landing.flaps)
    return Motion(
        np.asarray(latitude),
        np.asarray(longitude),
        runway.elevation + state.height,
        np.asarray(state.height),
        np.array((state.bank, state.pitch, np.mod(heading, 2.0 * np.pi))),
        np.array((state.roll_rate, state.pitch_rate, state.yaw_rate)),
        np.array((state.angle_of_attack, state.sideslip)),
        np.array((state.velocity_north, state.velocity_east, state.velocity_up)),
        np.asarray(state.equivalent_airspeed),
        np.array((state.specific_force_forward, state.specific_force_right, state.specific_force_down)),
        np.array((state.aileron, state.elevator, state.rudder)),
        np.asarray(state.flaps) / full if full > 0.0 else np.zeros(len(instants)),
        np.asarray(state.gear),
        np.asarray(state.main_wheels) > 1e-6,  # between two records it rises in a line
        np.zeros(len(instants)) if flight.utc is None else flight.utc + instants,
    )
