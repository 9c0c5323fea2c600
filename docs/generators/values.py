"""Long values of constants, left out of the API reference."""

from typing import Any

from docutils import nodes
from sphinx.addnodes import desc_annotation

__all__ = ["LONGEST", "shorten"]

LONGEST = 100
"""Characters of a value that the reference still shows."""


def shorten(app: Any, page: Any) -> None:
    """Replace each longer value with three dots. Called by Sphinx for each page it has read."""
    for annotation in page.findall(desc_annotation):
        text = annotation.astext()
        if text.startswith(" = ") and len(text) > LONGEST:
            annotation.children = []
            annotation += nodes.Text(" = ...")
