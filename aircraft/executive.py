"""JSBSim itself: an executive with one model on our earth, silent, with nothing that listens or writes."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import jsbsim

from aircraft.errors import ModelError
from aircraft.model_files import Model, private_root
from aircraft.properties import EARTH_RADIUS
from aircraft.repairs import mentioned
from aircraft.state import STANDARD_GRAVITY

PLANET = f"""<planet name="sphere"><equatorial_radius unit="M">{EARTH_RADIUS!r}</equatorial_radius>
<polar_radius unit="M">{EARTH_RADIUS!r}</polar_radius><rotation_rate unit="RAD/SEC">0</rotation_rate>
<GM unit="M3/SEC2">{STANDARD_GRAVITY * EARTH_RADIUS**2!r}</GM><J2>0</J2></planet>"""


def fresh_executive(source: Model, rate: float) -> Any:
    """A JSBSim executive with this one model, engines running, deaf and mute, stepped at ``rate`` (Hz).

    One for each flight: a second model in the same executive corrupts memory. Raises ``ModelError``.
    """
    jsbsim.FGJSBBase().debug_lvl = 0  # before construction, or a banner is printed
    said = _listen()
    with private_root(source) as root:
        planet = root / "planet.xml"
        planet.write_text(PLANET, encoding="utf-8")
        executive = jsbsim.FGFDMExec(str(root))
        executive.set_dt(1.0 / rate)  # before the model: actuators and filters take their step as they are loaded
        try:
            loaded = executive.load_planet(str(planet), False) and executive.load_model(source.name)
        except jsbsim.BaseError as error:
            put_aside(executive, source)
            raise ModelError(f"JSBSim cannot load '{source.name}': {_without(root, [str(error)])}") from None
        if not loaded:
            raise ModelError(f"JSBSim cannot load '{source.name}': {_without(root, said)}")
    executive.disable_input()
    executive.disable_output()
    executive.get_propulsion().init_running(-1)
    executive["propulsion/fuel_freeze"] = 1
    return executive


def put_aside(executive: Any, source: Model) -> None:
    """Give a model that failed whatever it still asks for.

    JSBSim evaluates functions once more as it destroys them, and a property that is missing then ends the process.
    """
    manager = executive.get_property_manager()
    for name in mentioned(source):
        if manager.get_node(name, False) is None:
            manager.get_node(name, True)


class _Logger(jsbsim.FGLogger):
    """Keeps what JSBSim says; it would print warnings and errors whatever its debug level."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[str] = []

    def set_level(self, level: Any) -> None:
        pass

    def file_location(self, filename: str, line: int) -> None:
        pass

    def format(self, format: Any) -> None:
        pass

    def flush(self) -> None:
        pass

    def message(self, message: str) -> None:
        if len(self.said) < 100:
            self.said.append(message)


_LOGGER = _Logger()


def _listen() -> list[str]:
    """What JSBSim says from now on, in the main thread; in others its logger would outlive the thread and crash."""
    _LOGGER.said.clear()
    if threading.current_thread() is threading.main_thread():
        jsbsim.set_logger(_LOGGER)
    return _LOGGER.said


def _without(root: Path, said: list[str]) -> str:
    """What JSBSim said, without the private root that the user never saw."""
    return sentence([text.replace(f"{root}/", "") for text in said])


def sentence(said: list[str]) -> str:
    """What JSBSim said, on one line."""
    text = " ".join(" ".join(said).split())
    return text[:300] if text else "no reason given"
