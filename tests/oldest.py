"""The lowest versions that pyproject.toml allows, as pip's constraints: what `make test-oldest` installs.

Only what pyproject.toml names is held down; what those packages bring in comes as new as they let it, as it does on the
machine of somebody who has old packages and installs this one.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

PROJECT = Path(__file__).parents[1] / "pyproject.toml"
REQUIREMENT = re.compile(r"(?P<name>[A-Za-z0-9._-]+) >= (?P<version>[0-9.]+)")
EXTRAS = ("dev",)


def lowest(project: str) -> dict[str, str]:
    """Name and lowest version of each requirement in the text of a pyproject.toml; ``ValueError`` for one without."""
    table = tomllib.loads(project)["project"]
    named = [*table["dependencies"], *(line for extra in EXTRAS for line in table["optional-dependencies"][extra])]
    found = {}
    for line in named:
        match = REQUIREMENT.fullmatch(line)
        if match is None:
            raise ValueError(f"pyproject.toml: '{line}' must be written as NAME >= VERSION")
        found[match["name"]] = match["version"]
    return found


if __name__ == "__main__":
    for name, version in lowest(PROJECT.read_text(encoding="utf-8")).items():
        print(f"{name} == {version}")
