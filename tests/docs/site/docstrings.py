"""The extension of griffe that the builder of the site loads by its path: each docstring is rewritten when loaded."""

from __future__ import annotations

from typing import Any

import griffe

from tests.docs.site.docstrings_text import with_words


class Words(griffe.Extension):
    """Rewrites each docstring before it is read."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Called by griffe for each object that it has loaded."""
        if obj.docstring is not None:
            obj.docstring.value = with_words(obj.docstring.value)
