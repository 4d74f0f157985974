"""HTML pages from templates: the one place that knows how they are rendered."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from importlib import resources
from typing import Any, NamedTuple

from sim.reporting.drawing import svg
from sim.reporting.figures.style import Chart, Key


class Picture(NamedTuple):
    """A chart as the page has it."""

    title: str
    image: str  # an element of the page
    caption: str
    keys: tuple[Key, ...]


def picture(chart: Chart) -> Picture:
    """Draw a chart into the page; its title and caption are what a screen reader says of it."""
    title, figure, caption, keys = chart
    return Picture(title, svg.written(figure, f"{title}: {caption}"), caption, keys)


def rendered(template: str, scripts: Sequence[str] = (), **values: Any) -> str:
    """A page from one of the templates; every value is escaped, and one that is missing is an error.

    ``scripts`` are files beside the templates that the page runs after the one of all figures and tables; it allows no
    others.
    """
    import jinja2

    script = "".join(map(text_of, ("figures.js", *scripts)))
    values["script"] = script
    values["script_hash"] = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()

    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(text_of),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["lower_first"] = lambda text: text[:1].lower() + text[1:]
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}
    return environment.get_template(template).render(**values)


def text_of(name: str) -> str:
    """The text of a file beside the templates."""
    return (resources.files("sim.reporting.templates") / name).read_text(encoding="utf-8")
