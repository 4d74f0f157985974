"""The tables of a scenario file as parameter classes; values in SI, angles in radians."""

from __future__ import annotations

import math
import unicodedata
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from aircraft.air import FREEZING, QNH, STANDARD_PRESSURE, TEMPERATURE
from aircraft.ranges import ABOVE_ZERO, NOT_NEGATIVE, SINCE_BEGIN, Range, check_ranges, within
from aircraft.turbulence_intensity import INTENSITIES
from aircraft.wind_shear import EXPONENT, HIGHEST, LOWEST, ROUGHNESS, LogarithmicProfile, PowerProfile
from sim.scenario.axes import Axis, Sampled, axis

FASTEST = 1000.0  # m/s, of anything that flies an approach
HIGHEST_FLIGHT = 30_000.0  # m
STARTS = {"downwind": 0, "base": 1, "final": 2}  # phases of a pattern on which a flight can begin, and their legs
LARGEST_ERROR = 1000.0  # times that which a sensor states; beyond, it measures another thing
FARTHEST = 1e6  # m from the threshold; the local metric is long wrong there
STRONGEST = 100.0  # m/s, of a steady wind
LAG = Range(least=0.0, most=30.0)
LATITUDE = within(math.radians(85), "the local metric fails near a pole")
BANDWIDTHS = Range(above=0.0, most=2.0, why="it counts in bandwidths of the bank loop")
AIRSPEED = Range(least=1.0, most=FASTEST)  # of a leg that is flown
DECELERATION = Range(above=0.0, most=100.0)
HEIGHT = Range(above=0.0, most=HIGHEST_FLIGHT)
START_HEIGHT = Range(above=0.0, most=HIGHEST_FLIGHT, why="a flight starts above the ground, and below 30 km")
LENGTH = Range(above=0.0, most=FARTHEST)
PLACE = within(FARTHEST)
PROBABILITY = Range(above=0.0, below=1.0)


def _one_line(instance: Any, about: str, *names: str) -> None:
    """Refuse texts that would move the cursor of a terminal, or turn the writing round."""
    for name in names:
        if any(unicodedata.category(letter) in ("Cc", "Cf") for letter in getattr(instance, name) or ""):
            raise ValueError(f"the {name} of the {about} must be plain text on one line")


@dataclass(frozen=True)
class Runway:
    """Where the threshold is and how the runway lies; the frame in which sensors and legs are placed."""

    latitude: Annotated[float, "rad", LATITUDE] = math.radians(50.0)
    longitude: Annotated[float, "rad"] = math.radians(30.0)
    elevation: Annotated[float, "m", Range(least=-500.0, most=9000.0)] = 0.0
    heading: Annotated[float, "rad"] = 0.0
    glide_path: Annotated[float, "rad", Range(above=0.0, most=math.radians(10))] = math.radians(8.0 / 3.0)
    aiming_point: Annotated[float, "m", PLACE] = 300.0
    # where a touchdown is a landing, past the threshold and off the centreline [CS AWO.A.ALS.106, from memory]
    touchdown_from: Annotated[float, "m", PLACE] = 60.0
    touchdown_to: Annotated[float, "m", PLACE] = 823.0
    # also how far off a roll-out leaves the runway
    touchdown_aside: Annotated[float, "m", Range(least=1.0, most=FARTHEST)] = 21.0

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.touchdown_from < self.touchdown_to:
            raise ValueError("touchdown_from must lie before touchdown_to")

    def to_local(self, past_threshold: Any, right: Any) -> tuple[Any, Any]:
        """(north, east) of a point given along and to the right of the runway, m."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return past_threshold * c - right * s, past_threshold * s + right * c

    def from_local(self, north: Any, east: Any) -> tuple[Any, Any]:
        """(past threshold, right of the centreline) of a local point, m."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return north * c + east * s, east * c - north * s


@dataclass(frozen=True)
class AirTable:
    """The still air as it is measured at the runway; absent = the standard atmosphere."""

    temperature: Annotated[float | None, "degC", TEMPERATURE] = None  # at the threshold
    qnh: Annotated[float, "Pa", QNH] = STANDARD_PRESSURE

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def kelvin(self) -> float | None:
        """The temperature, K."""
        return None if self.temperature is None else self.temperature + FREEZING


