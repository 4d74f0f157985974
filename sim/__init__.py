"""The experiment in five verbs: read a scenario, fly it, observe it, track it, report it; ``run`` does all.

>>> import sim
>>> result = sim.run("an26_pattern", seed=1)      # doctest: +SKIP
"""

from __future__ import annotations

import importlib
import importlib.util
from pathlib import Path
from typing import Any

__version__ = "0.1.0"

_VERBS = {
    "read": "sim.scenario.reading",
    "Scenario": "sim.scenario.reading",
    "prepare": "sim.flight.preparation",
    "fly": "sim.experiment",
    "observe": "sim.observation.record",
    "track": "sim.experiment",
    "report": "sim.experiment",
    "run": "sim.experiment",
    "Result": "sim.experiment",
    "ScenarioError": "sim.errors",
}
__all__ = sorted(_VERBS)


def _refuse_strangers() -> None:
    """The four import names are generic: say so in one sentence when another distribution shadows one."""
    home = Path(__file__).resolve().parent.parent
    for name in ("aircraft", "autopilot", "tracking"):
        spec = importlib.util.find_spec(name)
        found = Path(spec.origin).resolve() if spec is not None and spec.origin else None
        if found is None or found.parent.parent != home:
            raise ImportError(
                f"shortfinal's package '{name}' is shadowed by {found or 'nothing at all'}; "
                f"remove that distribution or use a fresh environment"
            )


_refuse_strangers()


def __getattr__(name: str) -> Any:
    if name in _VERBS:
        return getattr(importlib.import_module(_VERBS[name]), name)
    raise AttributeError(f"module 'sim' has no attribute '{name}'")
