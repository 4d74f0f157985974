"""The contract of a sensor: what it measures, where it is, and its looks between two records of a flight.

A kind of sensor is one file of ``sim/observation/sensors`` with one frozen dataclass that has all members of `Sensor`.
The file's name is the ``kind`` of ``[sensors.NAME]``, its fields are the other keys, in SI and with their unit in the
annotation: ``period: Annotated[float, "s"] = 4.0`` is ``period_s`` in a scenario. A field ``runway: Annotated[Runway,
"given"]`` is filled by the simulation. Nothing else knows the kind: what it measures flies, is drawn, compared with the
truth and exported by the names of its channels. `broken_promises` tries a class on all this. A kind whose fields have
no usable defaults says in ``example: ClassVar[dict[str, Any]]`` what a scenario would write, without ``kind``.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable, Iterator
from inspect import getattr_static
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np

from aircraft.ranges import Range
from aircraft.state import AircraftState
from sim.flight.interpolation import state_at
from sim.randomness import Streams
from tracking.measurement import wrap

DEGREES = 180 / np.pi  # of a radian
PERIOD = Range(least=1 / 120, why="the flight is not known in steps finer than 1/120 s")  # s between epochs


class Quantity(NamedTuple):
    """What a channel measures: units, whether it is an angle, and whether it depends on the place alone."""

    unit: str = ""  # suffix of figures
    si: str = ""  # suffix of records, which are in SI
    factor: float = 1.0  # from SI to ``unit``
    wraps: bool = False  # an angle: a difference is taken the shorter way round
    place: bool = False  # says something of where the aircraft is, so that a track can begin with it


_LENGTH, _SPEED = Quantity("m", "m", place=True), Quantity("mps", "mps")
_ANGLE = Quantity("deg", "rad", DEGREES, wraps=True)
_DIRECTION = _ANGLE._replace(place=True)

QUANTITIES: dict[str, Quantity] = {
    "range": _LENGTH,  # from the antenna, slant
    "azimuth": _DIRECTION,  # + right of the sensor's zero, seen from the antenna
    "elevation": _DIRECTION,  # above the horizon of the antenna
    "north": _LENGTH,
    "east": _LENGTH,
    "height": _LENGTH,  # above the threshold
    "pressure_altitude": Quantity("m", "m"),  # above 1013.25 hPa: no place, for that the QNH must be known
    "deviation": _DIRECTION,  # from a course line
    "range_rate": _SPEED,  # + receding
    "airspeed": _SPEED,
    "ground_speed": _SPEED,
    "vertical_rate": _SPEED,  # + up
    "bank": _ANGLE,
    "pitch": _ANGLE,
    "heading": _ANGLE,
    "course": _ANGLE,
    "aerodynamic_bank": _ANGLE,
    "flight_path_angle": _ANGLE,
    "air_course": _ANGLE,
    "load_factor_forward": Quantity(),
    "load_factor_right": Quantity(),
    "load_factor_up": Quantity(),
}
"""Quantities by the names of channels; a name that is not here is a plain number, such as a load factor.

A sensor from outside that measures something with a unit adds its row: ``QUANTITIES["beat"] = Quantity("hz", "hz")``.
"""


def quantity_of(channel: str) -> Quantity:
    """The quantity of a channel, with or without its sensor's name before it."""
    return QUANTITIES.get(channel.rpartition(".")[2], Quantity())


class Look(NamedTuple):
    """One measurement of all channels, m of them, in every noise draw."""

    epoch: float  # s, when it was true
    arrival: float  # s, when it was known, not before the epoch
    z: np.ndarray  # (m, draws), SI; NaN = missed in that draw
    R: np.ndarray  # (m, m) or (m, m, draws), the accuracy that the sensor states; it need not be right
    candidates: np.ndarray | None = None  # (c, m, draws) plots with the false ones, z first; only with ``clutter``


