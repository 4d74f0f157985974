"""contract(): how a kind, bundled or from outside, breaks the contract of its family, in sentences."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable
from typing import Any

from sim.errors import ScenarioError, did_you_mean
from sim.scenario import catalogue as bundled
from sim.scenario.parameters import construct
from sim.scenario.plugins import FAMILIES, Catalogue, class_of, fault
from sim.scenario.tables import Runway


def examine(kind: str, catalogue: Catalogue) -> tuple[str, list[str]]:
    """``FAMILY.KIND``, and a sentence for each promise that it breaks; raises ``ScenarioError`` where there is none."""
    family, name = _found(kind, catalogue)
    part = catalogue.named(family, name)
    cls = bundled.load(family, name) if part is None else class_of(part)
    if broken := fault(cls, family):
        return f"{family}.{name}", [broken]
    contract = importlib.import_module(bundled.CONTRACTS[family])
    make = _maker(family, cls if part is None else bundled.completed(family, cls), name)
    return f"{family}.{name}", contract.broken_promises(cls, make)


def _found(kind: str, catalogue: Catalogue) -> tuple[str, str]:
    """The family and the name of a kind."""
    head, dot, name = kind.partition(".")
    if dot and head not in FAMILIES:
        raise ScenarioError(f"contract: no family '{head}'; {did_you_mean(head, FAMILIES)}")
    known = {family: catalogue.kinds(family) for family in FAMILIES}
    among, wanted = ([head], name) if dot else (FAMILIES, kind)
    families = [family for family in among if wanted in known[family]]
    if not families:
        names = [name for family in among for name in known[family]]
        raise ScenarioError(f"contract: no kind '{wanted}'; {did_you_mean(wanted, names)}")
    if len(families) > 1:
        raise ScenarioError(f"contract: say {' or '.join(f'{family}.{wanted}' for family in families)}")
    return families[0], wanted


def _maker(family: str, cls: type, kind: str) -> Callable[[], Any] | None:
    """What makes instances of a class for its contract: with the values of its ``example``, else its defaults."""
    if family == "modes":
        return None  # a mode is designed, by itself
    if family == "trackers":
        from sim.estimation.trial import maker

        return maker(cls, kind)
    return functools.partial(construct, cls, getattr(cls, "example", {}), runway=Runway())
