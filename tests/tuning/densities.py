"""The densities of the trackers' process noises, searched: ``make densities`` writes docs/densities.md.

Every kind that follows a whole approach or a capture is run over the same flights, the same noise and the same
criterion. What the search chooses is the default of the kind's class; the page says so for each, and
tests/tuning/test_densities.py holds the two together.
"""

from __future__ import annotations

import itertools
import math
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sim.estimation.tracking_run import track
from sim.experiment import fly
from sim.flight.preparation import Prepared, prepare
from sim.observation.record import observe
from sim.scenario.catalogue import load
from sim.scenario.parameters import parameters
from sim.scenario.reading import read
from tracking.trackers.saturated_control import DENSITIES

PAGE = Path(__file__).resolve().parents[2] / "docs" / "densities.md"
SEEDS = (1, 2, 3)
DRAWS = 40  # of noise for each seed
FLAT = 1.02  # a criterion so near to the least is no worse: the scatter of 120 draws
SPAN = "60_s"


class Case(NamedTuple):
    """A flight that is tracked, and what of it is counted."""

    name: str
    scenario: str
    changes: dict[str, Any]
    channel: str
    sensors: tuple[str, ...]

    @property
    def seeds_fly(self) -> bool:
        """Whether a seed is a flight of its own, and not only noise of its own."""
        return "turbulence" in self.changes.get("wind", {})


PATTERN = ("an26_pattern", "position_m", ("terminal", "approach"))
CAPTURE = ("vasylyev2003_jsbsim", "cross_track_m", ("radar",))


def _case(name: str, of: tuple[str, str, tuple[str, ...]], **changes: Any) -> Case:
    scenario, channel, sensors = of
    return Case(name, scenario, {key.replace("__", "."): value for key, value in changes.items()}, channel, sensors)


CASES = (
    _case("left hand", PATTERN),
    _case("right hand", PATTERN, route__side="right"),
    _case("crosswind 10 m/s", PATTERN, wind={"from_deg": 170, "speed_mps": 10}),
    _case("moderate turbulence", PATTERN, wind={"from_deg": 110, "speed_mps": 8, "turbulence": "moderate"}),
    _case("bank limit 25 deg", PATTERN, autopilot__bank_limit_deg=25),
    _case("capture from 5 km", CAPTURE),
    _case("capture from 500 m", CAPTURE, start__cross_track_m=500),
)


def half_decades(low: float, high: float) -> tuple[float, ...]:
    """Grid from ``low`` to ``high`` in steps of 1 and 3."""
    first, last = round(2 * math.log10(low)), round(2 * math.log10(high))
    return tuple(float(f"{10 ** (k / 2):.0e}") for k in range(first, last + 1))


class Search(NamedTuple):
    """One kind with its grid; the densities are searched together, or where ``start`` is given one after the other."""

    name: str
    table: dict[str, Any]
    grid: dict[str, tuple[float, ...]]  # by key
    start: tuple[float, ...] = ()
    printed: str = ""  # why the default is another one

    def defaults(self) -> tuple[float, ...]:
        """Of the class, in the order of the grid."""
        known = {key: one.default for one in parameters(load("trackers", self.table["kind"])) for key in one.keys}
        of_form = DENSITIES[self.table.get("covariance", "paper")]
        return tuple(of_form if known[key] is None else known[key] for key in self.grid)


ACCELERATION = "acceleration_density_m2ps3"
STRAIGHT, MANOEUVRE, LAW = (f"{what}_density_m2ps3" for what in ("straight", "manoeuvre", "law"))
SEARCHES = (
    Search("linear_feedback", {"kind": "linear_feedback"}, {ACCELERATION: half_decades(0.1, 10000)}),
    Search("saturated_control", {"kind": "saturated_control"}, {ACCELERATION: half_decades(0.003, 10)}),
    Search(
        "saturated_control, jacobian",
        {"kind": "saturated_control", "covariance": "jacobian"},
        {ACCELERATION: half_decades(0.01, 10)},
    ),
    Search("intent_imm", {"kind": "intent_imm"}, {LAW: half_decades(0.01, 3)}),
    Search(
        "imm",
        {"kind": "imm"},
        {STRAIGHT: half_decades(0.001, 1), MANOEUVRE: half_decades(0.01, 10)},
        start=(0.01, 0.1),
    ),
    Search(
        "imm_published",
        {"kind": "imm_published"},
        {ACCELERATION: half_decades(0.01, 10)},
        printed="the print's",
    ),
    Search("kalman", {"kind": "kalman"}, {ACCELERATION: half_decades(0.1, 100)}),
    Search("gated", {"kind": "gated"}, {ACCELERATION: half_decades(1, 1000)}),
    Search("huber", {"kind": "huber"}, {ACCELERATION: half_decades(1, 300)}),
)
SAME = {"filterpy_constant_velocity": "kalman"}  # one filter, its matrices by filterpy


