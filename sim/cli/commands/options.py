"""Options and arguments that several commands share, and what becomes of them."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from sim.errors import ScenarioError

DEFAULT = "an26_pattern"  # the scenario of who names none

Scenario = Annotated[str, typer.Argument(help="A scenario file or the name of a bundled scenario.")]
Out = Annotated[Path | None, typer.Option("-o", "--out", help="Folder to write; default out/NAME.")]
Sets = Annotated[
    list[str] | None, typer.Option("--set", metavar="TABLE.KEY=VALUE", help="Replace one value; repeatable.")
]
Plugins = Annotated[
    list[Path] | None,
    typer.Option("--plugin", metavar="FILE", help="Python file with kinds that the scenario names; repeatable."),
]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Say errors and the last line alone.")]
Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Say also what takes how long, and all warnings.")]
Workers = Annotated[
    int | None, typer.Option("-j", "--workers", min=1, help="Worker processes; default one for each core.")
]


def _without_cache(asked: bool) -> bool:
    """Switch the cache of the user off, for this process and those that it starts."""
    from sim.cache.user_cache import OFF, SWITCH

    if asked:
        os.environ[SWITCH] = OFF
    return asked


NoCache = Annotated[
    bool,
    typer.Option(
        "--no-cache", callback=_without_cache, help="Use and leave nothing in the user's cache folder (see doctor)."
    ),
]


def overrides_of(sets: list[str] | None, **named: int | None) -> dict[str, Any]:
    """Values by their address that ``--set`` and options of their own put in place of those of a scenario.

    Raises ``ScenarioError`` for what is no address and value.
    """
    import tomllib

    overrides: dict[str, Any] = {}
    for item in sets or []:
        address, equals, text = item.partition("=")
        if not equals or not address.strip():
            raise ScenarioError(f"--set {item}: write it as table.key=value")
        try:
            read = tomllib.loads(f"value = {text}")
        except (ValueError, RecursionError):  # also of a number with thousands of digits
            read = {}
        overrides[address.strip()] = read["value"] if len(read) == 1 else text.strip()  # an unquoted word
    return overrides | {key: value for key, value in named.items() if value is not None}


def progress_bar() -> Any:
    """A progress bar on a terminal, silence elsewhere."""
    if not sys.stderr.isatty():
        return None
    from sim.cli.terminal import bar

    return bar
