"""Checks that failed, in one sentence each: value, limit, flight, seed, time, source, and how to fly it again."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from sim.scenario.toml_writer import inline

UNIT_WORDS = {"mps": "m/s", "mps2": "m/s2", "degps": "deg/s", "": ""}
Table = Mapping[str, Any]
Again = Callable[[int, Table], str]
"""How one flight is flown again, by its number and the values that are chosen for it."""


def broken_checks(metrics: Table, again: Again) -> list[str]:
    """A sentence for each check that failed, from metrics.json; ``again`` as in `broken`."""
    return [broken(check, metrics, again) for check in metrics["checks"] if check["passed"] is False]


def broken(check: Table, metrics: Table, again: Again) -> str:
    """A check that failed: how many flights kept it where there are several, and the flight that decides.

    ``again`` is how to fly that one again, as `run_again` gives it; ``metrics`` has the seed, and of a study the axes.
    """
    where = ", ".join(
        [f"flight {check['flight']}", f"seed {metrics['seed']}"]
        + [f"{address} = {_value(value)}" for address, value in check["at"].items()]
    )
    source = f"source: {check['source'] or 'not given'}"
    how = again(check["flight"], chosen(check["at"], metrics))
    if check["flights"] == 1:
        return f"{check['name']}: {_found(check)}; {source}; {where}: {how}"
    return f"{check['name']}: {_count(check, metrics)}; {_found(check)}; {source}; {where}: {how}"


def _count(check: Table, metrics: Table) -> str:
    judged = check["flights"] - check["not_flown"]
    cell = " of a cell" if check["confidence"] is not None and len(metrics.get("rows", ())) > 1 else ""
    kept = f"{check['within']} of {judged} flights{cell} keep it"
    if check["not_flown"]:
        kept += f", {check['not_flown']} more did not fly {phases(check)}"
    if check["confidence"] is not None:
        shown, asked, confidence = (100 * check[key] for key in ("share_low", "share", "confidence"))
        kept += f", which shows {shown:.3g} % with {confidence:g} % confidence where {asked:g} % are asked"
    return kept


def _found(check: Table) -> str:
    """What the deciding flight did."""
    limit = with_unit(check["limit"], check)
    if check["value"] is None:
        lacks = "crashed" if check["outcome"] == "crashed" else f"has no {check['metric']}"
        return f"the flight {lacks}, limit {limit}"
    when = "" if check["time_s"] is None else f" at {check['time_s']:.1f} s"
    statistic = "" if check["statistic"] == "max" else f" ({check['statistic']})"
    lasting = f" for {check['for_s']:g} s" if check["for_s"] else ""
    found = f"{check['metric']}{statistic} = {with_unit(check['value'], check)}{lasting}{when}, limit {limit}"
    return found if check["margin"] >= 0 else f"{found}, beyond it by {with_unit(-check['margin'], check)}"


def chosen(values: Table, metrics: Table) -> dict[str, Any]:
    """Those of a flight's values that a study chose; what is drawn follows from the number of the flight."""
    return {
        address: values[address]
        for address, axis in metrics.get("axes", {}).items()
        if "values" in axis and address in values
    }


def run_again(file: Any, plugins: Iterable[Any] = ()) -> Again:
    """The command that flies a flight of a file again, as it is typed into a shell."""
    start = f"shortfinal run {shlex.quote(str(file))}"
    brought = "".join(f" --plugin {shlex.quote(str(one))}" for one in plugins)

    def command(flight: int, values: Table) -> str:
        sets = "".join(f" --set {shlex.quote(f'{address}={inline(value)}')}" for address, value in values.items())
        return f"{start}{sets}{brought} --flight {flight}"

    return command


def phases(check: Table) -> str:
    """The phases of a check in words."""
    during = check["during"]
    return str(during) if isinstance(during, str) else " or ".join(during)


def with_unit(value: float, check: Table) -> str:
    """Four figures of a value and the unit of its check."""
    return f"{value:.4g} {UNIT_WORDS.get(check['unit'], check['unit'])}".rstrip()


def _value(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
