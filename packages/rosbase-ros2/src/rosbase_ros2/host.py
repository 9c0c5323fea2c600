"""A program's own use of rclpy, beside the backend: its default context, as of `rclpy.init()`.

Programs loop on `rclpy.ok()`, and end with `rclpy.shutdown()`. So the end of a manager is the end
of the default context, and the other way round.
"""

from collections.abc import Callable
from typing import Any

import rclpy

__all__ = ["Host"]


class Host:
    """Watches over the default context of rclpy while a manager or standalone node runs."""

    def __init__(self, report: Callable[[str], object]) -> None:
        """Start without a run.

        Args:
            report: Called on rclpy's thread with a line that says why the program ends.
        """
        self._report = report
        self._context: Any = None
        self._request_stop: Callable[[], object] | None = None

    def begin_run(self, request_stop: Callable[[], object]) -> bool:
        """Call a function when rclpy is shut down; return whether there is a context to watch."""
        self._request_stop = request_stop
        context: Any = rclpy.get_default_context()
        self._context = context if context.ok() else None
        return self._context is not None

    def look(self) -> None:
        """End the run if the program, or a signal handler of rclpy's, has shut rclpy down."""
        if self._context is not None and not self._context.ok():
            self._context = None
            self.shut_down("rclpy has been shut down")

    def shut_down(self, why: str) -> None:
        """End the run."""
        request_stop, self._request_stop = self._request_stop, None
        if request_stop is not None:
            self._report(f"{why}, so the program ends")
            request_stop()

    def end_run(self) -> None:
        """Shut the default context down, if the program has made it."""
        self._request_stop = None
        rclpy.try_shutdown()
