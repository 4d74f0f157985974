"""Source tags against the list of what the papers contain, and errata against the mutants that prove them."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parent.parent


def load(path: Path) -> ModuleType:
    """A module beside the tests: they are no package."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


source_tags = load(ROOT / "tests" / "source_tags.py")
PAPERS, MUTANTS = source_tags.PAPERS, source_tags.MUTANTS
GUARDED = [(paper, kind, name) for paper in PAPERS for kind in ("errata", "traps") for name in PAPERS[paper][kind]]


@pytest.fixture(scope="module")
def collection():
    return source_tags.collect(source_tags.docstrings())


def of(text: str):
    """What the collector makes of one docstring."""
    return source_tags.collect([source_tags.Documented("tracking/example.py", "example", text)])


def test_every_tag_names_something_that_its_paper_has(collection):
    assert not collection.problems, "\n".join(collection.problems)


def test_every_equation_to_implement_is_in_the_code(collection):
    missing = [f"{PAPERS[paper]['tag']}, eq. ({number})" for paper, number in source_tags.untagged(collection.tags)]
    assert not missing


def test_every_erratum_of_code_that_exists_is_said_beside_it(collection):
    assert not source_tags.unmarked(collection)


def test_the_table_of_equations_is_fresh(collection):
    fresh = source_tags.TABLE.read_text() == source_tags.table(collection)
    assert fresh, f"docs/equations.md is stale: run `{source_tags.COMMAND}`"


@pytest.mark.parametrize(("paper", "kind", "name"), GUARDED, ids=lambda part: part)
def test_every_erratum_and_trap_has_a_mutant(paper, kind, name, collection):
    """And the mutant bites in a file that carries the tag of the erratum's place, so the tag is more than a word."""
    entry = PAPERS[paper][kind][name]
    mutants = [mutant for mutant in MUTANTS.values() if f"{paper}.{name}" in mutant["guards"]]
    assert bool(mutants) != ("no_mutant" in entry), "either a mutant or the reason why there is none"
    tagged = {(tag.paper, tag.place, tag.owner.file) for tag in collection.tags}
    for mutant in mutants:
        homes = {(paper, place, mutant["file"]) for place in entry["places"]}
        assert homes & tagged or mutant.get("helper"), f"{mutant['file']} does not say that it holds {entry['places']}"


def test_every_figure_to_redraw_is_a_place():
    for paper in PAPERS.values():
        assert set(paper["figures"]) <= set(paper["places"])


def test_every_equation_in_the_code_has_a_mutant(collection):
    """A tag is a claim that something computes this equation; a test must fail when it does not."""
    unproven = {
        f"{tag.paper} {tag.place}"
        for tag in collection.tags
        if tag.place.startswith("eq. (") and tag.place[5:-1] not in PAPERS[tag.paper]["background"]
        if not source_tags.proofs(tag.paper, tag.place)
    }
    assert not unproven


def test_every_mutant_bites_where_its_equation_is(collection):
    tagged = {(f"{tag.paper} {tag.place}", tag.owner.file) for tag in collection.tags}
    wrong = [
        f"{name}: {mutant['file']} does not hold {equation}"
        for name, mutant in MUTANTS.items()
        for equation in mutant.get("equations", [])
        if (equation, mutant["file"]) not in tagged
    ]
    assert not wrong


def test_every_mutant_guards_something_listed():
    listed = {f"{paper}.{name}" for paper, _, name in GUARDED}
    strays = {guard for mutant in MUTANTS.values() for guard in mutant["guards"]} - listed
    assert not strays


def test_every_listed_place_exists():
    for paper, _, name in GUARDED:
        entry = PAPERS[paper].get("errata", {}).get(name) or PAPERS[paper]["traps"][name]
        for place in entry["places"]:
            assert source_tags.places_of(paper, place) == [place], name


@pytest.mark.parametrize(
    ("inside", "places"),
    [
        ("eq. (4)", ["eq. (4)"]),
        ("eqs. (15), (17)-(19)", ["eq. (15)", "eq. (17)", "eq. (18)", "eq. (19)"]),
        ("table 1, step 13", ["table 1, step 13"]),
        ("eq. (23), table 1, step 4", ["eq. (23)", "table 1, step 4"]),
        ("fig. 2", ["fig. 2"]),
    ],
)
def test_tags_are_read(inside, places):
    assert source_tags.places_of("volovyk2022", inside) == places


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("Something [Volovyk 2022, eq. (24)].", "no equation (24)"),
        ("Something [Volovyk 2022, eqs. (22)-(24)].", "no equation (24)"),
        ("Something [Volovyk 2022, eqs. (5)-(4)].", "runs backwards"),
        ("Something [Volovyk 2022, fig. 9].", "no place"),
        ("Something [Volovyk 2022, table 1, step 16].", "no step 16"),
        ("Something [Volovyk 2022, eq. 4].", "no place"),
        ("Something [Volovyk 2021, eq. (4)].", "no listed paper"),
        ("Something [Vasylyev 2003 eq. (4)].", "no listed paper"),
        ("Something [Vasylyev 2003, eq. (8)].\\n\\nErratum: printed omega wrong.", "what is used"),
        ("Something [Vasylyev 2003, eq. (2)].\\n\\nErratum: printed U, used V, because.", "no such erratum"),
    ],
)
def test_wrong_tags_are_found(text, says):
    problems = of(text.replace("\\n", "\n")).problems
    assert any(says in problem for problem in problems), problems


def test_an_erratum_belongs_to_the_equation_that_it_names():
    text = "X [Volovyk 2022, eqs. (15)-(18)].\n\nErratum: (15) printed a and (17) b,\nused c, because d."
    (erratum,) = of(text).errata
    assert erratum.places == {("volovyk2022", "eq. (15)"), ("volovyk2022", "eq. (17)")}
    other = "X [Volovyk 2022, eq. (4)].\n\nErratum: [Volovyk 2022, eq. (7)] printed twice, used once, because e."
    assert of(other).errata[0].places == {("volovyk2022", "eq. (7)")}
