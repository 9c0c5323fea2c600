"""The logger of an rclpy node, whose records rosbase publishes on `/rosout`.

rcl would publish them itself, with a publisher of its own beside the one for rosbase's records. A
node has one publisher of `/rosout`, as the tools expect, so rcl gets none.
"""

import os
from typing import Protocol

from rclpy.impl import rcutils_logger
from rclpy.impl.rcutils_logger import CallerId, RcutilsLogger

__all__ = ["LogListener", "NodeLogger"]

# rclpy's list of files that are never the caller of a log call. It is meant to be added to: `once`
# and the throttle remember the caller, and `/rosout` names it.
rcutils_logger._internal_callers.append(os.path.realpath(__file__))


class LogListener(Protocol):
    """A function that takes records of the logger, on the thread that logs."""

    def __call__(
        self, level: int, name: str, message: str, file: str, function: str, line: int
    ) -> None:
        """Take one record."""
        ...


class NodeLogger(RcutilsLogger):  # type: ignore[misc]  # rclpy is Any
    """A logger of rclpy that also hands its records to listeners."""

    def __init__(self, name: str, listeners: list[LogListener]) -> None:
        """Take the name, and the listeners, which may change."""
        super().__init__(name)
        self._listeners = listeners

    def log(self, message: str, severity: int, **options: object) -> bool:
        """Log a message; return whether it was logged."""
        name = str(options.get("name", self.name))
        if not super().log(message, severity, **options):
            return False
        if self._listeners:
            caller = CallerId()
            for listener in self._listeners:
                listener(
                    int(severity),
                    name,
                    message,
                    caller.file_path,
                    caller.function_name,
                    caller.line_number,
                )
        return True

    def get_child(self, name: str) -> "NodeLogger":
        """Return a logger below this one.

        Raises:
            ValueError: The name is empty.
        """
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return NodeLogger(f"{self.name}.{name}", self._listeners)
