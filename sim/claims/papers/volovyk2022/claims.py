"""Volovyk 2022: interacting multiple models in the azimuth channel of a precision approach radar."""

from __future__ import annotations

from typing import Final

from sim.claims.ledger import MOST_RUNS, Claim, Reading, flown_too
from sim.claims.papers.volovyk2022.experiment import (
    DELAYS,
    DENSER,
    DENSITY,
    IMPROVED,
    PAPER_RUNS,
    SMALLEST,
    STRETCHES,
    after_delay,
    delays,
    entry_gains,
    gains,
    grows,
    grows_throughout,
    norm_over,
    right_belief,
    share_of_the_scan,
    spared,
    within_norm,
)
from sim.claims.papers.volovyk2022.landing_paths import ENTRIES, JSBSIM, JSBSIM_RIGHT, LEFT, RIGHT
from sim.claims.verdict import above, at_most, between

OURS: Final = "ours"
FLOWN = "One JSBSim landing pattern in still air; runs are draws of noise."
BELIEFS = ("turn onto final", "base", "final before the glide path", "glide path")
READ = (
    (DENSITY, "azimuth", "glide path"),
    (DENSITY, "position", "glide path"),
    ("Q of B diag(.01) B'", "azimuth", "glide path"),
    ("Q of B diag(.01) B'", "position", "glide path"),
    ("Q .01 I", "azimuth", "glide path"),
    ("Q .01 I", "position", "glide path"),
    (DENSITY, "azimuth", "all"),
    (DENSITY, "position", "all"),
    (DENSITY, "position", "base"),
    (DENSITY, "position", "turn onto final"),
    (DENSITY, "position", "final before the glide path"),
)


def towards_touchdown(truth: str) -> tuple[Reading, ...]:
    """Every way to understand the growth: unit, origin of the distance, process noise, everywhere or in the end."""
    units = (("in metres", "position"), ("in degrees", "azimuth"))
    origins = (("from the radar", "radar"), ("from the aiming point", "aiming point"))
    sets = (("", DENSITY), (", density .3", DENSER)) if truth == LEFT else (("", DENSITY),)
    ends = tuple(
        Reading(f"{unit}, {place}{noise}", grows(name, what, origin, truth))
        for noise, name in sets
        for unit, what in units
        for place, origin in origins
    )
    return ends + tuple(
        Reading(f"{unit}, from each stretch to the next{noise}", grows_throughout(name, what, truth))
        for noise, name in sets
        for unit, what in units
    )


