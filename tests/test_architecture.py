"""The decided structure, read from the source: who imports whom, where units and randomness live."""

from __future__ import annotations

import ast
import builtins
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from aircraft.units import SUFFIXES

ROOT = Path(__file__).resolve().parent.parent
OURS = ("aircraft", "autopilot", "tracking", "sim")

# package -> what of ours it may import besides itself; "sim" may import all
MAY_IMPORT = {"aircraft": (), "tracking": (), "autopilot": ("aircraft.ranges", "aircraft.state", "aircraft.units")}

# the rooms of sim in reading order: each may import those before it; what stands in one line is one room
ROOMS = (
    ("errors", "randomness", "files", "versions", "cache"),  # the ground
    ("scenario",),
    ("workers",),
    ("interchange",),
    ("flight",),
    ("observation",),
    ("metrics",),
    ("estimation",),
    ("reporting",),
    ("results",),
    ("experiment",),
    ("studies",),
    ("claims",),
    ("pytest_plugin",),
    ("cli", "__main__"),
)
PAGE_READERS = ("sim.versions", "sim.pytest_plugin")  # they alone look at ``sim`` itself, from where all can be seen
MOST_FILES, MOST_FILES_AT_THE_ROOT = 12, 10
CATALOGUES = ("scenario/bundled", "observation/sensors", "flight/truths")  # folders that grow by a file for each kind

# outside package -> where it may be imported
CONFINED = {
    "jsbsim": ("aircraft/",),
    "control": ("autopilot/",),
    "filterpy": ("tracking/filterpy_adapter.py",),
    "matplotlib": (
        "sim/reporting/drawing/matplotlib_backend.py",
        "sim/results/result.py",
    ),  # there its name only, for a type
    "contourpy": ("sim/reporting/drawing/contours.py",),
    "jinja2": ("sim/reporting/page.py",),
    "distributed": ("sim/workers/cluster.py",),
    "pandas": ("sim/reporting/frames.py", "sim/results/result.py"),  # there its name only, for a type
    "stonesoup": ("sim/results/stonesoup.py",),
    "pyarrow": ("sim/cli/exporting/formats.py", "sim/interchange/track_writer.py", "sim/interchange/tables.py"),
}
HEAVY = (*CONFINED, "scipy")  # what a user who asks for help should not wait for

# where values have the units of a file, a property or a page
EDGES = (
    "aircraft/units.py",
    "aircraft/properties.py",
    "aircraft/models/",
    "sim/cli/commands/",
    "sim/scenario/reading.py",
    "sim/reporting/",
)
QUANTITIES = {"wind_at_20_ft"}  # the name that the specification gives it; its unit is m/s

# numpy.random is named, not used, where a Generator is passed; only these make one
RANDOMNESS = {
    "sim/randomness.py": "the streams of every draw",
    "tracking/operations.py": "any dense numbers do, the count of operations does not depend on them",
}


@cache
def sources() -> list[tuple[str, ast.Module]]:
    """(path from the root, syntax tree) of every module of ours."""
    paths = [path for package in OURS for path in sorted((ROOT / package).rglob("*.py"))]
    return [(path.relative_to(ROOT).as_posix(), ast.parse(path.read_text())) for path in paths]


def imports(tree: ast.Module) -> Iterator[str]:
    """Every module that a module imports, wherever in it."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def dotted(node: ast.expr) -> str:
    """``numpy.random.normal`` of an attribute chain, else ''."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        inner = dotted(node.value)
        return f"{inner}.{node.attr}" if inner else ""
    return ""