class Recording(NamedTuple):
    """What a sensor has recorded once and for all, instead of watching the flight."""

    looks: int
    first: float  # s of the flight that it is `Sensor.dated` by, before that of its own clock
    last: float  # s
    dated: bool  # whether its clock counts from 1970
    remarks: tuple[str, ...] = ()  # what its user should know


class Sensor(Protocol):
    """What watches the aircraft. `broken_promises` tries whether a class is one.

    A class must have ``channels``, ``period``, ``begin``, ``step`` and ``truth``. What else it leaves out is as
    `DEFAULTS` says: no antenna, no false plots, no outline, no recording, and a place where its channels are one.
    """

    @property
    def channels(self) -> tuple[str, ...]:
        """What is measured, in the order of z: names of `QUANTITIES`, which give unit and kind; each once."""
        ...

    @property
    def gives_place(self) -> bool:
        """Whether one look alone says where the aircraft is on the ground plane: north and east, or range and azimuth.

        A tracker on the ground plane combines a range and an azimuth of sensors that do not.
        """
        ...

    @property
    def clutter(self) -> float:
        """Mean number of false plots beside the target's own in a look; 0 = the sensor knows its target.

        A sensor with clutter fills ``Look.candidates``, and has ``detection``, the probability of the target's own
        plot, and ``clutter_density(*z)``, the false plots per m2 of the ground plane at a place.
        """
        ...

    @property
    def antenna(self) -> tuple[float, float, float] | None:
        """(north, east, height) m, from where range, azimuth and elevation are counted; None = it has no antenna."""
        ...

    @property
    def zero_azimuth(self) -> float | None:
        """Where its azimuth is zero, rad clockwise from north; None = it measures none."""
        ...

    @property
    def period(self) -> float:
        """s between epochs; at least 1/120, because the flight is not known in finer steps."""
        ...

    @property
    def recording(self) -> Recording | None:
        """What it recorded; None = it watches the flight. A recording is the same in every draw."""
        ...

    def dated(self, utc: float | None) -> Any:
        """The sensor for a flight that has its time 0 at ``utc``, s since 1970; None = it is flown at no date."""
        ...

    def begin(self, time: float, streams: Streams) -> Any:
        """State before the first epoch, which is one period after ``time`` (s).

        Every random number comes from ``streams``; row k of a stream belongs to epoch k, whether it is used or not, so
        that any steps, in the loop or over a record, see the same noise. A state may tell in a field ``epoch`` when its
        next epoch is, s: over a record it is not stepped through the time before.
        """
        ...

    def step(self, state: Any, before: AircraftState, after: AircraftState) -> tuple[Any, list[Look]]:
        """The state after ``after``, and the looks with ``before.time < epoch <= after.time``; two records in floats.

        What is out of sight gives no look. `sim.flight.interpolation.state_at` is the motion between the records.
        """
        ...

    def truth(self, state: AircraftState) -> np.ndarray:
        """Channels without any error, SI, shape (m, ...) for a state of floats or of arrays of one shape ``...``."""
        ...

    def outline(self) -> tuple[tuple[float, float], ...]:
        """Corners (north, east) m of what it covers on the ground; () = all, or nothing that could be drawn."""
        ...


def _gives_place(sensor: Any) -> bool:
    return {"north", "east"} <= {*sensor.channels} or {"range", "azimuth"} <= {*sensor.channels}


DEFAULTS: dict[str, Any] = {  # members that a class may leave out, and what they then are
    "gives_place": property(_gives_place),
    "clutter": 0.0,
    "antenna": None,
    "zero_azimuth": None,
    "outline": lambda sensor: (),
    "recording": None,
    "dated": lambda sensor, utc: sensor,
}
MEMBERS = ("channels", "period", "begin", "step", "truth")  # that a class must have
CLUTTERED = ("detection", "clutter_density")  # of a sensor with clutter
_ABSENT = object()


def missing_members(cls: type) -> list[str]:
    """Members of a sensor that a class lacks."""
    fields = getattr(cls, "__dataclass_fields__", {})
    return [name for name in MEMBERS if name not in fields and getattr_static(cls, name, _ABSENT) is _ABSENT]


