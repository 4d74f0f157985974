"""The metric table: one row for each scalar figure of a flight, read by everything that uses the figure.

A row puts its figure into the ``flight`` part of metrics.json, the percentiles over several flights, the rows of a
study and its export; ``[[checks]]`` and the search for a limit accept its name; the reports show
it under its label with its digits and its unit. Nothing else knows its name.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sim.flight.record import Flight
from sim.metrics.figures import (
    DECISION_HEIGHT,
    Context,
    at_height,
    at_touchdown,
    bank_cycle,
    base_overshoot,
    cross_track,
    cross_track_rms,
    final_over_stall,
    height_errors,
    in_rollout,
    normal_acceleration,
    of_navigation,
    on_settled_glide,
    overshoot,
    rates_on_bank,
    settling,
    time_saturated,
    touchdown_main_first,
    touchdown_over_stall,
    touchdown_track_crab,
)
from sim.metrics.signals import bank_rate


class Metric(NamedTuple):
    """One scalar figure of a flight, and its contract."""

    name: str
    """Key in metrics.json and in checks: lower case, ends in ``_UNIT``; ``table.name`` is in a nested table."""

    unit: str
    """Unit suffix (``m``, ``deg``, ``mps``, ...) of the value, of its limits and of the name; "" = a plain number."""

    label: str
    """What reports call it, in words and without the unit, such as "greatest bank"."""

    of: Callable[[Flight, Context], float | None]
    """The value in ``unit``, from the whole record of a flight that ended in whatever way; None = nothing to say.

    What is not finite counts as None. The function changes nothing, draws no random number, and raises nothing for a
    flight that has no such phase, leg or contact.
    """

    digits: int
    """Decimal places with which reports show the value."""

    headline: bool = False
    """Whether it is one of the key figures at the head of a report, in the order of the table."""


METRICS: tuple[Metric, ...] = (
    Metric("landed", "", "landed", lambda flight, context: float(flight.outcome == "landed"), 0),
    Metric("duration_s", "s", "flight time", lambda flight, context: flight.time[-1] - flight.time[0], 1, True),
    Metric(
        "bank_max_deg",
        "deg",
        "greatest bank",
        lambda flight, context: np.degrees(np.abs(flight.state.bank).max()),
        2,
        True,
    ),
    Metric(
        "bank_rate_max_degps",
        "degps",
        "greatest bank rate",
        lambda flight, context: np.degrees(np.abs(bank_rate(flight)).max()),
        2,
    ),
    Metric("time_saturated_s", "s", "at the bank limit", time_saturated, 1, True),
    Metric(
        "bank_cycle_deg",
        "deg",
        "amplitude of the bank cycle",
        lambda flight, context: np.degrees(bank_cycle(flight)[0]),
        2,
    ),
    Metric("bank_cycle_period_s", "s", "period of the bank cycle", lambda flight, context: bank_cycle(flight)[1], 1),
    Metric("base_overshoot_m", "m", "overshoot of base", base_overshoot, 2, True),
    Metric("overshoot_m", "m", "overshoot of the last leg", overshoot, 2, True),
    Metric("settling_s", "s", "settled after", settling, 1, True),
    Metric("final_over_stall", "", "least speed down to 50 ft over the stall speed", final_over_stall, 2),
    Metric("cross_track_rms_final_m", "m", "cross-track RMS, final", cross_track_rms, 2, True),
    Metric("height_error_rms_final_m", "m", "height error RMS, glide path", on_settled_glide(height_errors), 2, True),
    Metric(
        "normal_acceleration_rms_final_mps2",
        "mps2",
        "normal acceleration RMS, glide path",
        on_settled_glide(normal_acceleration),
        3,
    ),
    Metric("bank_rate_rms_final_degps", "degps", "bank rate RMS, glide path", on_settled_glide(rates_on_bank), 3),
    Metric("cross_track_at_30_m_m", "m", "cross-track at 30 m", at_height(30.0, cross_track), 2),
    Metric(
        "cross_track_at_decision_height_m",
        "m",
        "cross-track at decision height",
        at_height(DECISION_HEIGHT, cross_track),
        2,
    ),
    Metric(
        "height_error_at_decision_height_m",
        "m",
        "height error at decision height",
        at_height(DECISION_HEIGHT, height_errors),
        2,
    ),
    Metric("touchdown.time_s", "s", "time of touchdown", at_touchdown(lambda down: down.time), 1),
    Metric(
        "touchdown.past_threshold_m",
        "m",
        "touchdown past the threshold",
        at_touchdown(lambda down: down.past_threshold),
        1,
        True,
    ),
    Metric(
        "touchdown.cross_track_m",
        "m",
        "touchdown right of centreline",
        at_touchdown(lambda down: down.cross_track),
        2,
        True,
    ),
    Metric("touchdown.sink_mps", "mps", "sink at touchdown", at_touchdown(lambda down: down.sink), 2, True),
    Metric("touchdown.drift_mps", "mps", "drift at touchdown", at_touchdown(lambda down: down.drift), 2),
    Metric("touchdown.crab_deg", "deg", "crab at touchdown", at_touchdown(lambda down: np.degrees(down.crab)), 2, True),
    Metric(
        "touchdown.track_crab_deg",
        "deg",
        "heading less track at touchdown",
        touchdown_track_crab,
        2,
    ),
    Metric("touchdown.bank_deg", "deg", "bank at touchdown", at_touchdown(lambda down: np.degrees(down.bank)), 2),
    Metric(
        "touchdown.pitch_deg", "deg", "pitch at touchdown", at_touchdown(lambda down: np.degrees(down.pitch)), 2, True
    ),
    Metric("touchdown.main_first", "", "main wheels first", touchdown_main_first, 0),
    Metric("touchdown.airspeed_mps", "mps", "true airspeed at touchdown", at_touchdown(lambda down: down.airspeed), 2),
    Metric(
        "touchdown.equivalent_airspeed_mps",
        "mps",
        "equivalent airspeed at touchdown",
        at_touchdown(lambda down: down.equivalent_airspeed),
        2,
    ),
    Metric("touchdown.over_stall", "", "touchdown speed over the stall speed", touchdown_over_stall, 2),
    Metric(
        "rollout.distance_m",
        "m",
        "roll-out from first contact to stop",
        in_rollout(lambda rolled: rolled.distance),
        0,
        True,
    ),
    Metric("rollout.time_s", "s", "time of the roll-out", in_rollout(lambda rolled: rolled.time), 1),
    Metric(
        "rollout.cross_track_max_m",
        "m",
        "farthest off the centreline in the roll-out",
        in_rollout(lambda rolled: rolled.cross_track),
        2,
    ),
    Metric(
        "rollout.deceleration_mean_mps2",
        "mps2",
        "mean deceleration of the roll-out",
        in_rollout(lambda rolled: rolled.deceleration),
        2,
    ),
    Metric(
        "navigated.error_rms_m",
        "m",
        "cross-track error RMS of the estimate it was flown on",
        of_navigation(lambda found: found.error_rms),
        1,
    ),
    Metric(
        "navigated.rate_lag_s",
        "s",
        "lag of the cross-track rate it was flown on",
        of_navigation(lambda found: found.rate_lag),
        2,
    ),
    Metric(
        "navigated.rate_lag_stood_s",
        "s",
        "lag of the cross-track rate that the law tolerates",
        of_navigation(lambda found: found.rate_lag_tolerated),
        2,
    ),
    Metric(
        "navigated.lost_time_s",
        "s",
        "the tracker it was flown on was lost at",
        of_navigation(lambda found: found.lost_time),
        1,
    ),
)


def find(name: str) -> Metric | None:
    """The row of a name."""
    return next((row for row in METRICS if row.name == name), None)


def names() -> tuple[str, ...]:
    """Names of all figures, in the order of the table."""
    return tuple(row.name for row in METRICS)