def names(tree: ast.Module) -> Iterator[str]:
    """Identifiers that a module gives to its values."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr


def test_packages_depend_in_one_direction():
    wrong = [
        f"{path} imports {module}"
        for path, tree in sources()
        for module in imports(tree)
        if path.split("/")[0] in MAY_IMPORT
        and module.split(".")[0] in OURS
        and module.split(".")[0] != path.split("/")[0]
        and not any(f"{module}.".startswith(f"{allowed}.") for allowed in MAY_IMPORT[path.split("/")[0]])
    ]
    assert not wrong


def module_of(path: str) -> str:
    """``sim.flight`` of ``sim/flight/__init__.py``."""
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def own_imports(tree: ast.Module, modules: frozenset[str], *, inside_functions: bool) -> set[str]:
    """Our modules that a module imports when it is imported itself, or when its functions are called.

    What only a type checker or a program that is started reads is neither.
    """
    found: set[str] = set()

    def look(node: ast.AST, within: bool) -> None:
        if isinstance(node, ast.If) and ast.unparse(node.test) in ("TYPE_CHECKING", "__name__ == '__main__'"):
            return
        if isinstance(node, ast.Import) and within is inside_functions:
            found.update(modules & {alias.name for alias in node.names})
        if isinstance(node, ast.ImportFrom) and within is inside_functions:
            named = {f"{node.module}.{alias.name}" for alias in node.names}
            found.update(modules & (named if named <= modules else {node.module or "", *named}))
        for child in ast.iter_child_nodes(node):
            look(child, within or isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda))

    look(tree, False)
    return found


@cache
def arrows(inside_functions: bool) -> dict[str, set[str]]:
    """Module of ours -> those that it imports, at once or when its functions are called."""
    modules = frozenset(module_of(path) for path, _ in sources())
    return {module_of(path): own_imports(tree, modules, inside_functions=inside_functions) for path, tree in sources()}


def circle(graph: dict[str, set[str]]) -> list[str]:
    """Modules that import each other in a circle, by name; empty where there is none."""
    done: set[str] = set()

    def follow(module: str, chain: list[str]) -> list[str]:
        if module in chain:
            return [*chain[chain.index(module) :], module]
        if module in done:
            return []
        for following in sorted(graph[module]):
            if found := follow(following, [*chain, module]):
                return found
        done.add(module)
        return []

    return next((found for module in sorted(graph) if (found := follow(module, []))), [])


def room(module: str) -> int | None:
    """Place of a module's room in the order; None for ``sim`` itself, whose page names every room."""
    name = module.split(".")[1] if "." in module else None
    return next((place for place, names in enumerate(ROOMS) if name in names), None)


def test_every_module_of_sim_lies_in_a_room():
    assert [m for m in arrows(False) if m.startswith("sim.") and room(m) is None] == []


@pytest.mark.parametrize("inside_functions", [False, True], ids=["at once", "when called"])
def test_rooms_import_only_the_rooms_before_them(inside_functions):
    wrong = [
        f"{module} imports {other}"
        for module, others in arrows(inside_functions).items()
        for other in others
        if module.startswith("sim.") and other.split(".")[0] == "sim"
        if (room(other) is None and module not in PAGE_READERS) or (room(other) or 0) > room(module)
    ]
    assert not wrong


def test_nothing_is_imported_in_a_circle():
    assert circle(arrows(False)) == []


def test_folders_can_be_taken_in_at_a_glance():
    wrong = {}
    for folder in [ROOT / "sim", *(path for path in (ROOT / "sim").rglob("*") if path.is_dir())]:
        place = folder.relative_to(ROOT / "sim").as_posix()
        count = sum(path.is_file() for path in folder.iterdir())
        most = MOST_FILES_AT_THE_ROOT if place == "." else MOST_FILES
        if folder.name != "__pycache__" and not place.startswith(CATALOGUES) and count > most:
            wrong[place] = count
    assert not wrong


