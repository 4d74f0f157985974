"""What a broken check says: what was asked, what was flown, when, and who asks."""

from __future__ import annotations

from typing import Any

UNIT_WORDS = {"mps": "m/s", "mps2": "m/s2", "degps": "deg/s", "": ""}


def phases(check: dict[str, Any]) -> str:
    """The phases of a check in words."""
    during = check["during"]
    return during if isinstance(during, str) else " or ".join(during)


def broken(check: dict[str, Any]) -> str:
    """A check that one flight did not keep."""
    limit = with_unit(check["limit"], check)
    source = f"; source: {check['source'] or 'not given'}"
    if check["value"] is None:
        return f"{check['name']}: the flight has no {check['metric']}, limit {limit}{source}"
    when = "" if check["time_s"] is None else f" at {check['time_s']:.1f} s"
    statistic = "" if check["statistic"] == "max" else f" ({check['statistic']})"
    lasting = f" for {check['for_s']:g} s" if check["for_s"] else ""
    return (
        f"{check['name']}: {check['metric']}{statistic} = {with_unit(check['value'], check)}{lasting}{when}, "
        f"limit {limit}, beyond it by {with_unit(-check['margin'], check)}{source}"
    )


def broken_in_study(check: dict[str, Any]) -> str:
    """A check that the flights of a study did not keep: how many did, the worst of them, and where it is."""
    limit = with_unit(check["limit"], check)
    kept = f"{check['name']}: {check['within']} of {check['flights']} flights keep {check['metric']}, limit {limit}"
    worst = None if check["value"] is None else with_unit(check["value"], check)
    if check["share"] < 1.0:
        asked = f"{100 * check['share']:g} % with {100 * check['confidence']:g} % confidence"
        kept += f"; {asked} are shown to keep {worst or 'no limit'}"
    elif worst is not None:
        where = ", ".join(f"{name} = {_value(value)}" for name, value in check["at"].items())
        kept += f"; the worst has {worst} with {where}"
    return f"{kept}; source: {check['source'] or 'not given'}"


def with_unit(value: float, check: dict[str, Any]) -> str:
    """Four figures of a value and the unit of its check."""
    return f"{value:.4g} {UNIT_WORDS.get(check['unit'], check['unit'])}".rstrip()


def _value(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
