"""Propeller engines at the start of a flight: levers where an approach has them, run until their thrust is steady.

JSBSim's own steady state stops at the first rest of the thrust, where the governor of a propeller still hunts or a
turboprop still spools. Here the engines simply run in time while the motion of the aircraft is frozen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

LEVERS = ("fcs/advance-cmd-norm", "fcs/mixture-cmd-norm")  # propeller levers forward, mixture rich
INTEGRATORS = (  # of JSBSim's equations of motion, and the methods that its executive begins with
    ("simulation/integrator/rate/rotational", 1),
    ("simulation/integrator/rate/translational", 3),
    ("simulation/integrator/position/rotational", 1),
    ("simulation/integrator/position/translational", 4),
)
FROZEN = 0
LOOK = 10  # steps between two looks at the thrust
QUIET = 2  # looks in a row without a change
CHANGE = 3e-9  # of the thrust, relative, that is none
PATIENCE = 300  # looks; a governor that still hunts after 25 s hunts for ever


def started(executive: Any) -> Callable[[], None]:
    """Start every engine; the function given back runs them until their thrust no longer changes.

    The model must have been initialised somewhere in the air: in a vacuum no engine keeps running.
    """
    manager, propulsion = executive.get_property_manager(), executive.get_propulsion()
    engines = range(propulsion.get_num_engines())
    levers = [manager.get_node(f"{name}[{number}]", False) for name in LEVERS for number in engines]
    for lever in levers:
        if lever is not None:
            lever.set_double_value(1.0)
    propulsion.init_running(-1)
    found = [manager.get_node(f"propulsion/engine[{number}]/thrust-lbs", False) for number in engines]
    thrusts = [node.get_double_value for node in found if node is not None]
    methods = [(manager.get_node(name, False), method) for name, method in INTEGRATORS]
    run = executive.run

    def settle() -> None:
        for node, _ in methods:
            node.set_double_value(FROZEN)
        quiet, before = 0, [thrust() for thrust in thrusts]
        for _ in range(PATIENCE):
            for _ in range(LOOK):
                run()
            now = [thrust() for thrust in thrusts]
            still = all(abs(a - b) <= CHANGE * max(abs(a), 1.0) for a, b in zip(now, before, strict=True))
            quiet, before = quiet + 1 if still else 0, now
            if quiet == QUIET:
                break
        for node, method in methods:
            node.set_double_value(method)

    return settle
