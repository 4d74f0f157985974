"""Parameters of the azimuth filters, each tuned for each flight and condition on a seed that no row reports."""

from __future__ import annotations

import math

from sim.claims.ledger import FLIGHTS
from sim.claims.papers.glistin.cases import AXES, JSBSIM, SETTLED, built, case, errors

SEED, RUNS = 1, 30  # runs of a prescribed flight; of JSBSim's a few flights with all their draws
WORTH = 1e-3  # share of the mean square error below which a step of the lattice is no gain
STARTS = {
    "kinematic": {"kinematic_density": 1e-6, "kinematic_correlation_time": 10.0},
    "published": {"azimuth_density": 1e-6, "range_density": 1e4},
    "corrected": {"azimuth_density": 1e-8, "range_density": 1e3},
    "corrected_residual": {"azimuth_density": 1e-9, "azimuth_correlation_time": 10.0, "range_density": 1e3},
}
STARTS |= dict.fromkeys(AXES, STARTS["published"])
KINDS = tuple(STARTS)


def neighbours(fields: dict[str, float]) -> list[dict[str, float]]:
    """Parameter sets one step away on a lattice of half decades of the densities and of doubled times."""
    found = []
    for name, value in fields.items():
        if name.endswith("density"):
            place = round(2.0 * math.log10(value))
            values = [float(f"{10.0 ** (0.5 * (place + step)):.3g}") for step in (-1, 1)]
        else:
            values = [0.5 * value, 2.0 * value]
        found += [{**fields, name: value} for value in values]
    return found


def tune(kind: str, flight: str, condition: str) -> dict[str, float]:
    """The parameters that no neighbour on the lattice betters over the whole flight, and so no edge of any grid."""
    data, tried = case(SEED, FLIGHTS if flight == JSBSIM else RUNS, flight, condition), {}

    def cost(fields: dict[str, float]) -> float:
        key = tuple(fields.values())
        if key not in tried:
            tried[key] = float((errors(built(kind, fields), data, kind != "kinematic")[SETTLED:] ** 2).mean())
        return tried[key]

    best = STARTS[kind]
    while cost(better := min(neighbours(best), key=cost)) < (1.0 - WORTH) * cost(best):
        best = better
    return best


TUNED: dict[tuple[str, str], dict[str, dict[str, float]]] = {
    ("base turn", "0.7 s, 1 deg"): {
        "kinematic": {"kinematic_density": 1e-06, "kinematic_correlation_time": 20.0},
        "published": {"azimuth_density": 1e-07, "range_density": 316.0},
        "published, X at 45 deg": {"azimuth_density": 3.16e-08, "range_density": 10000.0},
        "published, X at 90 deg": {"azimuth_density": 1e-07, "range_density": 31600.0},
        "published, X at 135 deg": {"azimuth_density": 3.16e-07, "range_density": 31600.0},
        "corrected": {"azimuth_density": 1e-09, "range_density": 316.0},
        "corrected_residual": {"azimuth_density": 1e-09, "azimuth_correlation_time": 10.0, "range_density": 100000.0},
    },
    ("base turn", "0.5 s, 0.15 deg"): {
        "kinematic": {"kinematic_density": 1e-06, "kinematic_correlation_time": 20.0},
        "published": {"azimuth_density": 1e-07, "range_density": 316.0},
        "published, X at 45 deg": {"azimuth_density": 3.16e-08, "range_density": 10000.0},
        "published, X at 90 deg": {"azimuth_density": 3.16e-08, "range_density": 31600.0},
        "published, X at 135 deg": {"azimuth_density": 1e-07, "range_density": 31600.0},
        "corrected": {"azimuth_density": 1e-09, "range_density": 10.0},
        "corrected_residual": {"azimuth_density": 3.16e-10, "azimuth_correlation_time": 10.0, "range_density": 10000.0},
    },
    ("S-turn", "0.7 s, 1 deg"): {
        "kinematic": {"kinematic_density": 3.16e-06, "kinematic_correlation_time": 5.0},
        "published": {"azimuth_density": 3.16e-06, "range_density": 3160000.0},
        "corrected": {"azimuth_density": 3.16e-08, "range_density": 316.0},
        "corrected_residual": {"azimuth_density": 1e-08, "azimuth_correlation_time": 5.0, "range_density": 1000.0},
    },
    ("S-turn", "0.5 s, 0.15 deg"): {
        "kinematic": {"kinematic_density": 3.16e-06, "kinematic_correlation_time": 10.0},
        "published": {"azimuth_density": 1e-06, "range_density": 31600000.0},
        "corrected": {"azimuth_density": 3.16e-08, "range_density": 1000.0},
        "corrected_residual": {"azimuth_density": 1e-09, "azimuth_correlation_time": 10.0, "range_density": 1000000.0},
    },
    ("near pass", "0.7 s, 1 deg"): {
        "kinematic": {"kinematic_density": 3.16e-05, "kinematic_correlation_time": 20.0},
        "published": {"azimuth_density": 1e-05, "range_density": 10000000.0},
        "corrected": {"azimuth_density": 3.16e-07, "range_density": 3160000.0},
        "corrected_residual": {
            "azimuth_density": 3.16e-07,
            "azimuth_correlation_time": 5.0,
            "range_density": 3160000.0,
        },
    },
    ("near pass", "0.5 s, 0.15 deg"): {
        "kinematic": {"kinematic_density": 1e-05, "kinematic_correlation_time": 10.0},
        "published": {"azimuth_density": 3.16e-06, "range_density": 1000000.0},
        "corrected": {"azimuth_density": 3.16e-07, "range_density": 316.0},
        "corrected_residual": {"azimuth_density": 3.16e-07, "azimuth_correlation_time": 0.3125, "range_density": 316.0},
    },
    ("turn onto final", "0.7 s, 1 deg"): {
        "kinematic": {"kinematic_density": 1e-07, "kinematic_correlation_time": 10.0},
        "published": {"azimuth_density": 3.16e-08, "range_density": 100.0},
        "published, X at 45 deg": {"azimuth_density": 3.16e-09, "range_density": 1000.0},
        "published, X at 90 deg": {"azimuth_density": 1e-08, "range_density": 10000.0},
        "published, X at 135 deg": {"azimuth_density": 3.16e-08, "range_density": 3160.0},
        "corrected": {"azimuth_density": 3.16e-10, "range_density": 316.0},
        "corrected_residual": {"azimuth_density": 3.16e-10, "azimuth_correlation_time": 10.0, "range_density": 1000.0},
    },
    ("turn onto final", "0.5 s, 0.15 deg"): {
        "kinematic": {"kinematic_density": 1e-07, "kinematic_correlation_time": 20.0},
        "published": {"azimuth_density": 3.16e-08, "range_density": 1000.0},
        "published, X at 45 deg": {"azimuth_density": 3.16e-09, "range_density": 3160.0},
        "published, X at 90 deg": {"azimuth_density": 1e-08, "range_density": 10000.0},
        "published, X at 135 deg": {"azimuth_density": 3.16e-08, "range_density": 31600.0},
        "corrected": {"azimuth_density": 3.16e-10, "range_density": 10.0},
        "corrected_residual": {"azimuth_density": 1e-10, "azimuth_correlation_time": 10.0, "range_density": 3160.0},
    },
}  # what `tune` chose
