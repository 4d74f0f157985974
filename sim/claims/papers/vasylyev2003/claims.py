"""Vasylyev 2003: linear feedback inside the filter against a saturated control outside it, on one captured line."""

from __future__ import annotations

from functools import partial
from typing import Final

from sim.claims.ledger import OVER_FLIGHTS, Claim, Reading, counted, flown_too
from sim.claims.papers.vasylyev2003 import approaches
from sim.claims.papers.vasylyev2003.approaches import AIRCRAFT, POINT_MASS, TURNS
from sim.claims.papers.vasylyev2003.beacon import CROSSWIND, HEADING, LIMITED, TRACK, UNLIMITED, homed, homed_flown
from sim.claims.papers.vasylyev2003.experiment import (
    DELAYS,
    DENSITY,
    FAR,
    GIVEN_GAINS,
    INSIDE,
    MODEL,
    NOISES,
    OUTSIDE,
    OWN_GAINS,
    WRONG,
    after_delay,
    better_ahead,
    crossover,
    difference_flown,
    inverse,
    largest_difference,
    limits_over_none,
    linear_over_saturated,
    linear_over_saturated_flown,
    looked_ahead,
    lost_more,
    lost_share,
    outside_over_inside,
    told,
)
from sim.claims.verdict import above
from tracking.intervals import rmse

OURS: Final = "ours"
GAINS = {"the gains of the model": GIVEN_GAINS, "gains of the aircraft": OWN_GAINS}
FLOWN = (
    "JSBSim flights from 4 to 6 km beside the line in steady winds of up to 10 m/s, 20 draws of noise in each; the "
    "interval is over flights."
)
PATTERNS = (
    "Landing patterns from within 300 m of the downwind leg in steady winds of up to 10 m/s, which the chart shows, 20 "
    "draws of noise in each; the interval is over flights. A turn is taken with the leg that it leads onto."
)


def in_turns(aircraft: str) -> tuple[Reading, ...]:
    """Errors of linear feedback in the turns, beside those of saturated control and beside its own before them."""
    return tuple(
        Reading(f"{text}, over {beside}", measure(aircraft, phases))
        for beside, measure in (
            ("saturated control there", approaches.linear_over_saturated),
            ("the straight before", approaches.turn_over_straight),
        )
        for text, phases in TURNS.items()
    )


def lost_in_turns(aircraft: str) -> tuple[Reading, ...]:
    """Share of the runs that linear feedback loses in the turns, less what it is set beside."""
    return tuple(
        Reading(f"{text}, more than {words}", approaches.lost_more(aircraft, phases, beside))
        for words, beside in (
            ("saturated control there", "saturated"),
            ("on the straight before all turns", "straight"),
        )
        for text, phases in TURNS.items()
    )


def adequate(aircraft: str) -> tuple[Reading, ...]:
    """Share of the time of an approach, by what may be meant by adequate."""
    return tuple(
        Reading(text, approaches.share_of_the_time(aircraft, of))
        for text, of in (
            ("no limit acts", approaches.free),
            ("no limit acts, and linear feedback is then no worse on that leg", approaches.no_worse),
            ("linear feedback is better than the plots", approaches.better_than_plots),
        )
    )