class Figures(NamedTuple):
    """Of one point of a grid in one case: over all seeds and draws, none left out."""

    rmse: float  # m
    ahead: float  # m, RMSE of the prediction over 60 s
    anees: float
    lost: float  # share


class Point(NamedTuple):
    """Of one point of a grid over all cases."""

    rmse: float  # m, geometric mean: the criterion
    ahead: float  # m, geometric mean
    off: float  # factor by which the ANEES is off 1, to either side: geometric mean
    lost: float  # share, mean
    cases: dict[str, Figures]


@cache
def _watched(case: Case | str, seed: int) -> tuple[Any, Any]:
    """The flight of a case and what its sensors saw."""
    prepared = _prepared(CASE[case], seed, {})
    flight = fly(prepared) if CASE[case].seeds_fly or seed == SEEDS[0] else _watched(case, SEEDS[0])[0]
    return flight, observe(flight, prepared.scenario.sensors, seed, 0, DRAWS)


CASE = {case.name: case for case in CASES}


def _prepared(case: Case, seed: int, trackers: dict[str, dict[str, Any]]) -> Prepared:
    base = {"seed": seed, "draws": DRAWS, "checks": [], "contrasts": [], **case.changes}
    return prepare(read(case.scenario, {**base, "trackers": trackers}))


def figures(search: Search, case: Case, points: list[tuple[float, ...]]) -> list[Figures]:
    """Of several points of a search in one case."""
    names = {f"point_{number}": point for number, point in enumerate(points)}
    trackers = {
        name: {**search.table, "sensors": list(case.sensors), **dict(zip(search.grid, point, strict=True))}
        for name, point in names.items()
    }
    found: dict[str, list[tuple[float, ...]]] = {name: [] for name in names}
    for seed in SEEDS:
        _, by_name = track(_prepared(case, seed, trackers), *_watched(case.name, seed), {})
        for name, own in by_name.items():
            ahead = own["look_ahead"][SPAN][case.channel]
            found[name].append((own["overall"][case.channel]["rmse"], ahead, own["anees"], own["lost_fraction"]))
    return [_pooled(np.array(rows)) for rows in found.values()]


def _pooled(rows: Any) -> Figures:
    """Of all seeds, each with as many draws and looks as the others."""
    squares, means = np.sqrt(np.mean(rows[:, :2] ** 2, axis=0)), rows[:, 2:].mean(axis=0)
    return Figures(*(float(value) for value in (*squares, *means)))


def measured(search: Search, points: list[tuple[float, ...]]) -> dict[tuple[float, ...], Point]:
    """Points of a search over all cases."""
    by_case = {case.name: figures(search, case, points) for case in CASES}
    found = {}
    for number, point in enumerate(points):
        own = {name: each[number] for name, each in by_case.items()}
        rmse, ahead, anees, lost = (np.array([one[k] for one in own.values()]) for k in range(4))
        means = (math.exp(np.mean(logs)) for logs in (np.log(rmse), np.log(ahead), np.abs(np.log(anees))))
        found[point] = Point(*means, float(np.mean(lost)), own)
    return found


def chosen(points: dict[tuple[float, ...], Point]) -> tuple[float, ...]:
    """The point with the ANEES nearest to 1, flight by flight, of those whose criterion is within 2 % of the least."""
    least = min(point.rmse for point in points.values())
    flat = {densities: point for densities, point in points.items() if point.rmse <= FLAT * least}
    return min(flat, key=lambda densities: flat[densities].off)


Found = tuple[tuple[float, ...], dict[tuple[float, ...], Point]]  # the choice, and all points that were looked at


def searched(search: Search) -> Found:
    """Of one kind."""
    if not search.start:
        points = measured(search, list(itertools.product(*search.grid.values())))
        return chosen(points), points
    points, best, before = {}, search.start, None
    while best != before:
        before = best
        for axis, values in enumerate(search.grid.values()):
            line = [(*best[:axis], value, *best[axis + 1 :]) for value in values]
            new = [point for point in line if point not in points]
            points |= measured(search, new) if new else {}
            best = chosen({point: points[point] for point in line})
    return best, points


