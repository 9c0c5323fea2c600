"""A program's own use of rclpy, beside the backend: its default context, as of `rclpy.init()`.

Programs loop on `rclpy.ok()`, and end with `rclpy.shutdown()`. So the end of a manager is the end
of the default context, and the other way round. A program that has not called `rclpy.init()` gets
a default context with the backend.
"""

from collections.abc import Callable, Sequence
from typing import Any

import rclpy

from rosbase_ros2.default_context import borrow, give_back, is_lent
from rosbase_ros2.spinner import Spinner

__all__ = ["Host"]


class Host:
    """Watches over the default context of rclpy while a manager or standalone node runs."""

    def __init__(self, report: Callable[[str], object], arguments: Sequence[str]) -> None:
        """Start without a run, with a default context.

        Args:
            report: Called on rclpy's thread with a line that says why the program ends.
            arguments: Arguments for ROS of a default context that the program has not made.
        """
        self._report = report
        self._context: Any = None
        self._spinner: Spinner | None = None
        self._request_stop: Callable[[], object] | None = None
        borrow(self, arguments)

    def begin_run(self, request_stop: Callable[[], object], spinner: Spinner) -> None:
        """Call a function when rclpy is shut down.

        Args:
            request_stop: The function; it ends the run.
            spinner: Looks after rclpy, on its thread.
        """
        self._request_stop = request_stop
        self._spinner = spinner
        self._watch()

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
        """Shut the default context down, if the program has made it or nobody else needs it."""
        self._request_stop = self._context = None
        give_back(self)
        if not is_lent():
            rclpy.try_shutdown()

    def close(self) -> None:
        """End without a run: a context that the program has made stays."""
        self._request_stop = self._context = None
        give_back(self)

    def on_lent_context_end(self) -> None:
        """Look after the context soon."""
        if self._spinner is not None:
            self._spinner.look_soon(self.look)

    def on_own_init(self) -> None:
        """Watch the program's own context from now on."""
        if self._spinner is not None:
            self._watch()

    def _watch(self) -> None:
        context: Any = rclpy.get_default_context()
        self._context = context if context.ok() else None
        # Of the program's own, nobody tells: the signal handlers of rclpy call no Python code.
        if self._context is not None and self._spinner is not None and not is_lent():
            self._spinner.look_now_and_then(self.look)
