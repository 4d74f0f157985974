"""One self-contained HTML page about a study: how all flights ended, figures over the axes, the table of cells."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sim.metrics.ensemble.exceedance import answer, percent
from sim.metrics.ensemble.verdict import worst_first
from sim.reporting.page import picture, rendered
from sim.reporting.text.broken_checks import Again, broken_checks
from sim.reporting.text.labels import ABSENT, words
from sim.reporting.text.rows import every_flight, flights_of, kept_by
from sim.scenario.toml_writer import dumps
from sim.studies.figures import figure_of, study_charts
from sim.studies.limits.answer import question
from sim.studies.limits.drawing import ratio_chart
from sim.studies.limits.maps import RatioMap
from sim.studies.metrics import named
from sim.versions import rows

MOST_ROWS = 500  # of the table on the page; metrics.json has them all
WORST = 20  # flights that are listed
USUAL = ("overshoot_m", "settling_s", "time_saturated_s", "bank_max_deg")
MANY = 10_000


def page(
    scenario: Any,
    metrics: dict[str, Any],
    records: Sequence[dict[str, Any]],
    again: Again,
    maps: Sequence[RatioMap] = (),
) -> str:
    """The text of report.html, from metrics.json, the sorted log and the maps of a contrast.

    ``again`` is how a flight is flown again.
    """
    shown = shown_metrics(scenario, metrics)
    charts = [*map(ratio_chart, maps), *study_charts(scenario, metrics, records, shown)]
    predicted = metrics.get("predicted", {})
    ended = ", ".join(f"{count} {words(name)}" for name, count in sorted(metrics["outcomes"].items()))
    told = f"{flights_of(metrics)}: {ended}"
    answered = metrics.get("answer") or (f"{answer(metrics)}." if "exceedances" in metrics else "")
    return rendered(
        "study.html",
        name=scenario.name,
        question=question(scenario.contrasts[0]) if maps else "",
        sentence=answered or f"{told}.",
        ended=f"{told}." if answered else "",
        good=all(check["passed"] is not False for check in metrics["checks"]) and "crashed" not in metrics["outcomes"],
        failed=broken_checks(metrics, again),
        charts=[*map(picture, charts)],
        checks=[_check(check) for check in metrics["checks"]],
        exceedances=[_exceedance(one) for one in metrics.get("exceedances", ())],
        worst=_worst(scenario, metrics, records, again),
        axes=[_axis(address, axis) for address, axis in metrics["axes"].items()],
        heads=[*metrics["axes"], "flights", "outcomes", *shown, *(f"{name} by theory" for name in predicted)],
        rows=[
            [*_row(row, metrics["axes"], shown), *(_value(column[i]) for column in predicted.values())]
            for i, row in enumerate(metrics["rows"][:MOST_ROWS])
        ],
        left_out=max(0, len(metrics["rows"]) - MOST_ROWS),
        seed=metrics["seed"],
        versions=rows(metrics["versions"]),
        scenario_text=dumps(scenario.tables),
    )


def shown_metrics(scenario: Any, metrics: dict[str, Any]) -> list[str]:
    """The figures that the study asks for, else those of its checks or the usual ones, and how far its trackers err.

    Only what was flown.
    """
    flown = {name for row in metrics["rows"] for name in row}

    def known(names: Sequence[str]) -> list[str]:
        return [name for name in dict.fromkeys(names) if all(part in flown for part in name.split(" / "))]

    trackers = [name for tracker in scenario.trackers for name in _errors(tracker, metrics["rows"])]
    judged = known([check["metric"] for check in metrics["checks"]])
    return known(scenario.study.show) or [*dict.fromkeys([*trackers, *(judged or known(USUAL))])]


def _errors(tracker: str, rows: Sequence[dict[str, Any]]) -> list[str]:
    """The RMSE of a tracker in the position, or in the first channel that it has; none where it never tracked."""
    start, end = f"trackers.{tracker}.overall.", ".rmse"
    names = dict.fromkeys(name for row in rows for name in row if name.startswith(start) and name.endswith(end))
    return [*([name] if (name := f"{start}position_m{end}") in names else names)][:1]


def _axis(address: str, axis: dict[str, Any]) -> tuple[str, str]:
    (kind, values), *_ = axis.items()
    text = ", ".join(_pair(*value) if kind == "quantiles" else _value(value) for value in values)
    return address, text if kind == "values" else f"{words(kind)} {text}"


def _worst(
    scenario: Any, metrics: dict[str, Any], records: Sequence[dict[str, Any]], again: Again
) -> list[dict[str, Any]]:
    """The worst flights: how each ended, what is varied in it, and the command that flies it again."""
    worst = [named(record, scenario.study.varied, again) for record in worst_first(records)[:WORST]]
    rows = every_flight(worst, [one["name"] for one in metrics["checks"]])
    return [
        {**row, "again": record["again"], "varied": _varied(record["values"], metrics["axes"])}
        for row, record in zip(rows, worst, strict=True)
    ]


def _varied(values: dict[str, Any], axes: dict[str, Any]) -> str:
    return ", ".join(f"{address} = {_value(values[address])}" for address in axes)


def _pair(share: float, value: float) -> str:
    return f"{100 * share:g} % up to {_value(value)}"


def _exceedance(one: dict[str, Any]) -> dict[str, Any]:
    between = f"{percent(one['low'])} to {percent(one['high'])} %"
    below = f"below {percent(one['below'])} % with {100 * one['confidence']:g} % confidence"
    return {**one, "probability": f"{percent(one['probability'])} %", "between": between, "below": below}


def _value(value: Any) -> str:
    """Four figures of a number, or the whole ones where they are more, a dash for none, words as they are."""
    if value is None:
        return ABSENT
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    whole = MANY <= abs(value) < 100 * MANY  # which four figures would write with an exponent
    return f"{value:{'.0f' if whole else '.4g'}}".replace("-", "\N{MINUS SIGN}")


def _row(row: dict[str, Any], axes: dict[str, Any], shown: Sequence[str]) -> list[str]:
    cells = [_spread(row[address]) if "values" not in axis else _value(row[address]) for address, axis in axes.items()]
    ended = ", ".join(f"{count} {words(name)}" for name, count in sorted(row["outcomes"].items()))
    return [*cells, str(sum(row["outcomes"].values())), ended, *(_spread(figure_of(row, name)) for name in shown)]


def _spread(found: dict[str, Any] | None) -> str:
    if found is None:
        return ABSENT
    if found["n"] == 1:
        return _value(found["p50"])
    return f"{_value(found['p50'])} ({_value(found['p5'])} to {_value(found['p95'])})"


def _check(check: dict[str, Any]) -> dict[str, Any]:
    asked = "every flight" if check["confidence"] is None else f"{100 * check['share']:g} % of flights"
    numbers = {key: _value(check[key]) for key in ("value", "limit", "margin")}
    verdict = {None: ("open", "not flown"), True: ("held", "held"), False: ("broken", "broken")}[check["passed"]]
    kept = {"asked": asked, "kept": kept_by(check), "look": verdict[0], "verdict": verdict[1]}
    return {**check, **numbers, **kept, "source": check["source"] or ABSENT}
