"""How good the estimate was that an aircraft was flown on, and why a flight on it ended where it should not.

A flight that a tracker navigates ends badly in one of three ways. The tracker is lost, and the autopilot keeps the
estimate on the line, but not the aircraft. Its cross-track rate lags more than the law tolerates, and the aircraft
oscillates about its line. Or its noise moves the aircraft more than the stabilised-approach gate allows.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from aircraft.state import STANDARD_GRAVITY
from autopilot.estimate_lag import bank_lag, tolerated_lag
from autopilot.modes.lateral_navigation import LateralNavigation
from sim.flight.interpolation import truth_at
from sim.flight.preparation import Prepared
from sim.flight.record import Flight
from sim.metrics.figures import Context, Navigation
from sim.metrics.flight import figure, navigated_figures
from tracking.track import Track

GOOD = ("landed", "completed")
BESIDE = (
    *("outcome", "cross_track_at_decision_height_m", "height_error_at_decision_height_m"),
    *("normal_acceleration_rms_final_mps2", "bank_rate_rms_final_degps"),
    *("touchdown.past_threshold_m", "touchdown.cross_track_m", "touchdown.sink_mps"),
)
SWINGING = 0.1  # of the time at the bank limit, at least, is a cycle and no correction


def navigation_quality(
    prepared: Prepared, flight: Flight, track: Track | None, judged: dict[str, Any]
) -> dict[str, Any] | None:
    """The table ``navigated`` of metrics.json; None for a flight that was flown on the truth.

    ``judged`` are the tracker's figures. The lag is that of the estimated rate across the leg behind the true one, by
    least squares over the acceleration; it and what the law tolerates are None for a tracker of a height.
    """
    name = prepared.scenario.autopilot.navigation
    if name == "truth":
        return None
    quality, why = _quality(prepared, flight, name, track, judged)
    context = Context(prepared.scenario.runway, prepared.law.bank_limit, quality, prepared.stall_speed)
    ended_well = flight.outcome in GOOD
    return {"tracker": name, "why": None if ended_well else why, **navigated_figures(flight, context)}


def _quality(
    prepared: Prepared, flight: Flight, name: str, track: Track | None, judged: dict[str, Any]
) -> tuple[Navigation, str]:
    """How good the estimate was, and why a flight on it ended where it should not, if it did."""
    lost = judged.get("lost_time_s")
    if track is None:
        return Navigation(lost_time=lost), f"tracker '{name}' never saw the aircraft"
    if "north" not in track.channels:
        return Navigation(lost_time=lost), _height(name, judged)
    across, rate, true_rate, acceleration = _across(flight, track)
    moved = float(acceleration @ acceleration)
    lag = float((true_rate - rate) @ acceleration / moved) if moved > 0.0 else None
    law = LateralNavigation.of(prepared.law)
    tolerated = None if law is None else tolerated_lag(law.k1, law.k2, bank_lag(prepared.designed))
    quality = Navigation(float(np.sqrt(np.mean(across**2))), lag, tolerated, lost)
    return quality, _place(flight, prepared, name, quality, across, track)


def beside(figures: dict[str, Any]) -> list[tuple[str, Any, Any]]:
    """(figure, on the estimate, on the truth) of a navigated flight and the same flight flown on the truth."""
    twin = (figures.get("navigated") or {}).get("on_truth")
    return [(name, figure(figures, name), figure(twin, name)) for name in BESIDE] if twin else []


def _across(flight: Flight, track: Track) -> tuple[np.ndarray, ...]:
    """(k,) error across the active leg, m, estimated and true rate, m/s, true acceleration, m/s2, at the epochs."""
    truth = truth_at(flight, track.time)
    course = np.array([leg.course for leg in flight.route.legs])[truth.leg]
    right = np.stack((-np.sin(course), np.cos(course)))
    mean = {name: track.mean[:, row, 0] for row, name in enumerate(track.channels)}
    error = right[0] * (mean["north"] - truth.position[0]) + right[1] * (mean["east"] - truth.position[1])
    rate = right[0] * mean["north_rate"] + right[1] * mean["east_rate"]
    true_rate = right[0] * truth.velocity[0] + right[1] * truth.velocity[1]
    acceleration = STANDARD_GRAVITY * np.tan(np.interp(track.time, flight.time, flight.state.bank))
    kept = np.isfinite(error + rate)
    return error[kept], rate[kept], true_rate[kept], acceleration[kept]


def _place(flight: Flight, prepared: Prepared, name: str, quality: Navigation, across: np.ndarray, track: Track) -> str:
    """A tracker of the position."""
    lost = quality.lost_time
    if lost is not None or not across.size:
        cov = track.cov if track.cov.ndim == 3 else track.cov[..., 0]
        rows = [track.channels.index("north"), track.channels.index("east")]
        sigma = float(np.sqrt(np.trace(cov[-1][np.ix_(rows, rows)])))
        off = abs(float(flight.deviation.cross_track[-1]))
        wrong = abs(float(across[-1])) if across.size else np.nan
        after = "from the beginning" if lost is None else f"after {lost:.0f} s"
        return (
            f"{name}, on which it was flown, was lost {after}: at the end the aircraft was {off:.0f} m off its leg and "
            f"the estimate wrong by {wrong:.0f} m across, where it stated {sigma:.0f} m"
        )
    late, tolerated = quality.rate_lag, quality.rate_lag_tolerated
    at_limit = float(np.mean(np.abs(flight.command.bank) >= prepared.law.bank_limit * (1 - 1e-6)))
    if (
        late is not None
        and tolerated is not None
        and (late > tolerated or (at_limit > SWINGING and 2.0 * late > tolerated))
    ):
        return (
            f"the cross-track rate of {name}, on which it was flown, came {late:.1f} s late and the law tolerates "
            f"{tolerated:.1f} s: the aircraft swung about its leg, at the bank limit for {at_limit:.0%} of the time"
        )
    return (
        f"{name}, on which it was flown, was wrong by {quality.error_rms:.0f} m rms across, and the autopilot "
        f"followed its noise"
    )


def _height(name: str, judged: dict[str, Any]) -> str:
    """A tracker of an elevation gives the height."""
    channel, figure = next(iter(judged["overall"].items()), ("", {"rmse": np.nan}))
    lost = judged.get("lost_time_s")
    after = "" if lost is None else f", lost after {lost:.0f} s"
    shown, _, unit = channel.rpartition("_")
    return f"{name}, on whose height it was flown, was wrong by {figure['rmse']:.2g} {unit} rms in {shown}{after}"