@dataclass(frozen=True)
class AircraftChoice:
    """Which aircraft flies: a bundled or stock model by name, a folder, or ``point_mass``."""

    model: str = "point_mass"
    mass: Annotated[float | None, "kg", Range(above=0.0, most=1e6)] = None
    centre_of_gravity_mac: float | None = None
    factors: Annotated[dict[str, float], ABOVE_ZERO] = field(default_factory=dict)
    repairs: bool = False  # what waits for another simulator is mended, and told

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True)
class Start:
    """Where a flight begins: on a phase of the pattern or a leg, before its end, beside it."""

    phase: str | None = None
    leg: Annotated[int | None, NOT_NEGATIVE] = None
    distance: Annotated[float | None, "m", LENGTH] = None  # to go to the end of the leg; absent = the whole leg
    cross_track: Annotated[float, "m", PLACE] = 0.0
    # true airspeed; absent = the leg's
    speed: Annotated[float | None, "m/s", "indicated", Range(above=0.0, most=FASTEST)] = None
    height: Annotated[float | None, "m", START_HEIGHT] = None  # absent = the leg's
    course: Annotated[float | None, "rad"] = None  # over the ground, clockwise from north; absent = the leg's

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.phase is not None and self.leg is not None:
            raise ValueError("say 'phase' (pattern) or 'leg' (legs), not both")


@dataclass(frozen=True)
class PatternTable:
    """The landing pattern: downwind, base, final, glide path [Volovyk 2022, experiment]."""

    side: Literal["left", "right"] = "left"
    height: Annotated[float, "m", HEIGHT] = 400.0
    downwind_abeam: Annotated[float, "m", LENGTH] = 7000.0
    base_distance: Annotated[float, "m", LENGTH] = 13800.0  # before the aiming point
    downwind_speed: Annotated[float, "m/s", "indicated", AIRSPEED] = 72.0  # this and the next two are true airspeeds
    turn_speed: Annotated[float, "m/s", "indicated", AIRSPEED] = 69.0
    approach_speed: Annotated[float, "m/s", "indicated", AIRSPEED] = 58.0
    deceleration: Annotated[float, "m/s2", DECELERATION] = 0.5
    glide_deceleration: Annotated[float | None, "m/s2", DECELERATION] = None  # on the glide path; absent = the same

    final: ClassVar[int | None] = 2  # the leg that ends on the runway

    def __post_init__(self) -> None:
        check_ranges(self)

    @property
    def levels(self) -> tuple[tuple[str, float, float], ...]:
        """(where, true airspeed m/s, height m) of everything flown before the glide path."""
        return ("downwind", self.downwind_speed, self.height), ("the turn to final", self.turn_speed, self.height)


@dataclass(frozen=True)
class LegTable:
    """One straight leg between two points (north, east) from the threshold."""

    from_: Annotated[tuple[float, float], "m", PLACE]
    to: Annotated[tuple[float, float], "m", PLACE]
    speed: Annotated[float, "m/s", "indicated", AIRSPEED]  # true airspeed
    height: Annotated[float, "m", HEIGHT]

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.from_ == self.to:
            raise ValueError("a leg needs two different points")


@dataclass(frozen=True)
class LegsTable:
    """A route of straight legs."""

    legs: Annotated[tuple[LegTable, ...], "not empty"]

    final: ClassVar[int | None] = None  # no leg ends on the runway
    approach_speed: ClassVar[float | None] = None

    def __post_init__(self) -> None:
        if not self.legs:
            raise ValueError("a route needs at least one leg")
        for i, (before, after) in enumerate(zip(self.legs, self.legs[1:], strict=False)):
            if not np.allclose(before.to, after.from_, atol=1.0):
                raise ValueError(f"leg {i} ends {before.to}, leg {i + 1} begins {after.from_}: legs must join")

    @property
    def levels(self) -> tuple[tuple[str, float, float], ...]:
        """(where, true airspeed m/s, height m) of every leg."""
        return tuple((f"leg {number}", leg.speed, leg.height) for number, leg in enumerate(self.legs))


@dataclass(frozen=True)
class AutopilotTable:
    """The route autopilot: which law, its limits, and what it navigates on."""

    bank_limit: Annotated[float, "rad", Range(above=0.0, most=math.radians(60))] = math.radians(15.0)
    roll_rate_limit: Annotated[float, "rad/s", Range(above=0.0, most=math.radians(90))] = math.radians(5.0)
    navigation: str = "truth"
    # of the cross-track rate that it is flown on; the law tolerates twice it
    estimate_lag: Annotated[float, "s", LAG] = 0.0
    allow_orbit: bool = False
    # below it an approach that is not stabilised goes around
    gate_height: Annotated[float, "m", Range(least=0.0, most=1000.0)] = 300.0
    # natural frequency of the law over the bank loop's; absent = designed
    frequency_share: Annotated[float | None, BANDWIDTHS] = None
    # of the law inside its limits, instead of its k2
    damping: Annotated[float | None, Range(least=0.05, most=5.0)] = None
    # across the leg, k1 z_max / k2, instead of its z_max
    intercept_speed: Annotated[float | None, "m/s", AIRSPEED] = None
    # of the bank command behind the law's, beside the lag of the bank itself
    bank_lag: Annotated[float, "s", LAG] = 0.0

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.frequency_share is not None and self.estimate_lag > 0:
            raise ValueError("frequency_share sets the law outright: leave it out, or leave estimate_lag out")


