"""Docstrings as the reference shows them: what stands behind the name of a parameter are words, no type."""

from __future__ import annotations

import re

SECTION = re.compile(r"^Parameters\n-+\n(?P<entries>.*?)(?P<rest>^(?:Raises|Returns) .*|\Z)", re.MULTILINE | re.DOTALL)
ENTRY = re.compile(r"^(?P<name>[\w*, ]+) : (?P<words>.*)$", re.MULTILINE)


def with_words(docstring: str) -> str:
    """Parameters with their words on a line of their own; a sentence about errors behind them goes before them."""

    def section(found: re.Match[str]) -> str:
        entries = ENTRY.sub(r"\g<name>\n    \g<words>", found["entries"])
        return f"{found['rest']}\n\nParameters\n----------\n{entries}"

    return SECTION.sub(section, docstring)
