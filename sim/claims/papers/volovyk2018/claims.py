"""Volovyk, Havrilov, Mozgovoj 2018: the Kalman filter of the elevation channel and its four realisations."""

from __future__ import annotations

from functools import partial

from sim.claims.ledger import Claim, Reading, counted, flown_too
from sim.claims.manoeuvre_variance import noise_claim
from sim.claims.papers.volovyk2018.experiment import (
    CONFIDENCE,
    JSBSIM,
    LEG,
    SAMPLE,
    SETTLED,
    Stored,
    about_theory,
    bias,
    fewest,
    initial,
    inside,
    manoeuvre_shares,
    model_over_theory,
    over_theory,
    stored,
    worse,
)
from sim.claims.verdict import above, at_most, between, number
from tracking.operations import memory, saving
from tracking.trackers.elevation import interval_half_width

WHOLE = slice(SETTLED, None)
FLOWN = "The printed level leg flown by JSBSim's A-4; runs are draws of noise."


def words_of_memory(variant: int, order: int) -> float:
    """Of a realisation of the printed filter of this order, with gains of the whole leg where it stores them."""
    return float(sum(memory(variant, order, 1, LEG)))


CLAIMS: tuple[Claim, ...] = (
    Claim(
        "multiplications_saved",
        "a stored gain saves 82 per cent of the multiplications",
        "eq. (24)",
        number("82", good=1),
        (Reading("counted, matrices taken as dense", counted(lambda: 100.0 * saving(2, 1)[0])),),
        "%",
    ),
    Claim(
        "additions_saved",
        "a stored gain saves 80 per cent of the additions",
        "eq. (25)",
        number("80", good=1),
        (Reading("counted, matrices taken as dense", counted(lambda: 100.0 * saving(2, 1)[1])),),
        "%",
    ),
    *flown_too(
        Claim(
            "band",
            "the Monte-Carlo accuracy stays within 20 per cent of the theoretical one with 50 runs",
            "fig. 4",
            number("0.95", good=1),
            (
                Reading("steps inside, on the deviation", inside(True)),
                Reading("steps inside, on the variance", inside(False)),
                Reading("samples inside at every step", inside(True, whole=True)),
            ),
            "of the steps",
            paper_runs=SAMPLE,
            first_runs=4000,
            note="The sentence speaks of the variance, the formula of its root.",
        ),
        (
            Reading("steps inside, on the deviation", inside(True, truth=JSBSIM)),
            Reading("steps inside, on the variance", inside(False, truth=JSBSIM)),
            Reading("samples inside at every step", inside(True, whole=True, truth=JSBSIM)),
        ),
        f"{FLOWN} A smooth flight has none of the jumps that the model draws: its errors are below the theory.",
        geometry_by="paper",
        first_runs=200,
    ),
    Claim(
        "runs_needed",
        "50 runs suffice for 20 per cent at 0.95",
        "confidence interval",
        at_most(50),
        (
            Reading("band about the theory, as in fig. 4", counted(lambda: fewest(about_theory))),
            Reading("interval about the sample", counted(lambda: fewest(lambda n: interval_half_width(CONFIDENCE, n)))),
        ),
        "runs",
    ),
    *flown_too(
        Claim(
            "first_order_dynamic_error",
            "a first-order filter has considerable dynamic errors",
            "introduction of the model",
            above(1.0),
            (
                Reading("RMS of both tuned", worse("first order, tuned", "tuned")),
                Reading("first tuned, second as published", worse("first order, tuned", "as published")),
                Reading("both with Q 1e-4", worse("first order, Q 1e-4", "as published")),
            ),
            "times",
            truth="kinematic",
            geometry_by="paper",
        ),
        (
            Reading("RMS of both tuned", worse("first order, tuned", "tuned", JSBSIM)),
            Reading("first tuned, second as published", worse("first order, tuned", "as published", JSBSIM)),
            Reading("both with Q 1e-4", worse("first order, Q 1e-4", "as published", JSBSIM)),
        ),
        f"{FLOWN} Tuned on the same leg without the aircraft.",
        first_runs=200,
    ),
    Claim(
        "stored_gain_convergence",
        "with stored gains convergence is no longer guaranteed",
        "variant 4",
        above(1.0),
        (
            Reading("the schedule, as modelled", stored(Stored(), slice(None))),
            Reading("a constant gain, first half second", stored(Stored(constant=True), slice(0, 20))),
            Reading("the schedule, noise 25 times larger", stored(Stored(noise=25.0), WHOLE)),
        ),
        "times",
        note="The gain does not look at the data: only what is told on line can make a difference.",
    ),
    *flown_too(
        Claim(
            "far_no_manoeuvre_noise",
            "far out the manoeuvre noise may be neglected",
            "conclusions",
            between("0.8", "1.2"),
            (
                Reading("none, 15 to 10 km", over_theory("no manoeuvre noise", distance=10e3)),
                Reading("that of the recipe, 15 to 10 km", over_theory("manoeuvre noise of the recipe", distance=10e3)),
            ),
            "RMS over theory",
            truth="kinematic",
            geometry_by="paper",
            note="Judged by the paper's own 20 per cent about the theoretical deviation.",
        ),
        (
            Reading("none, 15 to 10 km", over_theory("no manoeuvre noise", JSBSIM, 10e3)),
            Reading("that of the recipe, 15 to 10 km", over_theory("manoeuvre noise of the recipe", JSBSIM, 10e3)),
        ),
        FLOWN,
        first_runs=200,
    ),
    *flown_too(
        Claim(
            "online_accuracy",
            "the covariance serves as a monitor of the current accuracy",
            "introduction, conclusions",
            between("0.8", "1.2"),
            (
                Reading("as published, truth of the model", model_over_theory),
                Reading("as published, real level leg", over_theory("as published")),
                Reading("Q as an acceleration, real level leg", over_theory("Q as an acceleration")),
                Reading("Q of the recipe, real level leg", over_theory("manoeuvre noise of the recipe")),
            ),
            "RMS over theory",
            truth="kinematic",
            geometry_by="paper",
            note="The covariance knows nothing of the data: it is as good as its Q.",
        ),
        (
            Reading("as published", over_theory("as published", JSBSIM)),
            Reading("Q as an acceleration", over_theory("Q as an acceleration", JSBSIM)),
            Reading("Q of the recipe", over_theory("manoeuvre noise of the recipe", JSBSIM)),
        ),
        FLOWN,
        first_runs=200,
    ),
    Claim(
        "memory",
        "the volume of memory decides between the realisations beside the operations",
        "resources of the variants",
        above(1.0),
        (
            Reading("gains of the whole leg", counted(lambda: sum(memory(4, 2, 1, LEG)) / sum(memory(1, 2, 1)))),
            Reading("gains until they settle", counted(lambda: sum(memory(4, 2, 1, 200)) / sum(memory(1, 2, 1)))),
        ),
        "words of variant 4 over variant 1",
    ),
    *flown_too(
        Claim(
            "second_order_suffices",
            "a second-order model suffices while half the angular acceleration over a period is small",
            "eq. (3)",
            between("0.8", "1.2"),
            (
                Reading("as published", over_theory("as published")),
                Reading("Q of the recipe", over_theory("manoeuvre noise of the recipe")),
            ),
            "RMS over theory",
            truth="kinematic",
            geometry_by="paper",
            note="The condition holds by five orders in both cases: the memory of the filter counts, not the period.",
        ),
        (
            Reading("as published", over_theory("as published", JSBSIM)),
            Reading("Q of the recipe", over_theory("manoeuvre noise of the recipe", JSBSIM)),
        ),
        FLOWN,
        first_runs=200,
    ),
    Claim(
        "initial_values",
        "0.7 deg where the level leg begins",
        "fig. 2",
        number("0.7"),
        (Reading("from the printed geometry", counted(initial(0))),),
        "deg",
        "kinematic",
        "paper",
    ),
    Claim(
        "initial_values_rate",
        "0.0122 deg/s where the level leg begins",
        "fig. 2",
        number("0.0122"),
        (Reading("from the printed geometry", counted(initial(1))),),
        "deg/s",
        "kinematic",
        "paper",
        note="0.0122 is 0.7 deg in radians.",
    ),
    Claim(
        "initial_values_acceleration",
        "0.0002 deg/s^2 where the level leg begins",
        "fig. 2",
        number("0.0002"),
        (Reading("from the printed geometry", counted(initial(2))),),
        "deg/s^2",
        "kinematic",
        "paper",
    ),
    noise_claim("manoeuvre_noise", "process noise 3.6e-8 (deg/s^2)^2 at 10 km", "experiment", "3.6e-8", 10000.0),
    noise_claim("manoeuvre_noise_5_km", "process noise 7e-4 (deg/s^2)^2 at 5 km", "experiment", "7e-4", 5000.0),
    noise_claim("manoeuvre_noise_1_km", "process noise 11.5e-4 at 1 km", "experiment", "11.5e-4", 1000.0, 40.0),
    Claim(
        "manoeuvre_variance",
        "variance of the manoeuvre acceleration from its largest value and two probabilities",
        "Singer",
        number("1.00"),
        (Reading("formula over the mixture summed", counted(manoeuvre_shares)),),
        "times",
    ),
    Claim(
        "lag_at_five_kilometres",
        "lag at the end of the level leg, over the random error beside it",
        "not said",
        None,
        tuple(Reading(n, bias(n)) for n in ("manoeuvre noise of the recipe", "as published", "first order, tuned")),
        "times",
        truth="kinematic",
        geometry_by="paper",
        overlooked=True,
    ),
    Claim(
        "higher_order",
        "RMS error of the second order over that of the third, both tuned, on the level leg",
        "Singer",
        None,
        (
            Reading("as printed", worse("tuned", "third order, tuned")),
            Reading("flown on JSBSim", worse("tuned", "third order, tuned", JSBSIM)),
        ),
        "times",
        truth="kinematic",
        geometry_by="paper",
        overlooked=True,
        note="The print has the third-order model and evaluates the second.",
    ),
    Claim(
        "memory_by_order",
        "words of memory by the order of the filter",
        "resources of the variants",
        None,
        tuple(
            Reading(f"order {order}, {text}", counted(partial(words_of_memory, variant, order)))
            for variant, text in ((1, "gain computed"), (4, "gains of the whole leg stored"))
            for order in (1, 2, 3)
        ),
        "words",
        overlooked=True,
        note="The paper weighs orders by accuracy alone; a first-order filter with a computed gain needs six words.",
    ),
    Claim(
        "missed_measurements",
        "RMS error of a stored gain over the full filter where measurements are missed",
        "variant 4",
        None,
        (Reading("half missed", stored(Stored(missed=0.5), WHOLE)),),
        "times",
        overlooked=True,
        note="Where none is missed the two are one filter: this is what the stored gain costs.",
    ),
)
