"""``[record]``: a flight that was recorded, in place of one that is flown."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class RecordTable:
    """A recorded flight; without a file nothing is known of it but what sensors of kind ``recorded`` have seen."""

    runway: str | None = None  # a TOML file with a [runway] table, in place of that table
    file: str | None = None
    flight: str | None = None
    columns: dict[str, str] = field(default_factory=dict)
    sha256: str | None = None

    @property
    def known(self) -> bool:
        """Whether there is a true flight."""
        return self.file is not None
