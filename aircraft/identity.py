"""By what an aircraft is known: a digest of everything that is read for it."""

from __future__ import annotations

import hashlib

from aircraft.model_files import digest, is_file, main_file, read
from aircraft.stock import STOCK_TABLE


def identity(model: str) -> str:
    """Digest of a model with all files that it refers to, its data, and the table of stock aircraft.

    Empty for the point mass, which is read from no file. Raises ``ModelError`` where there is no such model.
    """
    if model == "point_mass":
        return ""
    found = hashlib.sha256(digest(read(model)).encode())
    for path in (main_file(model).with_suffix(".toml"), STOCK_TABLE):
        if is_file(path):
            found.update(path.name.encode() + path.read_bytes())
    return found.hexdigest()