TOWER = 10.0  # m above the ground, where wind is measured
TWENTY_FEET = 6.096  # m above the ground, where the wind that sets turbulence is told


@dataclass(frozen=True)
class WindTable:
    """Steady wind with its profile, Dryden turbulence, and single events.

    The wind is said by where it comes from and how fast, or by its components along and across the runway. The
    intensity of the turbulence does not depend on it unless it is "by_wind": then the mean wind at 20 ft is what the
    profile makes it there, which is what the specification means by it [MIL-F-8785C, 3.7.3].
    """

    from_: Annotated[float, "rad"] = 0.0
    speed: Annotated[float, "m/s", Range(least=0.0, most=STRONGEST)] = 0.0
    # instead of from and speed; + against the landing aircraft
    headwind: Annotated[float | None, "m/s", within(STRONGEST)] = None
    crosswind: Annotated[float | None, "m/s", within(STRONGEST)] = None  # + from its right
    turbulence: Literal["none", "light", "moderate", "severe", "by_wind"] = "none"
    w20: Annotated[float | None, "m/s", Range(above=0.0, most=50.0)] = None
    shear: Literal["none", "logarithmic", "power"] = "none"
    # where ``speed`` is measured; absent = 10 m
    reference_height: Annotated[float | None, "m", Range(least=LOWEST, most=HIGHEST)] = None
    roughness: Annotated[float | None, "m", ROUGHNESS] = None  # of the logarithmic profile
    exponent: Annotated[float | None, EXPONENT] = None  # of the power profile
    events: Annotated[dict[str, Any], "given"] = field(default_factory=dict)  # gusts and microbursts by name
    runway: Annotated[Runway, "given"] = field(default_factory=Runway)

    def __post_init__(self) -> None:
        check_ranges(self)
        if self._by_components and (self.speed != 0.0 or self.from_ != 0.0):
            raise ValueError("say 'from' and 'speed', or 'headwind' and 'crosswind', not both")
        if self.w20 is not None and self.turbulence != "none":
            raise ValueError("say 'turbulence' or 'w20_kt', not both")
        for name, shear in (("roughness", "logarithmic"), ("exponent", "power")):
            if getattr(self, name) is not None and self.shear != shear:
                raise ValueError(f'{name} belongs to shear = "{shear}"')
        if self.reference_height is not None and self.shear == "none":
            raise ValueError('reference_height belongs to a shear, "logarithmic" or "power"')

    @property
    def _by_components(self) -> bool:
        return self.headwind is not None or self.crosswind is not None

    @property
    def strength(self) -> float:
        """Speed, m/s, where it is measured, however it is said."""
        return math.hypot(*self.steady) if self._by_components else self.speed

    @property
    def steady(self) -> tuple[float, float]:
        """The way the air moves, m/s (north, east), where it is measured; without shear, everywhere."""
        if self._by_components:
            north, east = self.runway.to_local(-(self.headwind or 0.0), -(self.crosswind or 0.0))
            return float(north), float(east)
        return -self.speed * math.cos(self.from_), -self.speed * math.sin(self.from_)

    @property
    def profile(self) -> LogarithmicProfile | PowerProfile | None:
        """How the speed grows with height."""
        if self.shear == "logarithmic":
            return LogarithmicProfile() if self.roughness is None else LogarithmicProfile(self.roughness)
        if self.shear == "power":
            return PowerProfile() if self.exponent is None else PowerProfile(self.exponent)
        return None

    @property
    def tower(self) -> float:
        """Height, m, where the wind is measured."""
        return TOWER if self.reference_height is None else self.reference_height

    def at(self, height: float) -> tuple[float, float]:
        """The way the air moves without turbulence and events at a height, m/s (north, east)."""
        north, east = self.steady
        share = 1.0 if self.profile is None else self.profile.share(height, self.tower)
        return share * north, share * east

    @property
    def intensity(self) -> float:
        """Mean wind at 20 ft that sets the turbulence, m/s; 0 = smooth air."""
        if self.turbulence == "by_wind":
            return math.hypot(*self.at(TWENTY_FEET))
        return self.w20 if self.w20 is not None else INTENSITIES.get(self.turbulence, 0.0)