CLAIMS: tuple[Claim, ...] = (
    *flown_too(
        Claim(
            "accuracy_gain",
            "position or azimuth 1.3-1.5 times more accurate than without the filter",
            "conclusions, fig. 4",
            between("1.3", "1.5", good=1),
            (
                *(Reading(f"{what}, {leg}, {name}", gains(name, what, leg)) for name, what, leg in READ),
                Reading(f"norm of Annex 10 over the filter, glide path, {DENSITY}", norm_over(DENSITY)),
            ),
            "times",
            truth="kinematic",
            geometry_by=OURS,
            paper_runs=PAPER_RUNS,
            first_runs=SMALLEST,
            note="The low gain on the glide path comes from the deceleration that no model of the paper has.",
        ),
        (
            *(
                Reading(f"{what}, {leg}, {name}", gains(name, what, leg, JSBSIM))
                for name, what, leg in READ
                if name == DENSITY
            ),
            Reading(f"norm of Annex 10 over the filter, glide path, {DENSITY}", norm_over(DENSITY, JSBSIM)),
        ),
        f"{FLOWN} The An-26 slows down before the glide path and on it, and no model of the paper does.",
        first_runs=50,
    ),
    *flown_too(
        Claim(
            "grows_towards_touchdown",
            "accuracy grows towards touchdown",
            "fig. 4, conclusions",
            above(1.0),
            towards_touchdown(LEFT),
            "times",
            truth="kinematic",
            geometry_by=OURS,
            paper_runs=PAPER_RUNS,
            first_runs=SMALLEST,
            most_runs=1040,
            note="RMSE at 6-8 km over that at 0.9-1.5 km, or on a stretch of the way over that on the next.",
        ),
        towards_touchdown(JSBSIM),
        FLOWN,
        paper_runs=None,
        first_runs=50,
        most_runs=MOST_RUNS,
    ),
    *flown_too(
        Claim(
            "turn_adaptation",
            "the model probabilities follow the turn correctly",
            "fig. 2",
            above(0.5),
            (
                *(Reading(f"mean probability of what is flown, {leg}", right_belief(leg)) for leg in BELIEFS),
                Reading("runs without a false turn in the 35 s after the glide path begins", spared(DENSITY)),
            ),
            truth="kinematic",
            geometry_by=OURS,
            paper_runs=1,
            first_runs=SMALLEST,
        ),
        (
            *(Reading(f"mean probability of what is flown, {leg}", right_belief(leg, JSBSIM)) for leg in BELIEFS),
            Reading("runs without a false turn in the 35 s after the glide path begins", spared(DENSITY, JSBSIM)),
        ),
        FLOWN,
        paper_runs=None,
        first_runs=50,
    ),
    Claim(
        "cheap",
        "computing effort is small",
        "conclusions",
        at_most(1.0),
        (Reading("wall time of a scan is below", share_of_the_scan),),
        "of the time between scans",
        truth="kinematic",
        geometry_by=OURS,
        note="No limit is printed; judged by whether it keeps up with the radar, on the machine at hand.",
    ),
    *flown_too(
        Claim(
            "any_trajectory",
            "works for an entry from any direction",
            "conclusions",
            above(1.0),
            tuple(Reading(f"{side}, turn onto final {turn} deg", entry_gains(side, turn)) for side, turn in ENTRIES),
            "times",
            truth="kinematic",
            geometry_by=OURS,
            first_runs=SMALLEST,
            note="Only left turns are modelled. 150 and 180 deg are a turn onto the base leg and one of 90 deg.",
        ),
        (
            Reading("left, turn onto final 90 deg", gains(DENSITY, "position", "all", JSBSIM)),
            Reading("right, turn onto final 90 deg", gains(DENSITY, "position", "all", JSBSIM_RIGHT)),
        ),
        "One JSBSim landing pattern on either hand. Only left turns are modelled.",
        first_runs=50,
    ),
    *flown_too(
        Claim(
            "less_delay",
            "manoeuvres are detected with less delay",
            "abstract",
            above(1.0),
            (
                Reading("an innovation detector on a Kalman filter, density .01", delays(0.01)),
                Reading("an innovation detector on a Kalman filter, density 3", delays(3.0)),
            ),
            "times less delay",
            truth="kinematic",
            geometry_by=OURS,
            first_runs=SMALLEST,
            note="The paper does not say less than what: window 5 scans, one false alarm in 1000 scans.",
        ),
        (
            Reading("an innovation detector on a Kalman filter, density .01", delays(0.01, JSBSIM)),
            Reading("an innovation detector on a Kalman filter, density 3", delays(3.0, JSBSIM)),
        ),
        FLOWN,
        first_runs=50,
    ),
    Claim(
        "one_model_more",
        "gain with a model of the deceleration and turns to either side",
        "not said",
        None,
        (
            Reading("glide path", gains(IMPROVED, "position", "glide path")),
            Reading("all", gains(IMPROVED, "position", "all")),
            Reading("all, right-hand", gains(IMPROVED, "position", "all", RIGHT)),
            Reading("published set with density .3, all", gains(DENSER, "position", "all")),
            Reading("all, flown on JSBSim", gains(IMPROVED, "position", "all", JSBSIM)),
        ),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=SMALLEST,
        overlooked=True,
    ),
    Claim(
        "annex_10_norm",
        "scans within the norm of Annex 10 for the azimuth, which asks for 95 %",
        "conclusions",
        None,
        tuple(
            Reading(f"{text}, {far / 1e3:g} to {near / 1e3:g} km to go", within_norm(name, far, near, truth))
            for text, name, truth in (
                ("published set", DENSITY, LEFT),
                ("density .3", DENSER, LEFT),
                ("improved set", IMPROVED, LEFT),
                ("improved set on JSBSim", IMPROVED, JSBSIM),
            )
            for far, near in STRETCHES
        ),
        "%",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=SMALLEST,
        most_runs=520,
        overlooked=True,
        note="0.6 % of the distance from the antenna and a tenth of the deviation, or 9 m: 1 deg is three times it.",
    ),
    Claim(
        "accuracy_against_delay",
        "gain in the turn onto final for who can wait",
        "not said",
        None,
        tuple(Reading(f"{delay:g} s later", after_delay(delay)) for delay in DELAYS),
        "times",
        truth="kinematic",
        geometry_by=OURS,
        first_runs=SMALLEST,
        overlooked=True,
        note="A Kalman filter of density 3 with a fixed-lag smoother.",
    ),
)
