"""Characters and colours that a terminal supports."""

import os
from collections.abc import Mapping

from attrs import frozen

__all__ = ["Style", "style_of"]

_CODES = {
    "bold": "1",
    "dim": "2",
    "red": "31",
    "green": "32",
    "yellow": "33",
    "blue": "34",
    "cyan": "36",
    "magenta": "35",
}
_RESET = "\x1b[0m"


@frozen
class Style:
    """Characters and colours of the panel."""

    has_colour: bool = False
    has_unicode: bool = False

    def paint(self, text: str, *names: str) -> str:
        """Return the text in these colours; unchanged if there are none."""
        if not (self.has_colour and names and text):
            return text
        return f"\x1b[{';'.join(_CODES[name] for name in names)}m{text}{_RESET}"

    def words(self, unicode: str, plain: str) -> str:
        """Return the text with only the characters that the terminal can show."""
        return unicode if self.has_unicode else plain


def style_of(encoding: str | None, environ: Mapping[str, str] | None = None) -> Style:
    """Return the style for a terminal with that encoding.

    `NO_COLOR`, if it is set and not empty, and `TERM=dumb` turn colours off (no-color.org).
    """
    environ = os.environ if environ is None else environ
    return Style(
        has_colour=not environ.get("NO_COLOR") and environ.get("TERM", "") not in ("", "dumb"),
        has_unicode=(encoding or "").lower().replace("-", "") == "utf8",
    )
