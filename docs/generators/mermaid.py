"""Mermaid diagrams as SVG, drawn when the site is built, in the colours of the page."""

import re
from typing import Any

from docutils import nodes
from mermaid_render import mermaid_to_svg

__all__ = ["draw", "replace"]

# The fixed colours of the library's default palette, and the colour of the theme for each, because
# a reader may have chosen the dark theme.
COLOURS = {
    "#000000": "currentColor",
    "#172D4A": "currentColor",
    "#4472C4": "var(--color-brand-primary, #4472C4)",
    "#E5EFFA": "var(--color-background-secondary, #E5EFFA)",
    "#F0F4FA": "var(--color-background-secondary, #F0F4FA)",
    "#FFFFFF": "var(--color-background-primary, #FFFFFF)",
}


def draw(text: str) -> str:
    """Return a Mermaid diagram as SVG to stand in a page.

    Raises:
        ValueError: The text is not a diagram.
    """
    drawn = mermaid_to_svg(text).decode()
    # The page has a font, and the variables would leave the theme's colours aside.
    drawn = re.sub(r' style="[^"]*"', "", drawn, count=1)
    for colour, of_theme in COLOURS.items():
        drawn = drawn.replace(f'"{colour}"', f'"{of_theme}"')
    return drawn


def replace(app: Any, page: Any) -> None:
    """Replace the text of each diagram by its drawing. Sphinx calls it for each page."""
    for block in list(page.findall(nodes.literal_block)):
        if block.get("language") == "mermaid":
            drawing = f'<div class="diagram">{draw(block.astext())}</div>'
            block.replace_self(nodes.raw("", drawing, format="html"))
