"""The console of a replay that shows the log from a moment on."""

import logging
from collections.abc import Callable

from rosbase.logger.console import Console

__all__ = ["LateConsole"]


class LateConsole(Console):
    """Leaves out records until a replay has come to the moment from which it is shown."""

    def __init__(self, is_early: Callable[[], bool]) -> None:
        """Prepare.

        Args:
            is_early: Returns whether the moment is still to come.
        """
        super().__init__()
        self._is_early = is_early

    def emit(self, record: logging.LogRecord) -> None:
        """Write one record, if it is late enough."""
        if not self._is_early():
            super().emit(record)
