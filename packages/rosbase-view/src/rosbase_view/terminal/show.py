"""Show a source in this terminal."""

import os
import sys

from rosbase import ConfigurationError, SystemClock
from rosbase_view.drawing.glyphs import ASCII, UNICODE
from rosbase_view.options import Options
from rosbase_view.source import Source

__all__ = ["check", "run"]


def check(_: Options) -> None:
    """Check that there is a terminal.

    Raises:
        ConfigurationError: There is none.
    """
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise ConfigurationError("rosbase view needs a terminal")


def run(source: Source, _: Options) -> int:
    """Show the source until the user ends the view; return the exit status."""
    # textual takes a tenth of a second to import, which a wrong name need not wait for.
    from rosbase_view.terminal.app import ViewApp  # noqa: PLC0415 - as said
    from rosbase_view.terminal.on_stdout import StdoutDriver  # noqa: PLC0415 - as said

    glyphs = UNICODE if _is_utf8() else ASCII
    app = ViewApp(source, SystemClock(), glyphs, driver_class=StdoutDriver)
    app.run()
    return app.return_code or 0


def _is_utf8() -> bool:
    """Return whether the terminal shows more than ASCII, as far as the environment tells."""
    encoding = (sys.stdout.encoding or "").lower().replace("-", "")
    # The console of Linux has a font of 256 characters.
    return encoding == "utf8" and os.environ.get("TERM") != "linux"