@dataclass(frozen=True)
class Check:
    """What every flight must keep: a metric, when, how long it may be broken, its limit and where that comes from.

    With ``share`` and ``confidence`` a share of flights must keep it, shown with a one-sided confidence;
    ``probability_max`` says the share that may break it.
    """

    metric: str
    name: str | None = None
    during: str | tuple[str, ...] = "all"
    statistic: Literal["max", "mean_5_s", "rms", "p95"] = "max"
    for_: Annotated[float, "s", NOT_NEGATIVE] = 0.0
    max: float | None = None  # in the metric's own suffix
    min: float | None = None
    share: Annotated[float | None, PROBABILITY] = None  # of the flights, at least; absent = every flight
    confidence: Annotated[float | None, PROBABILITY] = None  # one-sided
    probability_max: Annotated[float | None, PROBABILITY] = None  # that a flight breaks it: 1 less the share
    source: str = ""

    def __post_init__(self) -> None:
        _one_line(self, f"check of '{self.metric}'", "name", "source")
        check_ranges(self)
        if self.share is not None and self.probability_max is not None:
            raise ValueError(f"the check of '{self.metric}' has 'share' and 'probability_max': say one of them")
        if self.confidence is None and self.required_share is not None:
            named = "share" if self.share is not None else "probability_max"
            raise ValueError(f"the check of '{self.metric}' has a {named} and no confidence: say one, such as 0.9")
        if self.confidence is not None and self.required_share is None:
            raise ValueError(
                f"the check of '{self.metric}' has a confidence and no share: say share = 0.95, or another"
            )
        if not self.during:
            raise ValueError(f"the check of '{self.metric}' has an empty 'during': name a phase, or leave it out")
        if self.max is None and self.min is None:
            raise ValueError(f"the check of '{self.metric}' needs 'max' or 'min'")
        if self.max is not None and self.min is not None and self.max < self.min:
            raise ValueError(f"the check of '{self.metric}' has max below min")

    @property
    def required_share(self) -> float | None:
        """The share of flights that must keep it; None = every flight."""
        return self.share if self.probability_max is None else 1.0 - self.probability_max


@dataclass(frozen=True)
class Contrast:
    """Two trackers that are set against each other: by how much the errors of one exceed those of the other."""

    of: str
    against: str
    name: str | None = None  # a label, such as "each at its best"

    def __post_init__(self) -> None:
        _one_line(self, f"contrast of '{self.of}'", "name")
        if self.of == self.against:
            raise ValueError(f"a contrast needs two trackers, and '{self.of}' is one: give the other its own name")

    @property
    def pair(self) -> str:
        """What checks call it."""
        return f"{self.of}/{self.against}"


@dataclass(frozen=True)
class Departure:
    """From a time on the bank follows something else than the law of the autopilot, and no tracker knows.

    ``flies``: the "beacon" law, the "route" law (again) or that of any mode by its kind, a "bank" that is held by hand,
    or the law of the autopilot about a line beside the leg ("offset").
    """

    at: Annotated[float, "s", SINCE_BEGIN]
    flies: str
    bank: Annotated[float | None, "rad", within(math.radians(60))] = None  # + right
    offset: Annotated[float | None, "m"] = None  # + right of the leg

    def __post_init__(self) -> None:
        check_ranges(self)
        for name in ("bank", "offset"):
            if (getattr(self, name) is not None) != (self.flies == name):
                raise ValueError(f'{name} belongs to flies = "{name}", and to nothing else')


@dataclass(frozen=True)
class SensorFault:
    """From a time on a sensor errs more, or less, than it states, and no tracker knows.

    Its error is ``error_factor`` times what it would have been, so that its variance is the square of that times R.
    Of the entries of a sensor the last whose time has come counts; a factor of 1 ends the fault.
    """

    at: Annotated[float, "s", SINCE_BEGIN]
    sensor: str
    error_factor: Annotated[float, Range(above=0.0, most=LARGEST_ERROR)]

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True)
class StudyTable:
    """What a study varies, and how many samples it draws of what is distributed; without axes, of the air alone."""

    axes: dict[str, Any] | None = None  # absent = nothing is varied: every sample is one more flight
    samples: Annotated[int, Range(least=1)] = 1
    show: tuple[str, ...] = ()  # what the report draws; absent = figures of checks, or the usual ones, and of trackers
    theory: Literal["orbit", "energy", "gain", "limits"] | None = None  # what maps draw before they are flown

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.axes is not None and not self.axes:
            raise ValueError("axes are empty: a study varies at least one value, or has no axes and samples alone")
        drawn = [one for one in self.varied if isinstance(one, Sampled)]
        if self.samples > 1 and self.axes and not drawn:
            raise ValueError("samples are drawn from distributions, and no axis is one; take 'samples' out")
        sobol = any(one.distribution == "sobol" for one in drawn)
        if sobol and self.samples & (self.samples - 1):
            below = 1 << (self.samples.bit_length() - 1)
            raise ValueError(f"samples of sobol axes must be a power of two: {below} or {2 * below}")

    @property
    def varied(self) -> tuple[Axis, ...]:
        """The axes, in the order of the file."""
        return tuple(axis(address, given) for address, given in (self.axes or {}).items())
