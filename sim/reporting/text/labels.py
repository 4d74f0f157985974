"""Names with unit suffixes as words, and numbers with as many digits as they deserve."""

from __future__ import annotations

import math
import re
from typing import Any

from aircraft.units import SUFFIXES
from sim.metrics import signals, table

ABSENT = "–"
_SHOWN = {
    "mps": "m/s",
    "mps2": "m/s²",
    "degps": "deg/s",
    "deg_per_m": "deg/m",
    "deg_per_mps": "deg/(m/s)",
    "m2ps3": "m²/s³",
    "deg2ps3": "deg²/s³",
    "deg2": "deg²",
    "fpm": "ft/min",
    "fps": "ft/s",
    "hz": "Hz",
    "kmh": "km/h",
    "nmi": "NM",
    "n": "N",
    "db": "dB",
}
_JOINED = {"cross track": "cross-track", "past threshold": "past the threshold", "rms": "RMS", "rmse": "RMSE"}


def unit(suffix: str) -> str:
    """A unit suffix as it is printed."""
    return _SHOWN.get(suffix, suffix)


def split(name: str) -> tuple[str, str]:
    """(words, printed unit) of a name such as ``cross_track_rms_final_m``."""
    endings = [suffix for suffix in SUFFIXES if name.endswith(f"_{suffix}") or name == suffix]
    suffix = max(endings, key=len, default="")
    return words(name[: -len(suffix) - 1] if suffix else name), unit(suffix)


def named(name: str) -> tuple[str, str]:
    """(label, printed unit) of a figure or a signal by its row in the tables of metrics; of anything else, split."""
    row = table.find(name) or signals.find(name)
    return (row.label, unit(row.unit)) if row is not None else split(name)


def words(name: str) -> str:
    """An identifier as words: ``final_turn`` is "final turn", ``intent_imm`` is "intent IMM"."""
    text = name.replace("_", " ").replace(".", ": ")
    for plain, joined in _JOINED.items():
        text = re.sub(rf"\b{plain}\b", joined, text)
    return re.sub(r"\bimm\b", "IMM", text)


def decimals(*values: float | None) -> int:
    """Decimal places that show the greatest of the values to three or four figures."""
    greatest = max((abs(v) for v in values if v is not None and math.isfinite(v)), default=0.0)
    if greatest >= 1000:
        return 0
    if greatest >= 100:
        return 1
    return 2 if greatest >= 1 else 3


def number(value: Any, places: int | None = None) -> str:
    """A value for a table: a dash where there is none, a minus sign that is one."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ABSENT
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if not isinstance(value, float):
        return str(value)
    if places is None:
        places = decimals(value)
    text = f"{value:.{places}f}"
    if float(text) == 0:
        text = text.removeprefix("-")
    return text.replace("-", "−")


def column(values: list[Any]) -> list[str]:
    """Numbers of one column with the same decimal places, so that the digits line up."""
    numbers = [None if v is None else float(v) for v in values]
    places = decimals(*numbers)
    return [number(v, places) for v in numbers]


def duration(seconds: float) -> str:
    """A time span in words: "9 min 21 s", "41 s"; tenths below ten seconds, hundredths below one."""
    if seconds < 1:
        return f"{seconds:.2f} s"
    if seconds < 10:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def joined(names: list[str]) -> str:
    """Names as a list in a sentence: "a, b and c"."""
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))