HEAD = """\
# Densities of the process noise

Written by `make densities`. A tracker is compared with others at its best, and every kind is searched alike. What is
chosen here is the default of the kind.

- **Flights**: `shortfinal run an26_pattern` flown to the left and to the right, and with one change each: {changes}.
  One line (`vasylyev2003_jsbsim`) captured from 5 km, where the limits of the law act, and from 500 m, where they do
  not. One aircraft flies them all, the An-26.
- **Noise**: seeds {seeds}, {draws} draws each. In turbulence each seed is a flight of its own. The rows of
  [acceptance.md](acceptance.md) are judged on other seeds.
- **Criterion**: RMSE over all epochs with a plot, all draws and seeds, of the position, on the line of the cross-track
  deviation; the geometric mean over the flights. A lost draw counts by its error, none is left out.
- **Choice**: the least criterion; of those within {flat:.0f} % of it the one whose ANEES is nearest to 1, by the mean
  distance of its logarithm flight by flight: doubt that is too small here does not make up for too much there. A grid
  is widened until no choice lies at its edge.
- **Beside it**: the RMSE of the prediction over 60 s, the factor by which the ANEES is off 1 (to either side), the
  share of lost draws.

Densities are in m2/s3. Kinds with several are searched one density after the other until none moves; the tables are
the lines through the choice. Not searched: `straight_density` and `manoeuvre_density` of `intent_imm`, because they
belong to flight by hand and all these aircraft follow their law; `manoeuvre_detector` and `autonomous_models`, which
are searched on the flights of Volovyk 2022, for the claims about them; `load_factor`, `load_factor_cartesian` and
`line_of_approach`, whose sensors see no whole approach; the kinds that track an angle.
"""


def main() -> None:
    """Search, and write the page."""
    found = {}
    for search in SEARCHES:
        found[search.name] = searched(search)
        print(f"{search.name}: {_numbers(found[search.name][0])}", flush=True)
    PAGE.write_text(page(found), encoding="utf-8")


def page(found: dict[str, Found]) -> str:
    """docs/densities.md."""
    changes = ", ".join(case.name for case in CASES[2:5])
    head = HEAD.format(
        changes=changes,
        seeds=", ".join(map(str, SEEDS)),
        draws=DRAWS,
        flat=100.0 * (FLAT - 1.0),
    )
    parts = [head, "## Chosen\n", *_chosen_rows(found), "\n## Flight by flight\n", *_case_rows(found)]
    for search in SEARCHES:
        parts += [f"\n## {search.name}\n", *_grid_rows(search, *found[search.name])]
    return "\n".join(parts) + "\n"


def _chosen_rows(found: dict[str, Found]) -> list[str]:
    rows = [
        "| tracker | densities | chosen | RMSE m | 60 s ahead m | ANEES off by | lost % | default |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for search in SEARCHES:
        best, points = found[search.name]
        cells = search.name, ", ".join(f"`{key}`" for key in search.grid), _numbers(best), _figures(points[best])
        rows.append(f"| {' | '.join(cells)} | {search.printed or 'chosen'} |")
    return [*rows, *(f"\n`{kind}` is `{as_}` with other hands: the same figures." for kind, as_ in SAME.items())]


def _case_rows(found: dict[str, Found]) -> list[str]:
    """Every choice in every case."""
    rows = [
        "RMSE m / 60 s ahead m / ANEES, at the choice.\n",
        "| tracker | " + " | ".join(case.name for case in CASES) + " |",
    ]
    rows.append("|---" * (len(CASES) + 1) + "|")
    for name, (best, points) in found.items():
        cells = (points[best].cases[case.name] for case in CASES)
        rows.append(f"| {name} | " + " | ".join(map(cell, cells)) + " |")
    return rows


def _grid_rows(search: Search, best: tuple[float, ...], points: dict[tuple[float, ...], Point]) -> list[str]:
    """The lines through the choice along each density."""
    rows = []
    for axis, key in enumerate(search.grid):
        rows += [f"| `{key}` | RMSE m | 60 s ahead m | ANEES off by | lost % | |", "|---|---|---|---|---|---|"]
        for value in search.grid[key]:
            point = (*best[:axis], value, *best[axis + 1 :])
            rows.append(f"| {value:g} | {_figures(points[point])} | {'chosen' if point == best else ''} |")
        rows.append("")
    return rows[:-1]


def cell(one: Figures) -> str:
    """Of one case."""
    return f"{one.rmse:.1f} / {one.ahead:.0f} / {one.anees:.2f}"


def _figures(point: Point) -> str:
    return f"{point.rmse:.2f} | {point.ahead:.0f} | {point.off:.2f} | {100.0 * point.lost:.1f}"


def _numbers(point: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in point)


if __name__ == "__main__":
    main()