def test_every_module_can_be_imported_and_none_hides_a_verb():
    """A module ``sim.run`` would take the place of ``sim.run()`` as soon as anything imported it."""
    modules = sorted(module for module in arrows(False) if not module.endswith("__main__"))
    code = f"""
import importlib, types, sim
verbs = {{name: getattr(sim, name) for name in sim.__all__}}
failed = []
for module in {modules!r}:
    try:
        importlib.import_module(module)
    except Exception as error:
        failed.append(f"{{module}}: {{error!r}}")
hidden = [name for name in sim.__all__ if getattr(sim, name) is not verbs[name]]
print(failed + hidden + [name for name, verb in verbs.items() if isinstance(verb, types.ModuleType)])
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr[-500:]


def test_outside_packages_stay_where_they_belong():
    wrong = [
        f"{path} imports {module}"
        for path, tree in sources()
        for module in imports(tree)
        if module.split(".")[0] in CONFINED and not path.startswith(CONFINED[module.split(".")[0]])
    ]
    assert not wrong


def test_unit_suffixes_occur_only_at_the_edges():
    endings = tuple(f"_{suffix}" for suffix in SUFFIXES)
    wrong = {
        f"{path}: {name}"
        for path, tree in sources()
        if not path.startswith(EDGES)
        for name in names(tree)
        if name.strip("_").lower().endswith(endings) and name.strip("_") not in QUANTITIES
    }
    assert not wrong


def test_nothing_draws_from_a_generator_of_its_own():
    """A module may name numpy's Generator type; making one, or drawing from the global one, is for randomness only."""
    wrong = []
    for path, tree in sources():
        if path in RANDOMNESS:
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.Call):
                called = dotted(node.func)
                if called.startswith(("np.random.", "numpy.random.", "random.")) or called == "default_rng":
                    wrong.append(f"{path}:{node.lineno} {called}")
        wrong += [f"{path} imports {module}" for module in imports(tree) if module in ("random", "secrets")]
    assert not wrong


def test_aircraft_files_hold_no_gains():
    """Every gain is designed from the linear model; an aircraft's file says what it is, not how to fly it."""

    def keys(table: dict[str, object], above: str = "") -> Iterator[str]:
        for key, value in table.items():
            yield above + key
            if isinstance(value, dict):
                yield from keys(value, f"{above}{key}.")

    files = sorted((ROOT / "aircraft" / "models").glob("*/*.toml"))
    assert files, "there is an aircraft of our own"
    words = ("gain", "k1", "k2", "k3", "k4", "kp", "ki", "kd", "integral", "proportional", "bandwidth", "autopilot")
    wrong = [
        f"{path.name}: {key}"
        for path in files
        for key in keys(tomllib.loads(path.read_text()))
        if any(part in words for part in key.lower().replace(".", "_").split("_"))
    ]
    assert not wrong


def test_nothing_is_inherited():
    """Classes are NamedTuples, Protocols, frozen dataclasses and exceptions; an outside interface may be met."""
    exceptions = {
        name for name, thing in vars(builtins).items() if isinstance(thing, type) and issubclass(thing, BaseException)
    }
    allowed = {"NamedTuple", "Protocol"} | exceptions
    outside = ("jsbsim.", "Generic[", "BaseModel", "pytest.", "HTMLParser", "Mapping[")
    wrong = [
        f"{path}: {node.name}({ast.unparse(base)})"
        for path, tree in sources()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        for base in node.bases
        if ast.unparse(base) not in allowed and not ast.unparse(base).startswith(outside)
    ]
    assert not wrong


def test_parameters_have_units_that_files_can_spell():
    """The second part of every ``Annotated`` is a unit of aircraft/units.py, or a word of scenario/parameters.py."""
    known = {unit for unit, _ in SUFFIXES.values()} | {"given", "not empty"}
    wrong = [
        f"{path}:{node.lineno} {ast.unparse(node)}"
        for path, tree in sources()
        for node in ast.walk(tree)
        if isinstance(node, ast.Subscript) and dotted(node.value) == "Annotated" and isinstance(node.slice, ast.Tuple)
        for unit in node.slice.elts[1:2]
        if isinstance(unit, ast.Constant) and unit.value not in known
    ]
    assert not wrong


def test_parameters_cannot_be_changed_behind_ones_back():
    """Dataclasses are frozen; the two that are not are a running count and a reader's place in a stream."""
    working = {"Tally", "Rows"}
    wrong = [
        f"{path}: {node.name}"
        for path, tree in sources()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and node.name not in working
        for decorator in map(ast.unparse, node.decorator_list)
        if decorator.startswith("dataclass") and "frozen=True" not in decorator
    ]
    assert not wrong


