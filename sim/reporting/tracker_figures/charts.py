"""All figures about the trackers of a run, in the order in which a reader asks: how well, then why."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.flight.record import Flight
from sim.metrics.alarms.monitoring import alarm_share
from sim.metrics.alarms.operating_curve import WINDOWS, operating_curves
from sim.metrics.conformance import conformance_sentence
from sim.reporting.drawing.figure import Drawing
from sim.reporting.figures import style
from sim.reporting.figures.style import Chart, Key
from sim.reporting.text.labels import joined, words
from sim.reporting.tracker_figures.conformance_strip import alert_strip
from sim.reporting.tracker_figures.contrast_map import contrast_map, drawn
from sim.reporting.tracker_figures.error_curves import Shown
from sim.reporting.tracker_figures.estimate_map import estimate_map
from sim.reporting.tracker_figures.model_probabilities import anomaly_strip, model_probabilities
from sim.reporting.tracker_figures.monitor_strip import monitor_strip
from sim.reporting.tracker_figures.operating_curves import drawn_curves
from sim.reporting.tracker_figures.parting import Parting
from sim.reporting.tracker_figures.path_bound import path_bound
from sim.reporting.tracker_figures.tracking_errors import (
    consistency_over_time,
    containment,
    credibility,
    error_by_phase,
    error_over_time,
    look_ahead_fan,
)
from tracking.conformance import Watched
from tracking.height_profile import Charted
from tracking.monitor import MONITOR

MOST_CURVES = 4  # trackers whose delays are drawn over their false alarms


def contrast_chart(
    flight: Flight, contrast: dict[str, Any], followed: list[Shown], parted: Parting | None
) -> Chart | None:
    """Two trackers where they part; None where one of them knows no place. ``contrast`` as in metrics.json."""
    known = {one.name: one for one in followed}
    if not {contrast["of"], contrast["against"]} <= {*known}:
        return None
    pair = known[contrast["of"]], known[contrast["against"]]
    found = contrast_map(flight, pair, parted)
    if found is None:
        return None
    names = [one.name for one in found.believed]
    way = f" ({contrast['name']})" if contrast.get("name") else ""
    title = f"{names[0]} against {names[1]}{way}"
    begin, end = found.time
    caption = (
        f"From {begin:.0f} s to {end:.0f} s, draw 0: thin lines join where the aircraft is and where a tracker "
        "believes it at the same instant; the route is dashed. "
    )
    if parted is not None:
        caption += (
            f"They part at {parted.start:.0f} s: from there one errs {parted.factor:g} times the other, over all draws."
        )
    else:
        caption += "They do not part: nowhere does one err half as much again as the other for 10 s on end."
    keys = (Key("flown", style.BLACK), *keys_of(list(pair)))
    return Chart(title[0].upper() + title[1:], drawn(found), caption, keys)


def story_chart(flight: Flight, shown: list[Shown]) -> Chart | None:
    """What was flown and where some trackers believe it; None where there are none, or one knows no place."""
    found = contrast_map(flight, shown, None) if shown and flight.known else None
    if found is None:
        return None
    names = joined([one.name for one in found.believed])
    caption = (
        "The whole flight, draw 0: thin lines join where the aircraft is and where a tracker believes it at the same "
        "instant; the route is dashed."
    )
    title = f"The flight, and where {names} {'believe' if shown[1:] else 'believes'} it"
    return Chart(title, drawn(found), caption, (Key("flown", style.BLACK), *keys_of(shown)))


def error_charts(
    scenario: Any,
    flight: Flight,
    trackers: dict[str, Any],
    followed: list[Shown],
    records: dict[str, Any],
    chart: Charted | None = None,
) -> list[Chart]:
    """How well the trackers did; ``trackers`` as in metrics.json."""
    if not followed:
        return []
    drawn: list[Chart] = []
    keys = keys_of(followed)

    def add(title: str, figure: Drawing | None, caption: str, keys: tuple[Key, ...] = keys) -> None:
        if figure is not None:
            drawn.append(Chart(title, figure, caption, keys))

    with np.errstate(invalid="ignore", divide="ignore"):
        bound = path_bound(flight, scenario.sensors, records)
        add(
            "Error over time",
            error_over_time(flight, followed, bound),
            "Root mean square over draws and short windows of time, on a logarithmic scale. Dashed: mismatched "
            "law. Dots: the measurements themselves."
            + (
                " Dotted: the Cramér-Rao bound on this path with every acceleration known, but no route; "
                "across track a tracker that knows where the autopilot steers may come below it."
                if bound is not None
                else ""
            ),
        )
        add(
            "Error by phase",
            error_by_phase(flight, trackers, followed),
            "Root mean square error with its 95 % interval, on a logarithmic scale; hatched: mismatched law; "
            "black line: the raw measurement.",
        )
        add(
            "Does each tracker know how good it is?",
            credibility(flight, followed),
            "Between the lines lie 95 % of the errors over all draws, shaded is what the tracker's own covariance "
            "promises. Lines outside the shade: too sure of itself. Lines to one side: biased. All panels have one "
            "scale, linear near 0 and logarithmic beyond.",
            (),
        )
        add(
            "Consistency over time",
            consistency_over_time(flight, followed),
            "Mean normalised error squared (ANEES) and normalised innovation squared (NIS) per dimension: 1 where "
            "covariances are right, and within the band in 95 % of the epochs of a consistent tracker. What leaves "
            "the frame is larger.",
        )
        add(
            "Estimates in plan",
            estimate_map(flight, scenario, followed, records, chart),
            "Draw 0. Above the whole flight, below the last turn enlarged, with ellipses of two standard "
            "deviations here and there; dots are the plots.",
        )
        inside = containment(flight, scenario, followed)
        if inside is not None:
            add(
                "Containment against the radar's azimuth norm",
                inside[0],
                "95th percentile over the draws of the cross-track error while the precision radar sees the "
                "aircraft. Norm: 0.6 % of the distance from the antenna, 9 m at least (Annex 10 I, 3.2.3.3.1, as "
                f"quoted in secondary sources). Epochs within it: {inside[1]}.",
            )
        add(
            "Look-ahead",
            look_ahead_fan(trackers, followed),
            "Root mean square error of the place that was predicted so many seconds ahead.",
        )
    return drawn


def keys_of(followed: list[Shown]) -> tuple[Key, ...]:
    """The trackers as the page names them beside a figure."""
    return tuple(Key(words(one.name), one.look["colour"], one.look["dashes"]) for one in followed)


def belief_charts(
    scenario: Any,
    flight: Flight,
    trackers: dict[str, Any],
    tracked: dict[str, Any],
    modes: dict[str, list[str]],
    alert: tuple[str, Watched] | None = None,
) -> list[Chart]:
    """What trackers with several hypotheses believed.

    ``tracked`` are those alone, ``modes`` what each calls its hypotheses, ``alert`` a tracker and its test.
    """
    drawn: list[Chart] = []

    def add(title: str, figure: Drawing | None, caption: str) -> None:
        if figure is not None:
            drawn.append(Chart(title, figure, caption))

    with np.errstate(invalid="ignore", divide="ignore"):
        add(
            "Model probabilities",
            model_probabilities(flight, tracked, modes),
            "What each tracker with several models believes, mean over the draws. A law's number is the factor on its "
            "position limit.",
        )
        if alert is not None:
            name, watched = alert
            add(
                "Who is flying?",
                alert_strip(flight, watched),
                f"{conformance_sentence(words(name), trackers[name]['conformance'])}. Above: probability of each "
                f"intent, mean over the draws. Below: the log likelihood ratio against the {watched.assumed}, summed "
                f"by Page's test; its limit makes false alarms rarer than one in {np.exp(watched.limit):.0f} looks.",
            )
        add(
            "Measurement anomalies",
            anomaly_strip(flight, scenario, tracked, modes),
            "Above: measured minus true angle of draw 0, linear within the dashed 2 σ of the stated accuracy and "
            "logarithmic beyond. Below: the mean probability of a worse accuracy than the stated.",
        )
    return drawn


def alarm_charts(
    flight: Flight, trackers: dict[str, Any], tracked: dict[str, Any], followed: list[Shown]
) -> list[Chart]:
    """When the monitor of innovations alarms; where something goes wrong, delays over false alarms.

    ``trackers`` as in metrics.json.
    """
    tracked = {name: one for name, one in tracked.items() if trackers[name]["monitor"] is not None}
    shares = {name: alarm_share(flight, one.track) for name, one in tracked.items()}
    curves = {
        name: operating_curves(tracked[name].tracker, tracked[name].track, fault)
        for name in list(tracked)[:MOST_CURVES]
        if (fault := trackers[name]["monitor"]["fault_s"]) is not None
    }
    drawn: list[Chart] = []
    if not shares:
        return drawn
    rates = {name: trackers[name]["monitor"]["alarms_per_1000"] for name in shares}
    colours = {one.name: one.look["colour"] for one in followed}
    drawn.append(
        Chart(
            "Does each tracker still follow?",
            monitor_strip(flight, shares, rates, colours),
            f"Share of the draws in which the innovations of the last {MONITOR.window} looks are too large for "
            f"chance: {1000 * MONITOR.false_alarm_rate:g} look in 1000 while a tracker's model holds. By its name "
            "the alarmed looks in 1000 before anything goes wrong (‰). A tracker that knows no turns, or is told "
            "the wrong law, alarms in each turn.",
        )
    )
    figure = drawn_curves(curves)
    if figure is not None:
        *few, most = map(str, WINDOWS)
        drawn.append(
            Chart(
                "How soon, at which price",
                figure,
                "Median delay from what goes wrong to the first alarm, over the false alarms before it, while the "
                f"threshold is swept: the monitor over {', '.join(few)} and {most} looks, and the conformance "
                "alert. Each alarm counts once, at its onset; a draw that is never alarmed is infinitely late, and "
                "a threshold at which half of them are is not drawn. Rings at the left edge: no false alarm was "
                "seen. Larger dots: the threshold that promises one in 1000 looks.",
            )
        )
    return drawn
