"""What a mode is: the control law that turns a deviation from the route into a bank command, and all that it says of
itself, so that one file in ``autopilot/modes`` is flown, tracked, explained and drawn, and nothing else knows its name.

A mode is a frozen dataclass whose fields are its parameters; ``[autopilot.law]`` of a scenario sets them under their
names, with the units of their annotations. It is pure: rate limit and bank lag are states of what uses the law. The
same text serves the autopilot, with floats, and the trackers that predict the aircraft, with arrays of many hypotheses.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from autopilot.route import ArrayDeviation, PathDeviation
from autopilot.saturation import saturate

RATE_MARGIN = 1.1  # of the limit of the cross-track rate over what the turn between two legs needs


class DesignCase(NamedTuple):
    """What a law is designed for: the aircraft by its bank loop, the route by its speed, and the bank that is allowed.

    The gains are those of the route law that bank loop and bank limit allow; a mode of another form takes its stiffness
    and damping from them, or its own from ``bank_bandwidth``.
    """

    bank_limit: float  # rad
    bank_bandwidth: float  # rad/s, of the loop that follows the command
    speed: float  # m/s, of the fastest leg
    k1: float  # rad/m, bank per cross-track
    k2: float  # rad/(m/s), bank per cross-track rate
    cross_track_limit: float  # m, beyond which the cross-track counts no more: intercepts at 30 degrees

    @property
    def cross_track_rate_limit(self) -> float:
        """m/s, beyond which the rate counts no more: it leaves the whole bank to the turn between two legs."""
        return RATE_MARGIN * (self.k1 * self.cross_track_limit + self.bank_limit) / self.k2


class LimitedInput(NamedTuple):
    """One deviation that a law looks at: what it does with it, and from where on it counts no more."""

    of: str  # a field of PathDeviation
    gain: Any = math.nan  # in bank = c{-sum of gain c_i{input}}; NaN where the law is no such sum
    limit: Any = math.inf  # SI
    blind: float = -math.inf  # m to go, from which on the law looks no more


class Mode(Protocol):
    """A control law of the autopilot. `broken_promises` tries whether a class is one.

    A class must have ``bank_limit`` and ``__call__``. What else it leaves out is as `DEFAULTS` says: a law of its own,
    not standard, without limits that could be drawn or identified, built field by field from what the file sets, else
    from the defaults of the class, else from what `DesignCase` has under the same name.
    """

    intent: ClassVar[str]
    """What those who watch call it, in words, such as "route law": distinct from that of every other mode."""

    standard: ClassVar[bool]
    """Whether the autopilot always has it, so that a crew may switch to it at any time: a tracker of intents then
    weighs it beside its assumed law. A mode that is not standard changes no scenario but those that fly it."""

    intercept: ClassVar[tuple[str, ...]]
    """Fields that set the course of a far intercept: first the limit itself, then those that have to grow with it for
    the wider law to converge. Empty = the law knows no such limit, and trackers that identify it refuse the law."""

    @property
    def bank_limit(self) -> Any:
        """Largest bank command, rad; a field of the class, so that it can be replaced. Turns of the route are flown at
        it."""
        ...

    @classmethod
    def designed(cls, given: dict[str, Any], case: DesignCase) -> Self:
        """The law with the fields that the file sets (by name, SI), and by its own recipe where the file is silent.

        Raises ``ValueError``, in a sentence, for values that make no law. Where the recipe is published, the first
        paragraph of its docstring ends in the source, which the report then names.
        """
        ...

    def __call__(self, deviation: Any) -> Any:
        """Bank command, rad, + right, never beyond the limit.

        ``deviation`` has the fields of ``autopilot.route.PathDeviation`` as attributes, floats or arrays of one shape;
        the fields of the law may be arrays that broadcast with them.
        """
        ...

    def limits(self) -> tuple[LimitedInput, ...]:
        """The deviations that it looks at, in order: portraits draw the first two, histories when each is limited.

        Empty = nothing of the kind can be said; the flight is then drawn over cross-track and its rate, without
        regions.
        """
        ...

    def explain(self) -> str:
        """What it does, in one or more sentences with the equation, the gains and the limits, in units of pages."""
        ...

    def check_convergence(self, ground_speed: float, offset: float = math.inf, turns: bool = False) -> None:
        """Raise ``ValueError``, in a sentence, where the aircraft would never reach its leg; a law that has nothing to
        check does nothing.

        Parameters
        ----------
        ground_speed : m/s, the least that the wind allows
        offset : m, the largest distance from which a leg is approached
        turns : whether the law flies turns between legs
        """
        ...


def _designed(cls: Any, given: dict[str, Any], case: DesignCase) -> Any:
    """The law field by field: from the file, else by its default, else from the case under the same name.

    The bank limit is the autopilot's, whatever the class says.
    """
    of_case = {name: getattr(case, name) for name in (*DesignCase._fields, "cross_track_rate_limit")}
    values = {"bank_limit": case.bank_limit, **given}
    for field in dataclasses.fields(cls):
        has_default = field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING
        if field.name in values or has_default:
            continue
        if field.name not in of_case:
            raise ValueError(f"'{field.name}' has no value: set it in [autopilot.law], or give the class a default")
        values[field.name] = of_case[field.name]
    return cls(**values)


def _no_limits(law: Any) -> tuple[LimitedInput, ...]:
    """Nothing can be said."""
    return ()


def _explained(law: Any) -> str:
    """Its parameters."""
    values = {field.name.rstrip("_"): getattr(law, field.name) for field in dataclasses.fields(law)}
    said = ", ".join(f"{name} {v:.4g}" if isinstance(v, float) else f"{name} {v}" for name, v in values.items())
    return f"a law of its own; in SI: {said}"


def _not_checked(law: Any, ground_speed: float, offset: float = math.inf, turns: bool = False) -> None:
    """Nothing is known of where it converges."""


DEFAULTS: dict[str, Any] = {  # members that a class may leave out, and what they then are
    "intent": "own law",
    "standard": False,
    "intercept": (),
    "designed": classmethod(_designed),
    "limits": _no_limits,
    "explain": _explained,
    "check_convergence": _not_checked,
}
FACTS = {"intent": str, "standard": bool, "intercept": tuple}
MEMBERS = ("bank_limit", "__call__")  # that a class must have


def missing(cls: type) -> list[str]:
    """Members of a mode that a class lacks."""
    fields = {field.name for field in dataclasses.fields(cls)} if dataclasses.is_dataclass(cls) else set()
    own = {name for base in cls.__mro__ for name, member in vars(base).items() if member is not None}
    return [name for name in MEMBERS if name not in fields | own]


TRIAL = DesignCase(math.radians(15.0), 2.0, 72.0, 1.3e-3, 0.021, 580.0)  # a small transport's
ALLOWED = 1e-9  # of rounding, relative


def broken_promises(cls: Any, make: Callable[[], Any] | None = None) -> list[str]:
    """What a class breaks of the contract of a mode, in sentences; empty = it is one.

    ``make`` gives the instance that is tried: the law as designed for `TRIAL`, with nothing set, where it is not given.
    """
    if not isinstance(cls, type) or not dataclasses.is_dataclass(cls):
        return ["a mode is a class that is a frozen dataclass"]
    lacking = missing(cls)
    if lacking:
        asked = {name: inspect.getdoc(getattr(Mode, name)) or "" for name in lacking}
        return [f"it has no '{name}': {text.splitlines()[0]}" for name, text in asked.items()]
    broken = [
        f"{name}: must be a {kind.__name__}, not {getattr(cls, name)!r}"
        for name, kind in FACTS.items()
        if not isinstance(getattr(cls, name), kind)
    ]
    try:
        mode: Any = cls
        law = mode.designed({}, TRIAL) if make is None else make()
        dataclasses.replace(law)
    except Exception as error:
        return [*broken, f"designed: fails with nothing set: {_named(error)}"]
    if not isinstance(law, cls):
        return [*broken, f"designed: gives a {type(law).__name__}, not a {cls.__name__}"]
    for promise in (_frozen, _bank, _arrays, _bank_limit, _intercept, _limits, _explain, _convergence):
        name = promise.__doc__ or ""
        try:
            broken += [f"{name}: {sentence}" for sentence in promise(law)]
        except Exception as error:
            broken.append(f"{name}: fails: {_named(error)}")
    return broken


def _named(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _frozen(law: Any) -> Iterator[str]:
    """dataclass"""
    try:
        object.__getattribute__(law, "__setattr__")("bank_limit", law.bank_limit)
    except dataclasses.FrozenInstanceError:
        return
    yield "must be frozen: say @dataclass(frozen=True)"


def _points(shape: tuple[int, ...] = (240,)) -> ArrayDeviation:
    """Deviations from everywhere: near and far, on every course, before and behind the end of the leg, and none."""
    count = math.prod(shape)
    spread = np.modf(np.outer(np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0]), np.arange(count)))[0].reshape(5, *shape)
    centred = 2.0 * spread - 1.0  # of a Weyl sequence: the first point is none
    centred[:, (0,) * len(shape)] = 0.0
    cross_track = 9e3 * centred[0] ** 3
    speed, course = 45.0 + 60.0 * spread[1], math.pi * centred[2] ** 3
    return ArrayDeviation(
        cross_track, speed * np.sin(course), 14e3 + 16e3 * centred[3], speed * np.cos(course), course + 0.3 * centred[4]
    )


def _one(points: ArrayDeviation, index: int) -> PathDeviation:
    """One of them, as the autopilot gives it."""
    return PathDeviation(*(float(getattr(points, name)[index]) for name in PathDeviation._fields))


def _bank(law: Any) -> Iterator[str]:
    """__call__"""
    points = _points()
    each = [_one(points, index) for index in range(len(points.cross_track))]
    banks = [law(deviation) for deviation in each]
    wrong = next((bank for bank in banks if np.shape(bank) != () or not math.isfinite(bank)), None)
    if wrong is not None:
        yield f"must give one finite number for a deviation of floats, not {wrong!r}"
        return
    largest = max(abs(float(bank)) for bank in banks)
    if largest > law.bank_limit * (1.0 + ALLOWED):
        yield f"commands {largest:.3g} rad where bank_limit is {law.bank_limit:.3g} rad"
    if [law(deviation) for deviation in each] != banks:
        yield "gives another bank for the same deviation: it must remember nothing"


def _arrays(law: Any) -> Iterator[str]:
    """__call__"""
    points = _points()
    before = {name: np.array(getattr(points, name)) for name in PathDeviation._fields}
    banks = np.asarray(law(points))
    if banks.shape != points.cross_track.shape:
        yield f"gives the shape {banks.shape} for deviations of the shape {points.cross_track.shape}"
        return
    if any((getattr(points, name) != array).any() for name, array in before.items()):
        yield "changes the deviation that it is given"
    one_by_one = np.array([float(law(_one(points, index))) for index in range(len(banks))])
    if not np.allclose(banks, one_by_one, rtol=ALLOWED, atol=ALLOWED):
        yield "gives other banks for arrays than for each of their deviations alone"
    square = (12, 20)
    if np.shape(law(_points(square))) != square:
        yield "fails for arrays of two axes, hypotheses by runs"


def _bank_limit(law: Any) -> Iterator[str]:
    """bank_limit"""
    if "bank_limit" not in {field.name for field in dataclasses.fields(law)}:
        yield "must be a field of the class, so that it can be replaced"
        return
    if np.shape(law.bank_limit) != () or not 0.0 < law.bank_limit < math.inf:
        yield f"must be one positive number, not {law.bank_limit!r}"
        return
    half = 0.5 * law.bank_limit
    if np.max(np.abs(dataclasses.replace(law, bank_limit=half)(_points()))) > half * (1.0 + ALLOWED):
        yield "is not obeyed once it is replaced by half of it"


def _intercept(law: Any) -> Iterator[str]:
    """intercept"""
    fields = {field.name for field in dataclasses.fields(law)}
    for name in law.intercept:
        if name not in fields:
            yield f"names '{name}', which is no field"
            return
    if not law.intercept:
        return
    several = np.array([0.5, 1.0, 2.0])[:, None]
    wide = dataclasses.replace(law, **{name: getattr(law, name) * several for name in law.intercept})
    found = np.asarray(wide(_points((3, 80))))
    if found.shape != (3, 80):
        yield f"limits as an array of hypotheses give banks of the shape {found.shape}, not (3, 80)"


def _limits(law: Any) -> Iterator[str]:
    """limits"""
    inputs = law.limits()
    for one in inputs:
        if one.of not in PathDeviation._fields:
            yield f"names '{one.of}', which is no field of PathDeviation"
            return
        if not one.limit > 0.0:
            yield f"the limit of {one.of} must be positive, not {one.limit}"
    if not inputs or not all(math.isfinite(one.gain) for one in inputs):
        return
    points = _points()
    described = sum(
        -one.gain * saturate(getattr(points, one.of), one.limit) * (points.distance_to_go > one.blind) for one in inputs
    )
    if not np.allclose(law(points), saturate(described, law.bank_limit), rtol=1e-6, atol=1e-9):
        yield "gains and limits do not give the bank that the law commands; leave the gains out where it is no such sum"


def _explain(law: Any) -> Iterator[str]:
    """explain"""
    text = law.explain()
    if not isinstance(text, str) or not text.strip():
        yield f"must give a text, not {text!r}"
    elif text != text.strip() or not all(line.isprintable() for line in text.split("\n")):
        yield "must give lines of printable text without blanks at its ends"


def _convergence(law: Any) -> Iterator[str]:
    """check_convergence"""
    for ground_speed in (0.0, 20.0, 70.0):
        for offset in (100.0, math.inf):
            try:
                answer = law.check_convergence(ground_speed, offset, turns=True)
            except ValueError as error:
                if not str(error):
                    yield "must say in its ValueError why the law does not converge"
                continue
            if answer is not None:
                yield f"must give nothing, or raise ValueError, not give {answer!r}"
                return
