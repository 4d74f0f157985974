"""Source tags and errata of the docstrings, and the table equation -> code made from them.

``python tests/source_tags.py`` writes docs/equations.md. A tag is ``[Vasylyev 2003, eq. (4)]``, ``[Volovyk 2022, eqs.
(15), (17)-(19)]`` or names another place of the paper, ``[Volovyk 2022, table 1, step 13]``. An erratum is a paragraph
``Erratum: printed ..., used ..., because ...``; it belongs to the tag or the equation number that it names, else to the
tags of its docstring.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("aircraft", "autopilot", "tracking", "sim")
TABLE = ROOT / "docs" / "equations.md"
COMMAND = "python tests/source_tags.py"

PAPERS: dict[str, dict[str, Any]] = tomllib.loads((ROOT / "tests" / "papers.toml").read_text())
MUTANTS: dict[str, dict[str, Any]] = tomllib.loads((ROOT / "tests" / "mutants" / "mutants.toml").read_text())

_NUMBERS = r"\(\d+\)(?:-\(\d+\))?"
_EQUATIONS = re.compile(rf"eqs?\. ({_NUMBERS}(?:, {_NUMBERS})*)")
_NAMES = "|".join(re.escape(paper["tag"]) for paper in PAPERS.values())
_TAG = re.compile(rf"\[({_NAMES}), ([^\[\]]+)\]")
_AUTHORS = "|".join({paper["tag"].split()[0] for paper in PAPERS.values()})
_LOOKS_LIKE_A_TAG = re.compile(rf"\[(?:{_AUTHORS})\b[^\[\]]*\]")
_ERRATUM = re.compile(r"^[ \t]*Erratum: (.+?)(?=\n[ \t]*\n|\n[ \t]*Erratum:|\Z)", re.MULTILINE | re.DOTALL)
_STEPS = {("volovyk2022", "table 1"): 15}


class Documented(NamedTuple):
    """A docstring and whose it is."""

    file: str
    name: str  # of the function, class or method; "" for a module
    text: str


class Tag(NamedTuple):
    """One place of one paper that a docstring claims."""

    paper: str  # key in papers.toml
    place: str  # "eq. (4)", "table 1, step 13"
    owner: Documented


class Erratum(NamedTuple):
    """Where a docstring leaves the print."""

    places: frozenset[tuple[str, str]]  # (paper, place)
    text: str
    owner: Documented


class Collection(NamedTuple):
    """Everything that the docstrings say about papers; ``problems`` are sentences."""

    tags: list[Tag]
    errata: list[Erratum]
    problems: list[str]


def docstrings(root: Path = ROOT) -> Iterator[Documented]:
    """Docstrings of all modules, classes and functions of the packages."""
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            file = path.relative_to(root).as_posix()
            yield from _of(ast.parse(path.read_text()), file, "")


def _of(node: Any, file: str, name: str) -> Iterator[Documented]:
    text = ast.get_docstring(node)
    if text:
        yield Documented(file, name, text)
    for child in node.body:
        if isinstance(child, ast.ClassDef | ast.FunctionDef):
            yield from _of(child, file, f"{name}.{child.name}" if name else child.name)


def places_of(paper: str, text: str) -> list[str]:
    """The single places that the inside of a tag names; ``ValueError`` says what is wrong with it."""
    places, rest, known = [], " ".join(text.split()), PAPERS[paper]
    while rest:
        equations = _EQUATIONS.match(rest)
        if equations:
            numbers = _expanded(equations[1])
            for number in numbers:
                if str(number) not in known["equations"]:
                    raise ValueError(f"there is no equation ({number})")
            places += [f"eq. ({number})" for number in numbers]
            rest = rest[equations.end() :]
        else:
            place = max((p for p in known["places"] if rest.startswith(p)), key=len, default=None)
            if place is None:
                raise ValueError(f"'{rest}' is no place of it")
            rest = rest[len(place) :]
            step = re.match(r", step (\d+)", rest)
            if step:
                if not 1 <= int(step[1]) <= _STEPS.get((paper, place), 0):
                    raise ValueError(f"{place} has no step {step[1]}")
                place += step[0]
                rest = rest[step.end() :]
            places.append(place)
        joint = re.match(r", | and |$", rest)
        if joint is None:
            raise ValueError(f"'{rest}' does not follow a comma")
        rest = rest[joint.end() :]
    return places


def _expanded(numbers: str) -> list[int]:
    expanded: list[int] = []
    for part in numbers.split(", "):
        ends = [int(number) for number in re.findall(r"\d+", part)]
        if len(ends) == 2 and ends[0] >= ends[1]:
            raise ValueError(f"the range {part} runs backwards")
        expanded += range(ends[0], ends[-1] + 1)
    return expanded


def collect(documented: Iterator[Documented] | list[Documented]) -> Collection:
    """Tags and errata, with a sentence for each one that the list of papers does not know."""
    found = Collection([], [], [])
    keys = {paper["tag"]: key for key, paper in PAPERS.items()}
    for owner in documented:
        where = f"{owner.file}:{owner.name or 'module'}"
        text = " ".join(owner.text.split())
        tags: list[Tag] = []
        for match in _TAG.finditer(text):
            try:
                tags += [Tag(keys[match[1]], place, owner) for place in places_of(keys[match[1]], match[2])]
            except ValueError as error:
                found.problems.append(f"{where}: {match[0]}: {error}")
        found.problems.extend(
            f"{where}: {strange} names no listed paper"
            for strange in _LOOKS_LIKE_A_TAG.findall(text)
            if not _TAG.fullmatch(strange) and strange[1:-1] not in keys
        )
        for match in _ERRATUM.finditer(owner.text):
            line = " ".join(match[1].split())
            if " used " not in line:
                found.problems.append(f"{where}: an erratum says what is printed, what is used and why: {line[:60]}")
            places = _places_of_erratum(line, tags, keys)
            if not any(places & set(_listed(paper, entry)) for paper, _, entry in errata_listed()):
                found.problems.append(f"{where}: papers.toml lists no such erratum: {line[:60]}")
            found.errata.append(Erratum(places, line, owner))
        found.tags.extend(tags)
    return found


def _places_of_erratum(line: str, tags: list[Tag], keys: dict[str, str]) -> frozenset[tuple[str, str]]:
    own = {(tag.paper, tag.place) for tag in tags}
    named = [(keys[match[1]], match[2]) for match in _TAG.finditer(line)]
    if named:
        return frozenset((paper, place) for paper, text in named for place in places_of(paper, text))
    printed = line.split("used")[0]
    numbers = {f"eq. ({number})" for number in re.findall(r"\((\d+)\)", printed)}
    chosen = {(paper, place) for paper in {paper for paper, _ in own} for place in numbers}
    return frozenset(chosen or own)


def errata_listed() -> Iterator[tuple[str, str, dict[str, Any]]]:
    """(paper, name, entry) of every listed erratum."""
    for paper, entry in PAPERS.items():
        for name, erratum in entry["errata"].items():
            yield paper, name, erratum


def _listed(paper: str, erratum: dict[str, Any]) -> list[tuple[str, str]]:
    return [(paper, place) for place in erratum["places"]]


def untagged(tags: list[Tag]) -> list[tuple[str, str]]:
    """(paper, equation number) that should be in the code and that no tag names."""
    tagged = {(tag.paper, tag.place) for tag in tags}
    return [
        (paper, number)
        for paper, entry in PAPERS.items()
        for number in entry["equations"]
        if number not in entry["background"] and (paper, f"eq. ({number})") not in tagged
    ]


def unmarked(collection: Collection) -> list[tuple[str, str]]:
    """(paper, erratum) of places that the code implements without an ``Erratum:`` line for them; not those of prose."""
    marked = {place for erratum in collection.errata for place in erratum.places}
    tagged = {(tag.paper, tag.place) for tag in collection.tags}
    return [
        (paper, name)
        for paper, name, erratum in errata_listed()
        if "no_mutant" not in erratum
        and set(_listed(paper, erratum)) & tagged
        and not set(_listed(paper, erratum)) & marked
    ]


def table(collection: Collection) -> str:
    """docs/equations.md."""
    lines = [
        "# Equations of the papers and where they are",
        "",
        f"Made by `{COMMAND}` from the source tags of the docstrings and from `tests/papers.toml`; a test",
        "fails when it is stale. A mutant puts a misprint or a known trap into the code, and the tests must fail.",
    ]
    for paper, entry in PAPERS.items():
        if not entry["equations"]:
            continue
        lines += ["", f"## {entry['tag']}", "", "| place | what it is | code | mutants |", "|---|---|---|---|"]
        places = {f"eq. ({number})": what for number, what in entry["equations"].items()} | entry["places"]
        for tag in collection.tags:
            if tag.paper == paper and tag.place not in places:
                places[tag.place] = entry["places"][tag.place.split(", step")[0]]
        for place, what in places.items():
            owners = dict.fromkeys(tag.owner for tag in collection.tags if (tag.paper, tag.place) == (paper, place))
            code = ", ".join(_link(owner) for owner in owners)
            number = place[5:-1] if place.startswith("eq. (") else ""
            if not code and number in entry["background"]:
                code = f"none: {entry['background'][number]}"
            if code or number:
                lines.append(f"| {place} | {what} | {code or 'none yet'} | {', '.join(proofs(paper, place))} |")
        if entry["errata"]:
            lines += ["", "| erratum | printed | used | because | mutants |", "|---|---|---|---|---|"]
            for name, erratum in entry["errata"].items():
                at = ", ".join(erratum["places"])
                lines.append(
                    f"| {at} | {erratum['printed']} | {erratum['used']} | {erratum['why']} | "
                    f"{_guards(paper, name) or erratum.get('no_mutant', 'none yet')} |"
                )
        if entry["traps"]:
            lines += ["", "| trap | what goes wrong | mutants |", "|---|---|---|"]
            for name, trap in entry["traps"].items():
                guards = _guards(paper, name) or trap.get("no_mutant", "none yet")
                lines.append(f"| {', '.join(trap['places'])} | {trap['about']} | {guards} |")
    return "\n".join(lines) + "\n"


def proofs(paper: str, place: str) -> list[str]:
    """Mutants that break what a place of a paper says."""
    entry = PAPERS[paper]
    return [
        name
        for name, mutant in MUTANTS.items()
        if f"{paper} {place}" in mutant.get("equations", [])
        or any(place in _places_guarded(entry, guard, paper) for guard in mutant["guards"])
    ]


def _places_guarded(entry: dict[str, Any], guard: str, paper: str) -> list[str]:
    owner, name = guard.split(".")
    if owner != paper:
        return []
    return list((entry["errata"].get(name) or entry["traps"][name])["places"])


def _link(owner: Documented) -> str:
    label = f"{owner.file}:{owner.name}" if owner.name else owner.file
    return f"[`{label}`](../{owner.file})"


def _guards(paper: str, name: str) -> str:
    return ", ".join(mutant for mutant, entry in MUTANTS.items() if f"{paper}.{name}" in entry["guards"])


if __name__ == "__main__":
    TABLE.parent.mkdir(exist_ok=True)
    TABLE.write_text(table(collect(docstrings())))
