"""Glistin, Panasyuk: load factors from the aircraft against a tuned azimuth filter without them."""

from __future__ import annotations

from typing import Final

from sim.claims.ledger import Claim, Reading, flown_too
from sim.claims.papers.glistin.cases import AXES, BIASED, CONDITIONS, FLIGHTS, JSBSIM, LATE
from sim.claims.papers.glistin.experiment import gained, gained_still, more_in_the_turn
from sim.claims.verdict import above

CASES = [(flight, condition) for flight in FLIGHTS for condition in CONDITIONS]
TURNS = [(flight, condition) for flight, condition in CASES if flight != "near pass"]
FLOWN_CASES = [(JSBSIM, condition) for condition in CONDITIONS]
PARTS = {"turn": "turn", "before": "straight before", "behind": "straight behind", "all": "whole flight"}
ORDER = above(1.0)
OURS: Final = "ours"
MOST = 800  # runs; the filters take a millisecond and a half for every scan
TUNED = "Both filters tuned for each case, on another seed, until no neighbouring set of parameters is better."
TURNS_WITH_X = (
    "The formula squares the sum of two components, so it depends on where the axes point, and nothing printed says "
    "where. X lies along the final leg, or so many degrees to its right, tuned for each; 180 deg on it is the same."
)
FLOWN = "Turns onto final that the An-26 flies on JSBSim, in steady winds of up to 10 m/s from anywhere."


def cases(kind: str, chosen: list[tuple[str, str]], parts: tuple[str, ...] = ("turn",)) -> tuple[Reading, ...]:
    """A reading for each flight, condition and part."""
    return tuple(
        Reading(f"{flight}, {condition}, {PARTS[part]}", gained(kind, flight, condition, part))
        for flight, condition in chosen
        for part in parts
    )


def directions(flight: str) -> tuple[Reading, ...]:
    """A reading of the turn for each further direction of the axis X and each condition."""
    return tuple(
        Reading(f"{flight}, {condition}, turn, {kind.removeprefix('published, ')}", gained(kind, flight, condition))
        for condition in CONDITIONS
        for kind in AXES
    )


def more(kinds: tuple[str, ...], chosen: list[tuple[str, str]]) -> tuple[Reading, ...]:
    """A reading for each formula, flight, condition and straight that the turn is compared with."""
    return tuple(
        Reading(f"{kind}, {flight}, {condition}, over the straight {beside}", more_in_the_turn(*what, beside))
        for kind in kinds
        for flight, condition in chosen
        for beside in ("before", "behind")
        for what in ((kind, flight, condition),)
    )


CLAIMS: tuple[Claim, ...] = (
    *flown_too(
        Claim(
            "smaller_error",
            "azimuth error is smaller than without the load factors",
            "fig. 1",
            ORDER,
            (*cases("published", CASES, tuple(PARTS)), *directions("base turn")),
            "times",
            truth="kinematic",
            geometry_by=OURS,
            most_runs=MOST,
            note=f"The formula as published. {TURNS_WITH_X} {TUNED}",
        ),
        (*cases("published", FLOWN_CASES, tuple(PARTS)), *directions(JSBSIM)),
        f"The formula as published. {TURNS_WITH_X} {FLOWN} {TUNED}",
    ),
    *flown_too(
        Claim(
            "smaller_error_corrected",
            "azimuth error is smaller than without the load factors, formula corrected",
            "fig. 1",
            ORDER,
            cases("corrected", TURNS),
            "times",
            truth="kinematic",
            geometry_by=OURS,
            most_runs=MOST,
            note="With the printed step of delay.",
        ),
        cases("corrected", FLOWN_CASES, tuple(PARTS)),
        FLOWN,
    ),
    *flown_too(
        Claim(
            "smaller_error_corrected_residual",
            "azimuth error is smaller than without the load factors, corrected and with a residual of its own",
            "fig. 1",
            ORDER,
            cases("corrected_residual", TURNS),
            "times",
            truth="kinematic",
            geometry_by=OURS,
            most_runs=MOST,
            note="The residual is ours.",
        ),
        cases("corrected_residual", FLOWN_CASES, tuple(PARTS)),
        f"{FLOWN} Wind-axis load factors and air-path angles carry over to the aircraft without loss.",
    ),
    *flown_too(
        Claim(
            "most_in_manoeuvre",
            "above all in a manoeuvre",
            "fig. 1",
            ORDER,
            more(("published", "corrected"), TURNS),
            "times",
            truth="kinematic",
            geometry_by=OURS,
            most_runs=MOST,
            note="Gain in the turn over the gain beside it.",
        ),
        more(("published", "corrected"), FLOWN_CASES),
        FLOWN,
    ),
    Claim("airspace_capacity", "higher capacity of the airspace", "conclusions", None, (), note="No traffic is flown."),
    Claim(
        "latency",
        "gain in the turn with a downlink that is late, corrected and with a residual",
        "not said",
        None,
        tuple(
            Reading(f"{flight}, {late:g} s late", gained_still(flight, spoil))
            for flight in ("base turn", "S-turn")
            for late, spoil in LATE.items()
        ),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        most_runs=MOST,
        overlooked=True,
        note="Below 1 the filter is better off without the downlink.",
    ),
    Claim(
        "bias",
        "gain with a biased downlink, corrected and with a residual, base turn",
        "not said",
        None,
        tuple(
            Reading(f"{text}, {PARTS[part]}", gained_still("base turn", bias, part))
            for text, bias in BIASED.items()
            for part in ("turn", "before", "behind")
        ),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        most_runs=MOST,
        overlooked=True,
        note="Below 1 the filter is better off without the downlink; the tuning does not know of the bias.",
    ),
)