def unplaced(sensor: Any) -> Iterator[str]:
    """What a sensor that measures from a place does not say of that place."""
    polar = {*sensor.channels} & {"range", "azimuth", "elevation"}
    if sensor.antenna is None and polar:
        yield f"antenna is None, and {min(polar)} is counted from it"
    if sensor.zero_azimuth is None and "azimuth" in polar:
        yield "zero_azimuth is None, and azimuth is counted from it"


class SensorError(ValueError):
    """A sensor that does not keep its contract; the sentence begins with the member."""


def ask(sensor: Any, member: str, *arguments: Any) -> Any:
    """What a member of a sensor's contract is or answers; what it raises becomes a `SensorError`."""
    try:
        found = getattr(sensor, member)
        return found(*arguments) if arguments or callable(found) else found
    except MemoryError:
        raise
    except Exception as error:
        raise SensorError(f"{member} raises {_said(error)}") from error


def looks_of(
    sensor: Any, state: Any, before: AircraftState, after: AircraftState, draws: int
) -> tuple[Any, list[Look]]:
    """``sensor.step``; raises `SensorError` where it gives no looks of the shapes of its channels and draws."""
    answer = ask(sensor, "step", state, before, after)
    if not (isinstance(answer, tuple) and len(answer) == 2 and isinstance(answer[1], list)):
        raise SensorError(f"step gives {type(answer).__name__}, not (state, list of looks)")
    m = len(sensor.channels)
    for look in answer[1]:
        if not isinstance(look, Look):
            raise SensorError(f"step gives a {type(look).__name__} for a look, not a sim.observation.sensor.Look")
        if np.shape(look.z) != (m, draws):
            raise SensorError(f"step gives z of the shape {np.shape(look.z)}, not ({m}, {draws})")
        if np.shape(look.R) not in ((m, m), (m, m, np.shape(look.z)[1])):
            raise SensorError(f"step gives R of the shape {np.shape(look.R)}, not ({m}, {m})")
        if not np.isfinite(look.R).all():
            raise SensorError("step gives an R that is not finite")
        if not before.time < look.epoch <= after.time:
            raise SensorError(f"step gives a look at {look.epoch} s, not within {before.time:g} and {after.time:g} s")
        if not look.arrival >= look.epoch:
            raise SensorError("step gives a look that arrives before its epoch")
    return answer


def _said(error: BaseException) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())[:200]}".rstrip(": ")


# ---- a class is tried


DRAWS, SEED = 20, 5
TWICE, HALF = 2.5, 0.4  # of the stated variance: the noise of a few looks is known no better
COARSE = 3  # records a step, where steps are made longer


def broken_promises(cls: type, make: Callable[[], Any]) -> list[str]:
    """What a class breaks of the contract of a sensor, in sentences; empty = it is one.

    ``make`` gives the instance that is tried, placed by the default runway. It watches a straight final approach, from
    5 km before the threshold to 1.4 km, at 60 m/s and on 8/3 degrees.
    """
    if not isinstance(cls, type) or not dataclasses.is_dataclass(cls):
        return ["a sensor is a class that is a frozen dataclass"]
    lacking = missing_members(cls)
    if lacking:
        asked = {name: inspect.getdoc(getattr(Sensor, name)) or "" for name in lacking}
        return [f"it has no '{name}': {text.splitlines()[0]}" for name, text in asked.items()]
    try:
        sensor = make()
    except Exception as error:
        return [f"it cannot be made with its example or its defaults: {_said(error)}"]
    broken: list[str] = []
    for promises in (_named, _placed, _true, _outlined, _recorded, _watched):
        try:
            broken += promises(sensor)
        except Exception as error:
            broken.append(str(error) if isinstance(error, SensorError) else f"it cannot be tried: {_said(error)}")
            break  # what follows builds on it
    return broken


