"""Messages that the middleware refuses, for a reason that no program can fix."""

from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation

from rosbase import RosbaseLogger, SystemClock, date_fault, one_line

__all__ = ["RCLError", "Refusals"]

RCLError = rclpy_implementation.RCLError
"""Exception of rclpy for refusals of rcl or the middleware."""

_LOG_S = 10.0


class Refusals:
    """Separates refusals from faults of the program, and logs them at a limited rate."""

    def __init__(self, context: Any, logger: RosbaseLogger) -> None:
        """Take the rclpy context of the publishers, and the logger."""
        self._context = context
        self._logger = logger

    @staticmethod
    def explain(error: Exception) -> str:
        """Return the fault of the date for which the middleware may have refused; empty if none."""
        # The machine's date, which DDS looks at, and not a simulation's.
        return date_fault(SystemClock().now_ns()) if isinstance(error, RCLError) else ""

    @staticmethod
    def reason(error: Exception) -> str:
        """Return in one line why the middleware has refused."""
        return Refusals.explain(error) or one_line(str(error))

    def judge(self, topic: str, error: Exception) -> bool:
        """Return False, for a message that is lost although the program did nothing wrong.

        Args:
            topic: The name of the topic.
            error: Exception of rclpy when it published the message.

        Raises:
            RCLError: There is another reason; it is raised again.
        """
        if not self._context.ok():
            # The program has ended the context, and with it all that sends.
            return False
        fault = self.explain(error)
        if not fault:
            raise error
        if self._logger.due("refused by the middleware", _LOG_S):
            self._logger.warning(f"ROS does not send messages, on {topic} or elsewhere: {fault}")
        return False
