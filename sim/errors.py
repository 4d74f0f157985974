"""Errors that speak to the user: what, where, what is allowed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

LONGEST_LINE = 1000  # characters of one fault


class ScenarioError(ValueError):
    """A scenario that cannot be run; one line per fault, each with its place and the mend."""


class OutputError(ValueError):
    """A folder that cannot be written, or was written by something else."""


def printable(line: str) -> str:
    """A line that a terminal shows as it is: nothing that moves the cursor or breaks the line, and no end of it."""
    shown = "".join(c if c.isprintable() else repr(c)[1:-1] for c in line[:LONGEST_LINE])
    return shown + ("..." if len(line) > LONGEST_LINE else "")


def did_you_mean(word: str, allowed: Iterable[str]) -> str:
    """A suggestion clause, or all that is allowed when nothing is near."""
    names = sorted(allowed)
    near = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    if near:
        return f"did you mean '{near[0]}'?"
    return f"allowed: {', '.join(names)}" if names else "there are none"
