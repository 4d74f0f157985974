"""Where the keys of a TOML file stand: a scan of its text, since the parser of the standard library tells no lines."""

from __future__ import annotations

import re
from collections.abc import Iterator

Place = tuple[str | int, ...]

HEADER = re.compile(r"\s*(\[\[?)\s*([^\]#]+?)\s*\]")
KEY = re.compile(
    r"\s*((?:[A-Za-z0-9_-]+|\"[^\"\n]*\"|'[^'\n]*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|\"[^\"\n]*\"|'[^'\n]*'))*)\s*="
)
PART = re.compile(r"[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*'")
TOLD = re.compile(r"\[{1,2}([^\]\s]+)\]{1,2}(?: entry (\d+))?:? ?(.*)", re.DOTALL)  # the place that a fault begins with
QUOTED = re.compile(r"'([^']+)'")
WORD = re.compile(r"'?([A-Za-z0-9_.-]+)'?")


def lines(text: str) -> dict[Place, int]:
    """The line, from 1, of every table and key of a TOML text; entries of an array of tables have their number."""
    found: dict[Place, int] = {}
    counts: dict[Place, int] = {}
    table: Place = ()
    for number, line in _starts(text):
        header, key = HEADER.match(line), KEY.match(line)
        if key is not None:
            found.setdefault((*table, *parts(key[1])), number)
        elif header is not None:
            table = _entries(parts(header[2]), counts)
            if header[1] == "[[":
                counts[table] = counts.get(table, -1) + 1
                table = (*table, counts[table])
            found.setdefault(table, number)
    return found


def line_of(fault: str, text: str, found: dict[Place, int] | None = None) -> int | None:
    """The line of a fault, which begins with its place: ``[table] entry N key``, or the key itself; None = unknown.

    ``found`` are the `lines` of the text, where they are known already.
    """
    found, rows = lines(text) if found is None else found, text.splitlines()
    told = TOLD.match(fault)
    table, rest = ((), fault) if told is None else (parts(told[1]), told[3])
    if told is not None and told[2] is not None:
        table = (*table, int(told[2]))
    elif told is not None and (entry := re.match(r"entry (\d+)", rest)):
        table = (*table, int(entry[1]))
    words = [word.strip(".") for word in WORD.findall(rest)]
    for word in words[:1] if told is None else words:
        keys = [place for place in found if place[:-1] == table and is_named(str(place[-1]), word)]
        if keys:  # and in it, what is named in quotes, as an axis is
            inner = [place for place in found if place[:-1] == keys[0] and is_quoted(str(place[-1]), rest)]
            return found[(*inner, *keys)[0]]
    inner = [place for place in found if table and place[:-2] == table and is_quoted(str(place[-1]), rest)]
    if inner:
        return found[inner[0]]
    quoted = [f'"{value}"' for value in QUOTED.findall(rest)]
    for place, number in found.items() if table else ():  # of a value
        if place[:-1] == table and any(value in rows[number - 1] for value in quoted):
            return number
    while table:
        if table in found:
            return found[table]
        inside = [line for place, line in found.items() if place[: len(table)] == table]
        if inside:  # a table that has no header of its own
            return min(inside)
        table = table[:-1]
    return None


def is_named(key: str, word: str) -> bool:
    """Whether a word of a fault is a key, or what it sets whatever its unit."""
    return key == word or re.fullmatch(rf"(indicated_)?{re.escape(word)}_[a-z0-9]+(_per_[a-z]+)?", key) is not None


def is_quoted(key: str, fault: str) -> bool:
    """Whether a fault names a key in quotes."""
    return f'"{key}"' in fault or f"'{key}'" in fault


def _entries(parts: Place, counts: dict[Place, int]) -> Place:
    """A table's address with the number of the last entry of each array of tables on its way, but not of itself."""
    table: Place = ()
    for part in parts[:-1]:
        table = (*table, part)
        if table in counts:
            table = (*table, counts[table])
    return (*table, parts[-1]) if parts else table


def parts(dotted: str) -> Place:
    """The keys of a dotted address, of which some may be in quotes."""
    return tuple(part.strip("\"'") for part in PART.findall(dotted))


def _starts(text: str) -> Iterator[tuple[int, str]]:
    """The lines on which something begins: not those within an array or a text of several lines."""
    depth, within = 0, ""
    for number, line in enumerate(text.splitlines(), 1):
        if depth == 0 and not within:
            yield number, line
            if HEADER.match(line) and not KEY.match(line):
                continue
        depth, within = _after(line, depth, within)


def _after(line: str, depth: int, within: str) -> tuple[int, str]:
    """How deep in arrays, and within which quotes, a line ends."""
    place = 0
    while place < len(line):
        three, letter = line[place : place + 3], line[place]
        if within:
            if letter == "\\" and within.startswith('"'):
                place += 1
            elif line.startswith(within, place):
                place += len(within) - 1
                within = ""
        elif three in ('"""', "'''"):
            within, place = three, place + 2
        elif letter in "\"'":
            within = letter
        elif letter == "#":
            break
        else:
            depth = max(depth + (letter in "[{") - (letter in "]}"), 0)
        place += 1
    return depth, within if len(within) == 3 else ""  # a plain text ends with its line
