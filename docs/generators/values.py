"""Long values of constants, left out of the API reference."""

from typing import Any

from sphinx.addnodes import desc_annotation

__all__ = ["LONGEST", "shorten"]

LONGEST = 100
"""Characters of a value that the reference still shows."""


def shorten(app: Any, page: Any) -> None:
    """Replace each longer value by three dots. Sphinx calls it for each page."""
    for annotation in list(page.findall(desc_annotation)):
        text = annotation.astext()
        if text.startswith(" = ") and len(text) > LONGEST:
            annotation.replace_self(desc_annotation("", " = ...", classes=annotation["classes"]))