def _approach() -> list[AircraftState]:
    time = np.arange(0.0, 60.0, 0.1)
    columns = {name: np.zeros(len(time)) for name in AircraftState._fields}
    slope, north = math.tan(math.radians(8.0 / 3.0)), -5000.0 + 60.0 * time
    columns |= {"time": time, "north": north, "east": np.full(len(time), 20.0), "height": slope * (300.0 - north)}
    constant = {"velocity_north": 60.0, "velocity_up": -60.0 * slope, "airspeed": 60.0, "pitch": -math.atan(slope)}
    columns |= {name: np.full(len(time), value) for name, value in constant.items()}
    columns["specific_force_down"] = np.full(len(time), -9.80665)
    return [AircraftState(*row) for row in zip(*(column.tolist() for column in columns.values()), strict=True)]


def _named(sensor: Any) -> Iterator[str]:
    channels = ask(sensor, "channels")
    named = isinstance(channels, tuple) and all(isinstance(name, str) and name.isidentifier() for name in channels)
    if not named or not channels or len(set(channels)) != len(channels):
        raise SensorError(f"channels must be a tuple of different names such as ('range', 'azimuth'), not {channels!r}")
    if not isinstance(ask(sensor, "gives_place"), bool):
        yield f"gives_place must be True or False, not {sensor.gives_place!r}"
    for name, least in (("period", 1 / 120), ("clutter", 0.0)):
        value = ask(sensor, name)
        if not _finite(value) or value < least * (1.0 - 1e-9):
            yield f"{name} must be a number of at least {least:.3g}, not {value!r}"


def _placed(sensor: Any) -> Iterator[str]:
    channels, antenna, zero = {*sensor.channels}, ask(sensor, "antenna"), ask(sensor, "zero_azimuth")
    if antenna is not None and not (isinstance(antenna, tuple) and len(antenna) == 3 and all(map(_finite, antenna))):
        yield f"antenna must be (north, east, height) in m, or None, not {antenna!r}"
    if zero is not None and not _finite(zero):
        yield f"zero_azimuth must be a number of radians, or None, not {zero!r}"
    yield from unplaced(sensor)
    if sensor.gives_place and not ({"north", "east"} <= channels or {"range", "azimuth"} <= channels):
        yield "gives_place is True, and channels have neither north and east nor range and azimuth"
    if sensor.clutter > 0.0:
        yield from (f"it has clutter and no '{name}'" for name in CLUTTERED if not hasattr(sensor, name))


def _true(sensor: Any) -> Iterator[str]:
    records, m = _approach()[::100], len(sensor.channels)
    each = [np.asarray(ask(sensor, "truth", record), float) for record in records]
    if each[0].shape != (m,):
        raise SensorError(f"truth of one state has the shape {each[0].shape}, not ({m},)")
    together = np.asarray(ask(sensor, "truth", AircraftState(*map(np.array, zip(*records, strict=True)))), float)
    if together.shape != (m, len(records)):
        raise SensorError(f"truth of {len(records)} states has the shape {together.shape}, not ({m}, {len(records)})")
    if not np.isfinite(together).all():
        yield "truth is not finite on a final approach"
    if not np.allclose(together, np.stack(each, axis=-1), rtol=1e-9, atol=1e-9, equal_nan=True):
        yield "truth of several states is not that of each"


def _outlined(sensor: Any) -> Iterator[str]:
    outline = ask(sensor, "outline")
    pairs = isinstance(outline, tuple) and all(len(corner) == 2 and all(map(_finite, corner)) for corner in outline)
    if not pairs or len(outline) in (1, 2):
        yield "outline must be a tuple of at least three (north, east) in m, or ()"


def _recorded(sensor: Any) -> Iterator[str]:
    found = ask(sensor, "recording")
    if not (found is None or (isinstance(found, Recording) and found.looks > 0 and found.first <= found.last)):
        yield f"recording must be None, or a sim.observation.sensor.Recording of at least one look, not {found!r}"
    if type(ask(sensor, "dated", None)) is not type(sensor):
        yield "dated gives no sensor of its kind"


