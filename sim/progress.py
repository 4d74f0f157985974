"""A progress bar with rate and remaining time, for people at a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any


def bar(items: Iterable[Any], total: int, what: str) -> Iterator[Any]:
    """The items, with their progress shown on standard error."""
    from rich.console import Console
    from rich.progress import track

    yield from track(items, what, total=total, console=Console(stderr=True), transient=True)
