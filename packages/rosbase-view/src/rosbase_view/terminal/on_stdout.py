"""Write to stdout, so that stderr may go to a file."""

import sys

from textual.app import App
from textual.drivers.linux_driver import LinuxDriver

__all__ = ["StdoutDriver"]


class StdoutDriver(LinuxDriver):
    """textual's driver, which writes to stderr by itself."""

    def __init__(
        self,
        app: App[object],
        *,
        debug: bool = False,
        mouse: bool = True,
        size: tuple[int, int] | None = None,
    ) -> None:
        """Write to stdout; textual calls it."""
        super().__init__(app, debug=debug, mouse=mouse, size=size)
        self._file = sys.__stdout__
