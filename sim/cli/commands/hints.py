"""Where a command line that is none leads: what its user may have meant."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

NO_COMMAND = re.compile(r"No such command '(.*?)'")
NO_ARGUMENT = {  # command that takes none, or no more -> what its user may look for
    "list": "--aircraft lists aircraft, --kinds sensors, trackers, laws and wind events",
    "doctor": "--aircraft PATH checks an aircraft",
    "schema": "all scenarios have one schema",
    "run": "a run is of one scenario",
    "study": "a study is of one scenario",
}
SET = "values of the scenario are replaced by --set TABLE.KEY=VALUE, without blanks"


def hint(error: Any, told: str) -> str:
    """The end of the sentence about a wrong command line: what leads on, and where help is."""
    command = error.ctx.command_path if error.ctx else "shortfinal"
    return "; ".join(filter(None, (_meant(error, told), f"see '{command} -h'")))


def _meant(error: Any, told: str) -> str:
    unknown = NO_COMMAND.search(told)
    if unknown is not None:
        word = unknown[1]
        if word == "version":
            return "say --version"
        is_scenario = "Did you mean" not in told and (Path(word).suffix or Path(word).exists() or _is_bundled(word))
        return f"to fly a scenario, say: run {word}" if is_scenario else ""
    name = error.ctx.info_name if error.ctx else ""
    takes_sets = bool(error.ctx) and any(one.name == "sets" for one in error.ctx.command.params)
    if "extra argument" in told:
        return SET if takes_sets and error.ctx.params.get("sets") else NO_ARGUMENT.get(name, "")
    return SET if "No such option" in told and "Possible" not in told and takes_sets else ""


def _is_bundled(word: str) -> bool:
    from sim.scenario.catalogue import scenarios, studies

    return word in (*scenarios(), *studies())