def _watched(sensor: Any) -> Iterator[str]:
    records = _approach()
    looks = _looks(sensor, records, DRAWS)
    if not looks:
        yield "step sees nothing of a final approach; say in 'example' what makes a sensor that does"
        return
    epochs = np.array([look.epoch for _, _, look in looks])
    if any(not before < look.epoch <= after + 1e-9 for before, after, look in looks):
        yield "step gives looks whose epoch does not lie between the two records"
    if (np.diff(epochs) <= 0.0).any():
        yield "step does not give its looks in the order of their epochs"
    turns = epochs / sensor.period
    if (np.abs(turns - np.round(turns)) > 1e-6).any() and sensor.recording is None:
        yield "step gives looks at other times than multiples of 'period' after the beginning"
    for _, _, look in looks:
        _check(sensor, look)
    z = np.stack([look.z for _, _, look in looks])
    R = np.stack([look.R if np.ndim(look.R) == 3 else np.repeat(look.R[..., None], DRAWS, -1) for _, _, look in looks])
    variance = np.einsum("kiin->kin", R)
    yield from _noise(sensor, records, epochs, z, variance)
    alone = np.stack([look.z for _, _, look in _looks(sensor, records, 1)])
    if alone.shape[0] != len(z) or not np.array_equal(alone[..., 0], z[..., 0], equal_nan=True):
        yield "step measures another thing in a draw when there are more draws, or when it is asked again"
    coarse = np.stack([look.z for _, _, look in _looks(sensor, records[::COARSE], DRAWS)])[: len(z)]
    same = coarse.shape[0] > 0 and len(coarse) >= len(z) - math.ceil(COARSE * 0.1 / sensor.period)
    off = np.abs(coarse - z[: len(coarse)]) > 1e-3 * np.sqrt(variance[: len(coarse)]) + 1e-9
    if not same or off.any():
        yield "step measures another thing when records lie farther apart: row k of a stream belongs to epoch k"


def _looks(sensor: Any, records: list[AircraftState], draws: int) -> list[tuple[float, float, Look]]:
    state = ask(sensor, "begin", records[0].time, Streams(SEED, 0, draws, "trial"))
    found = []
    for before, after in pairwise(records):
        state, looks = looks_of(sensor, state, before, after, draws)
        found += [(before.time, after.time, look) for look in looks]
    return found


def _check(sensor: Any, look: Look) -> None:
    R = look.R if look.R.ndim == 3 else look.R[..., None]
    if np.isinf(look.z).any():
        raise SensorError("step measures something infinite; what is absent is NaN")
    if (np.einsum("iin->in", R) <= 0.0).any() or not np.allclose(R, R.swapaxes(0, 1)):
        raise SensorError("step gives an R that is no covariance: symmetric, with variances above 0")
    if (look.candidates is None) != (sensor.clutter == 0.0):
        raise SensorError("step gives candidates where there is no clutter, or none where there is")
    if look.candidates is not None and not np.array_equal(look.candidates[0], look.z, equal_nan=True):
        raise SensorError("step gives candidates of which z is not the first")


def _noise(sensor: Any, records: list[AircraftState], epochs: Any, z: Any, variance: Any) -> Iterator[str]:
    first = [min(int(epoch / 0.1), len(records) - 2) for epoch in epochs]
    states = [state_at(records[i], records[i + 1], epoch) for i, epoch in zip(first, epochs, strict=True)]
    error = z - np.stack([sensor.truth(state) for state in states])[..., None]
    for row, name in enumerate(sensor.channels):
        own = wrap(error[:, row]) if quantity_of(name).wraps else error[:, row]
        share = own**2 / variance[:, row]
        if not np.isfinite(share).any():
            yield f"step never measures {name}"
        elif not HALF <= np.nanmean(share) <= TWICE:
            yield f"step measures {name} with {math.sqrt(np.nanmean(share)):.2g} times the error that R states"


def _finite(value: Any) -> bool:
    return isinstance(value, float | int | np.floating) and not isinstance(value, bool) and math.isfinite(value)