@pytest.mark.parametrize(
    "code",
    [
        "import sim",
        "import sys, runpy; sys.argv = ['shortfinal', '--help']; runpy.run_module('sim', run_name='__main__')",
    ],
    ids=["import sim", "--help"],
)
def test_nothing_heavy_is_imported_before_it_is_needed(code):
    """jsbsim, matplotlib, control, filterpy and scipy cost seconds; asking for help costs none of them."""
    report = f"import atexit, sys; atexit.register(lambda: print('LOADED', [m for m in {HEAVY!r} if m in sys.modules]))"
    done = subprocess.run(
        [sys.executable, "-c", f"{report}\n{code}"], cwd=ROOT, capture_output=True, text=True, timeout=60
    )
    assert done.stdout.splitlines()[-1] == "LOADED []", done.stdout[-500:] + done.stderr[-500:]


def test_the_walls_can_be_felt():
    """What these tests look for is found where it is: a broken reader would let everything pass."""
    tree = ast.parse("import jsbsim\nfrom sim.flight.record import Flight\ndef f(speed_kt): return np.random.normal()")
    assert {"jsbsim", "sim.flight.record", "sim.flight.record.Flight"} == set(imports(tree))
    mixed = ast.parse(
        "import a\ndef f():\n from b import c, x\nclass K:\n from b import c\nif TYPE_CHECKING:\n import d"
    )
    ours = frozenset(("a", "b", "b.c", "d"))
    assert own_imports(mixed, ours, inside_functions=False) == {"a", "b.c"}
    assert own_imports(mixed, ours, inside_functions=True) == {"b", "b.c"}
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c", "b"]
    assert circle({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []
    assert room("sim.scenario.reading") < room("sim.metrics.table") < room("sim.cli.commands")
    assert "speed_kt" in set(names(tree))
    assert [dotted(n.func) for n in ast.walk(tree) if isinstance(n, ast.Call)] == ["np.random.normal"]


LONGEST_COPY = 8  # lines; as many that are equal in two files are one thing written twice


def written_lines(path: Path) -> Iterator[tuple[int, str]]:
    """(number, text) of the lines that say something: no blanks, comments, imports and brackets alone."""
    tree = ast.parse(path.read_text())
    imported = {
        number
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for number in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    for number, line in enumerate(path.read_text().splitlines(), 1):
        text = line.strip()
        if number not in imported and not text.startswith("#") and any(map(str.isalnum, text)):
            yield number, text


def test_nothing_is_written_twice():
    """No run of equal lines stands in two files; within one file a fast path may repeat itself."""
    places: dict[tuple[str, ...], str] = {}
    wrong = []
    for package in OURS:
        for path in sorted((ROOT / package).rglob("*.py")):
            lines = list(written_lines(path))
            for start in range(len(lines) - LONGEST_COPY + 1):
                run = tuple(text for _, text in lines[start : start + LONGEST_COPY])
                first = places.setdefault(run, path.name)
                if first != path.name:
                    wrong.append(f"{first} and {path.name}:{lines[start][0]} {run[0]}")
    assert not wrong


def test_text_is_utf_8_whatever_the_locale():
    """Every text file is opened with its encoding: a locale must not decide what a file says."""
    wrong = []
    for path, tree in sources():
        for node in ast.walk(tree):
            if not isinstance(node, ast.Call) or any(one.arg == "encoding" for one in node.keywords):
                continue
            name = ast.unparse(node.func).rpartition(".")[2]
            modes = [one.value for one in node.args if isinstance(one, ast.Constant) and isinstance(one.value, str)]
            member = any(one.arg == "force_zip64" for one in node.keywords)  # of an archive: bytes
            opened = name in ("open", "fdopen") and ast.unparse(node.func) != "os.open" and not member
            text = opened and not any("b" in mode for mode in modes)
            if text or (name in ("read_text", "write_text") and isinstance(node.func, ast.Attribute)):
                wrong.append(f"{path}:{node.lineno}")
    assert not wrong
