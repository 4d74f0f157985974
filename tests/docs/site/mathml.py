"""Formulas of a page as MathML, which browsers draw without a script or a font from elsewhere."""

from __future__ import annotations

import re

from latex2mathml.converter import convert

FENCE = re.compile(r"^(```.*?^```$)", re.MULTILINE | re.DOTALL)
DISPLAYED = re.compile(r"^\$\$(.+?)\$\$(?P<stop>[.,]?)$", re.MULTILINE | re.DOTALL)


def with_formulas(page: str) -> str:
    """The page with each formula that stands between ``$$`` on lines of its own drawn; code is left alone."""

    def drawn(found: re.Match[str]) -> str:
        formula = convert(found[1].strip(), display="block")
        return f'<div class="formula">{formula}{found["stop"]}</div>'

    return "".join(part if part.startswith("```") else DISPLAYED.sub(drawn, part) for part in FENCE.split(page))
