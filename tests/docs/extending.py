"""The complete files that docs/extending.md quotes: ``make extending`` renews the quotes from tests/parts.

A quote is a block behind ``<!-- file: PATH -->``, PATH from the root. The files are run by the tests, so the page shows
what runs.
"""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "extending.md"
QUOTE = re.compile(
    r"(?P<head><!-- file: (?P<path>\S+) -->\n```\w+\n)(?P<text>.*?)(?P<foot>^```$)", re.MULTILINE | re.DOTALL
)


def quotes(page: str) -> dict[str, str]:
    """Text of every quoted file, by its path."""
    return {found["path"]: found["text"] for found in QUOTE.finditer(page)}


def renewed(page: str, root: Path = ROOT) -> str:
    """The page with its quotes as their files are; raises ``FileNotFoundError`` for a quote of no file."""
    return QUOTE.sub(
        lambda found: found["head"] + (root / found["path"]).read_text(encoding="utf-8") + found["foot"], page
    )


def main() -> None:
    """Bring the page up to date."""
    PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(PAGE.relative_to(ROOT))


if __name__ == "__main__":
    main()
