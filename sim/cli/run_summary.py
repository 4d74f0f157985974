"""The result of a run, or of a study, in a few lines of plain text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sim.cli.terminal import table
from sim.metrics.conformance import conformance_sentence
from sim.metrics.ensemble.exceedance import answer
from sim.metrics.navigation import beside
from sim.reporting.text.broken_checks import Again, broken_checks, chosen
from sim.reporting.text.rows import flights_of
from sim.reporting.without_truth.tables import plot_tables

MOST_REASONS = 3  # of flights that crashed, or were refused
SHOWN = {"position_m", "cross_track_m"}  # where a tracker has them; the report has every channel
AHEAD = "position_m"  # what a look-ahead is about


def summary(metrics: dict[str, Any], again: Again, said: Sequence[str] = (), contrasted: Sequence[str] = ()) -> str:
    """One sentence on what happened, the trackers, then the checks as an aligned table.

    ``again`` is how a flight is flown again, as ``run_again`` gives it; ``said`` are warnings that were said;
    ``contrasted`` is what is said of the trackers that are set against each other.
    """
    flight, several = metrics["flight"], metrics["flights"] > 1
    if several:
        ended = _ended(metrics["flights_summary"]["outcomes"])
        lines = [f"{metrics['scenario']}: {metrics['flights']} flights: {ended} (seed {metrics['seed']})"]
    else:
        lines = [f"{metrics['scenario']}: {flight['reason']} ({flight['duration_s']:.0f} s, seed {metrics['seed']})"]
    why = (flight.get("navigated") or {}).get("why")
    lines += [f"why{' (flight 0)' if several else ''}: {why}"] if why else []
    lines += ["", *contrasted] if contrasted else []
    rows = [
        (name, channel, figure["rmse"], figure["raw"], figure["gain"])
        for name, tracker in metrics["trackers"].items()
        for channel, figure in tracker["overall"].items()
        if channel in SHOWN or not SHOWN & set(tracker["overall"])
    ]
    if rows:
        header = ["tracker", "channel", "rmse", "raw", "gain"]
        lines += ["", *table([header, *([*row[:2], *map(_number, row[2:])] for row in rows)], 2)]
    alone = plot_tables(metrics["trackers"])
    if alone:
        shown = alone[0]
        lines += ["", *table([shown.header, *shown.rows], shown.lefts)]
    if any(one["overall"] for one in metrics.get("contrasts", ())):
        lines += ["", *_contrasts(metrics["contrasts"])]
    twin = beside(flight)
    if twin:
        header = ["beside the same approach", "on the estimate", "on the truth"]
        lines += ["", *table([header, *([name, *map(_number, values)] for name, *values in twin)], 1)]
    alerts = {name: tracker.get("conformance") for name, tracker in metrics["trackers"].items()}
    if any(alerts.values()):
        lines += ["", *(conformance_sentence(name, found) for name, found in alerts.items() if found)]
    if metrics["checks"]:
        lines += ["", *_checks(metrics["checks"], several)]
    failed = broken_checks(metrics, again)
    if failed:
        lines += ["", *failed]
    lines += [f"warning: {warning}" for warning in metrics["warnings"] if warning not in said]
    return "\n".join(lines)


def _ended(outcomes: dict[str, int]) -> str:
    return ", ".join(f"{count} {name}" for name, count in sorted(outcomes.items()))


def _contrasts(contrasts: list[dict[str, Any]]) -> list[str]:
    """How many times the errors of one tracker are those of another, as an aligned table; interval 95 %."""
    rows = [["RMSE of", "over that of", "", "ratio", "from", "to"]]
    for one in contrasts:
        pair = [one["of"] + (f", {one['name']}" if one["name"] else ""), one["against"]]
        found = [
            *((c, figure) for c, figure in one["overall"].items() if c in SHOWN or not SHOWN & set(one["overall"])),
            *((f"{AHEAD}, {span.removesuffix('_s')} s ahead", by.get(AHEAD)) for span, by in one["look_ahead"].items()),
        ]
        rows += [[*pair, what, *(_number(f[key]) for key in ("ratio", "low", "high"))] for what, f in found if f]
    return table(rows, 3)


def _checks(checks: list[dict[str, Any]], several: bool) -> list[str]:
    """The verdicts as an aligned table; of several flights also how many kept a check, and which decides."""
    verdicts = {None: "not flown", True: "passed", False: "FAILED"}
    kept = ["within", "of", "flight"] if several else []
    rows = [["check", *kept, "value", "limit", "margin", ""]]
    for check in checks:
        counts = [str(check["within"]), str(check["flights"] - check["not_flown"]), str(check["flight"])]
        numbers = [_number(check[key]) for key in ("value", "limit", "margin")]
        rows.append([check["name"], *(counts if several else []), *numbers, verdicts[check["passed"]]])
    return table(rows, 1)


def _number(value: float | str | None) -> str:
    if isinstance(value, str):
        return value
    return "-" if value is None else f"{value:.4g}"


def study_summary(metrics: dict[str, Any], again: Again) -> str:
    """How all flights ended, how often they broke a check, the checks as a table, and the worst flight.

    ``again`` as in `summary`.
    """
    ended = _ended(metrics["outcomes"])
    lines = [f"{metrics['scenario']}: {flights_of(metrics)}: {ended}"]
    lines += [metrics["answer"]] if "answer" in metrics else []
    lines += [answer(metrics)] if "exceedances" in metrics else []
    for outcome, name in (("crashed", "crashes"), ("refused", "refusals")):
        lines += [f"{outcome}: {reason}" for reason in metrics.get(name, ())[:MOST_REASONS]]
    if metrics["checks"]:
        lines += ["", *_checks(metrics["checks"], True)]
    failed = broken_checks(metrics, again)
    if metrics["checks"] and not failed:
        worst = metrics["worst"]
        how = again(worst["flight"], chosen(worst["values"], metrics))
        failed = [f"nearest to a limit: flight {worst['flight']}: {how}"]
    return "\n".join([*lines, "", *failed] if failed else lines)
