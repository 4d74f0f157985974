"""What a study found out, as a value that shows itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sim.reporting.notebook import study_in_short
from sim.reporting.text.broken_checks import broken_checks


@dataclass(frozen=True)
class StudyResult:
    """What a study found out: figures and verdicts of every cell."""

    folder: Path | None  # that holds it; None = it was flown for its figures alone
    metrics: dict[str, Any]

    @property
    def broken(self) -> list[str]:
        """A sentence for each check that failed; empty where all passed."""
        return broken_checks(self.metrics, lambda flight, at: f"sim.run(..., overrides={dict(at)}, flight={flight})")

    def __repr__(self) -> str:
        """A few lines, however many cells and flights there are."""
        return study_in_short(self.metrics, None if self.folder is None else str(self.folder))
