"""How quickly the surfaces of a model follow their commands, read from its own flight controls."""

from __future__ import annotations

import math

from aircraft.model_files import Model


def actuator_bandwidth(model: Model, surface: str) -> float:
    """Frequency, rad/s, of the first-order lag of a surface, such as ``aileron``: its slowest; infinite without any.

    An actuator belongs to the surface that its name or its output speaks of.
    """
    lags = []
    for tree in (model.root, *model.files.values()):
        for actuator in tree.iter("actuator"):
            about = f"{actuator.get('name', '')} {actuator.findtext('output', '')}".lower()
            try:
                lag = float(actuator.findtext("lag", ""))
            except ValueError:  # none, or a property whose value is known in flight only
                continue
            if surface in about and lag > 0.0:
                lags.append(lag)
    return min(lags, default=math.inf)
