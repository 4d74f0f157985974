"""A result as a console and a notebook show it: what was flown, how it ended, the best tracker, the checks."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from sim.metrics.conformance import MISMATCHED
from sim.reporting.figures.flight import charts
from sim.reporting.figures.style import Chart
from sim.reporting.page import picture
from sim.reporting.run_figures import Run, story
from sim.reporting.text.best_tracker import MOST_LOST, best_tracker
from sim.reporting.text.contrast_sentence import contrast_sentences
from sim.reporting.text.header import first_screen
from sim.reporting.text.labels import number, split, words
from sim.reporting.text.reasons import Flown
from sim.reporting.text.rows import check_name
from sim.reporting.tracker_figures.error_curves import shown_trackers
from sim.scenario.model import Scenario

FIRST = ("position_m", "cross_track_m", "height_m")  # channels in the order in which trackers are compared by them


def in_short(scenario: Scenario, metrics: Mapping[str, Any]) -> str:
    """A few lines from metrics.json."""
    count = metrics.get("flights", 1)
    flight = metrics["flight"]
    ended = f"{words(flight['outcome'])} after {flight['duration_s']:.0f} s" if flight.get("duration_s") else ""
    lines = [
        f"{scenario.name}: {ended or words(flight['outcome'])} (seed {metrics['seed']}"
        + (f", the first of {count} flights" if count > 1 else "")
        + ")"
    ]
    best = leader(metrics)
    if best is not None:
        name, channel, value = best
        among = len(metrics["trackers"])
        of = f"the best of {among} trackers" if among > 1 else "the tracker"
        lines.append(f"{of}: {words(name)}, {number(value, 3)} {split(channel)[1]} RMS ({split(channel)[0]})")
    if metrics.get("checks"):
        lines.append(_checks(metrics["checks"]))
    if metrics.get("warnings"):
        lines.append(f"warnings: {len(metrics['warnings'])}, in metrics['warnings']")
    return "\n".join(["<Result of " + lines[0], *(f"  {line}" for line in lines[1:])]) + ">"


def study_in_short(metrics: Mapping[str, Any], folder: str | None) -> str:
    """A few lines from the metrics.json of a study."""
    ends = ", ".join(f"{count} {words(name)}" for name, count in sorted(metrics["outcomes"].items()))
    lines = [f"{metrics['scenario']}: {metrics['flights']} flights (seed {metrics['seed']}): {ends}"]
    if metrics["checks"]:
        lines.append(_checks(metrics["checks"]))
    if folder is not None:
        lines.append(f"in {folder}")
    return "\n".join(["<StudyResult of " + lines[0], *(f"  {line}" for line in lines[1:])]) + ">"


def _checks(checks: list[Any]) -> str:
    failed = [check_name(check) for check in checks if check["passed"] is False]
    passed = sum(check["passed"] is True for check in checks)
    return f"checks: {passed} of {len(checks)} passed" + (f"; failed: {', '.join(failed)}" if failed else "")


def leader(metrics: Mapping[str, Any]) -> tuple[str, str, float] | None:
    """(name, channel, RMSE) of the tracker that erred least, of those that are told the right law and keep the track.

    None where nothing was tracked that can be judged.
    """
    trackers = metrics["trackers"]
    for channel in FIRST:
        able = {
            name: one["overall"][channel]["rmse"]
            for name, one in trackers.items()
            if (one.get("overall") or {}).get(channel, {}).get("rmse") is not None
        }
        if able:
            best = min(able, key=lambda name: _rank(trackers[name], able[name]))
            return best, channel, float(able[best])
    return None


def _rank(tracker: Mapping[str, Any], rmse: float) -> tuple[bool, bool, float]:
    return tracker["law_from"] == MISMATCHED, (tracker.get("lost_fraction") or 0.0) > MOST_LOST, rmse


def as_html(run: Run) -> str:
    """The first screen of the report, and the figure that tells the story."""
    scenario, tracked = run.prepared.scenario, dict(run.tracks)
    shown = shown_trackers(scenario, tracked)
    flown = Flown(scenario, run.prepared.law, run.flight, tracked)
    metrics = {**run.metrics, "trackers": run.trackers}
    contrasted = contrast_sentences(dict(run.metrics), flown, run.trackers)
    said = first_screen(scenario, run.flight, metrics, shown, run.number, contrasted)
    sentences = [said["sentence"], *([said["why"]] if said["why"] else []), *contrasted]
    winner = best_tracker(run.flight, run.trackers, shown, short=bool(contrasted))
    parts = [f"<h3>{escape(scenario.name)}</h3>", f"<p><small>{escape('; '.join(said['subtitle']))}</small></p>"]
    parts += [f"<p>{escape(sentence)}</p>" for sentence in (*sentences, winner) if sentence]
    chart = story(run, shown) or _plan(run)
    if chart is not None:
        drawn = picture(chart)
        parts.append(f"<figure>{drawn.image}<figcaption>{escape(drawn.title)}. {escape(drawn.caption)}</figcaption>")
        parts.append("</figure>")
    # a paper of its own, since the ink of a figure is black whatever the notebook is
    return f'<div style="max-width:60em;padding:0.5em;background:#fff;color:#222">{"".join(parts)}</div>'


def _plan(run: Run) -> Chart | None:
    """The first figure of a flight whose motion is known: its plan view."""
    if not run.flight.known:
        return None
    return charts(run.flight, run.prepared.scenario, run.prepared.law)[0]