CLAIMS: tuple[Claim, ...] = (
    *flown_too(
        Claim(
            "trajectories_differ",
            "with limits the captured trajectory differs greatly from the unlimited one",
            "fig. 3",
            above(1.0),
            tuple(Reading(f"from {start:.0f} m", counted(partial(largest_difference, start))) for start in FAR),
            "sigmas",
            geometry_by=OURS,
        ),
        tuple(Reading(text, difference_flown(name)) for text, name in GAINS.items()),
        f"{FLOWN} Against the double integrator without limits: the bank that it asks for no aircraft flies.",
    ),
    *flown_too(
        Claim(
            "linear_feedback_degrades",
            "the linear-feedback filter loses accuracy sharply once limits act",
            "fig. 4",
            above(1.0),
            tuple(Reading(f"every {t:g} s, q {q:g} m2/s3", limits_over_none(t, q)) for t, q in NOISES),
            "times",
            geometry_by=OURS,
        ),
        (Reading("from 5 km over from 500 m", outside_over_inside(GIVEN_GAINS)),),
        FLOWN,
    ),
    *flown_too(
        Claim(
            "saturated_control_accurate",
            "where limits act, the filter with the limited control formed outside stays accurate",
            "fig. 4",
            above(1.0),
            tuple(Reading(f"every {t:g} s, q {q:g} m2/s3", linear_over_saturated(OUTSIDE, t, q)) for t, q in NOISES),
            "times less RMSE",
            geometry_by=OURS,
        ),
        tuple(Reading(text, linear_over_saturated_flown(OUTSIDE, name)) for text, name in GAINS.items()),
        f"{FLOWN} Roll lag and the course motion cost saturated control next to nothing.",
    ),
    *flown_too(
        Claim(
            "breaks_of_tracking",
            "large deviations can break the tracking of the linear-feedback filter",
            "introduction, conclusions",
            above(0.0),
            tuple(Reading(f"from {start:.0f} m", lost_more(start)) for start in FAR),
            "of the runs",
            geometry_by=OURS,
        ),
        tuple(Reading(text, lost_more(OUTSIDE, name)) for text, name in GAINS.items()),
        FLOWN,
    ),
    *flown_too(
        Claim(
            "less_uncertain_prediction",
            "knowing the law makes the predicted position less uncertain",
            "introduction",
            above(1.0),
            tuple(Reading(f"{ahead:.0f} s ahead", better_ahead(ahead)) for ahead in (60.0, 20.0, 120.0)),
            "times less RMSE",
            geometry_by=OURS,
        ),
        tuple(
            Reading(f"{ahead:.0f} s ahead, {text}", better_ahead(ahead, name))
            for text, name in GAINS.items()
            for ahead in (60.0, 20.0, 120.0)
        ),
        FLOWN,
    ),
    *flown_too(
        Claim(
            "turns_lose_the_track",
            "on turns and on the transition to a new line the linear model loses the track",
            "introduction",
            above(1.0),
            in_turns(POINT_MASS),
            "times the RMSE",
            "kinematic",
            OURS,
            note=f"{PATTERNS} Flown by a point mass.",
            **OVER_FLIGHTS,
        ),
        in_turns(AIRCRAFT),
        PATTERNS,
    ),
    *flown_too(
        Claim(
            "lost_in_turns",
            "on turns and on the transition to a new line the linear model loses the track: lost runs",
            "introduction",
            above(0.0),
            lost_in_turns(POINT_MASS),
            "of the runs",
            "kinematic",
            OURS,
            note=f"{PATTERNS} Lost: ten scans outside the filter's own 1 - 1e-6 ellipse. Flown by a point mass.",
            **OVER_FLIGHTS,
        ),
        lost_in_turns(AIRCRAFT),
        f"{PATTERNS} Lost: ten scans outside the filter's own 1 - 1e-6 ellipse.",
    ),
    *flown_too(
        Claim(
            "adequate_on_most_of_the_route",
            "on most of the route the linear model is adequate",
            "introduction",
            above(0.5),
            adequate(POINT_MASS),
            "of the time",
            "kinematic",
            OURS,
            note=f"{PATTERNS} Flown by a point mass. Adequate is not said of what.",
            **OVER_FLIGHTS,
        ),
        adequate(AIRCRAFT),
        f"{PATTERNS} Adequate is not said of what.",
    ),
    *flown_too(
        Claim(
            "beacon_saturated_control_accurate",
            "with the radio-beacon law, too, the limited control formed outside the filter keeps it accurate",
            "eq. (5)",
            above(1.0),
            (
                Reading("from 11.3 deg", homed(LIMITED)),
                Reading("the same in a crosswind", homed(LIMITED, TRACK, CROSSWIND)),
                Reading("law on the heading", homed(LIMITED, HEADING, CROSSWIND)),
            ),
            "times less RMSE",
            "kinematic",
            OURS,
            note="Where the limits act; the crosswind is 10 m/s, and the filters are not told of it.",
        ),
        (
            Reading("law on the track", homed_flown(LIMITED)),
            Reading("law on the heading", homed_flown(LIMITED, HEADING)),
        ),
        "JSBSim flights from 5 to 7 km beside the course, 30 km before the beacon, in steady winds of up to 10 m/s "
        "that the filters are not told of; 20 draws of noise in each, the interval is over flights.",
    ),
    *flown_too(
        Claim(
            "beacon_inside_the_limits",
            "where no limit of the radio-beacon law acts, saturated control is worse than linear feedback",
            "not said",
            None,
            (
                Reading("from 1.4 deg", inverse(homed(UNLIMITED))),
                Reading("the same in a crosswind", inverse(homed(UNLIMITED, TRACK, CROSSWIND))),
                Reading("law on the heading", inverse(homed(UNLIMITED, HEADING, CROSSWIND))),
            ),
            "times",
            "kinematic",
            OURS,
            overlooked=True,
            note="On the heading the aircraft flies a homing curve off the course, which neither filter knows.",
        ),
        (Reading("law on the track", inverse(homed_flown(UNLIMITED))),),
        "JSBSim flights from 400 to 1000 m beside the course, else as where the limits act.",
    ),
    *flown_too(
        Claim(
            "inside_the_limits",
            "where no limit acts, saturated control is worse than linear feedback",
            "not said",
            None,
            (Reading("from 500 m", inverse(linear_over_saturated(INSIDE))),),
            "times",
            geometry_by=OURS,
            overlooked=True,
            note="The filter does not know that the error, too, is fed back.",
        ),
        (Reading("from 400 to 600 m", inverse(linear_over_saturated_flown(INSIDE, GIVEN_GAINS))),),
        f"{FLOWN} Here from 400 to 600 m.",
    ),
    Claim(
        "crossover",
        "start of the capture beyond which saturated control is the better one",
        "not said",
        None,
        (Reading("between 500 and 3000 m", crossover),),
        "m",
        geometry_by=OURS,
        overlooked=True,
    ),
    Claim(
        "told_wrong",
        "what a wrongly told law costs: the ratio of the gains and z_max matter, the bank limit does not",
        "not said",
        None,
        tuple(Reading(name, told(name)) for name in WRONG),
        "times",
        geometry_by=OURS,
        overlooked=True,
    ),
    Claim(
        "lost_behind_a_gate",
        "runs lost behind a gate of three sigmas",
        "not said",
        None,
        tuple(
            Reading(f"{text}, from {start:.0f} m", lost_share(name, start))
            for name, text in (("linear", "linear feedback"), ("saturated", "saturated control"))
            for start in (500.0, 1000.0, 1500.0, 2000.0, 3000.0, 8000.0)
        ),
        "of the runs",
        geometry_by=OURS,
        overlooked=True,
    ),
    Claim(
        "look_ahead",
        "position 60 s ahead during the capture",
        "not said",
        None,
        (
            Reading("saturated control", lambda s, n: rmse(looked_ahead(s, n, "saturated", DENSITY, MODEL)[60.0])),
            Reading("linear feedback", lambda s, n: rmse(looked_ahead(s, n, "linear", DENSITY, MODEL)[60.0])),
            Reading("no law, 0.3 m2/s3", lambda s, n: rmse(looked_ahead(s, n, "uniform", 0.3, MODEL)[60.0])),
        ),
        "m RMSE",
        geometry_by=OURS,
        overlooked=True,
    ),
    Claim(
        "accuracy_against_delay",
        "RMSE of the best filter without a law, smoothed with a fixed lag, over saturated control at once",
        "not said",
        None,
        tuple(Reading(f"{delay:g} s later", after_delay(delay)) for delay in DELAYS),
        "times",
        geometry_by=OURS,
        overlooked=True,
        note="Where the ratio is above 1, knowing the law is worth more than the delay.",
    ),
)
