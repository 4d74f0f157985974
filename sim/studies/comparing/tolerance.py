"""The file that says how far each metric may move: ``"touchdown.sink_mps" = 0.3``, or in tables of these names."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from sim.errors import OutputError, did_you_mean, printable
from sim.files import read_bytes
from sim.metrics import table


def tolerances(source: Any, known: Iterable[str]) -> dict[str, float]:
    """The tolerances of a file, or of a dict, by metric; ``known`` are the metrics that are compared.

    Raises ``OutputError`` in one sentence.
    """
    place = "tolerance" if isinstance(source, dict) else str(source)
    tables = source if isinstance(source, dict) else _read(Path(source))
    found, known = {}, [*known]
    for metric, value in _flat(tables):
        if metric not in known:
            elsewhere = "a metric that neither side has" if metric in table.names() else "no such metric"
            raise OutputError(printable(f"{place}: {metric}: {elsewhere}; {did_you_mean(metric, known)}"))
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value < math.inf:
            raise OutputError(printable(f"{place}: {metric}: must be a number of at least 0, not {value!r}"))
        found[metric] = float(value)
    if not found:
        raise OutputError(f'{place}: names no metric; write METRIC = NUMBER, such as "touchdown.sink_mps" = 0.3')
    return found


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(read_bytes(path).decode("utf-8-sig"))
    except FileNotFoundError:
        raise OutputError(f"{path}: no such file") from None
    except OSError as error:
        raise OutputError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise OutputError(printable(f"{path}: not TOML: {error}")) from None


def _flat(tables: dict[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in tables.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{above}{key}.")
        else:
            yield above + key, value
