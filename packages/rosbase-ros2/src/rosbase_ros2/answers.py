"""Send answers of services that the middleware may drop.

rmw waits 100 ms for a client whose end for answers it has not discovered, and then drops the
answer. rclpy only warns of that. Discovery takes some 3 s where it is slow, and longer on a
network that loses packets.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.exceptions import InvalidHandle

from rosbase import Clock, SystemClock, background_thread
from rosbase_ros2.refusals import RCLError, Refusals

__all__ = ["Answers"]

_LONG_NS = 90_000_000
# rclpy clients wait for ever by default. Their users give up after about this long.
_PATIENCE_NS = 30_000_000_000
_PAUSE_S = 0.05


class Answers:
    """Sends the answers of one service of rclpy, again if they were probably dropped."""

    def __init__(
        self,
        send: Callable[[Any, Any], object],
        name: str,
        warn: Callable[[str], object],
        clock: Clock | None = None,
    ) -> None:
        """Prepare to send.

        Args:
            send: The method of rclpy's service that sends an answer.
            name: Name of the service, for warnings.
            warn: Called with a line for an answer that could not be sent, on any thread.
            clock: Measures how long an answer is sent again; by default, the machine's clock.
        """
        self._send = send
        self._name = name
        self._warn = warn
        self._clock = clock or SystemClock()

    def send(self, response: Any, header: Any) -> None:
        """Send an answer, now and if need be later; raise nothing that the middleware does."""
        if not self._has_sent(response, header):
            resend = partial(self._resend, response, header)
            background_thread(resend, "rosbase-answer").start()

    def _resend(self, response: Any, header: Any) -> None:
        """Send an answer again until it has probably gone out; a client ignores the second."""
        deadline_ns = self._clock.monotonic_ns() + _PATIENCE_NS
        while self._clock.monotonic_ns() < deadline_ns:
            self._clock.sleep(_PAUSE_S)
            if self._has_sent(response, header):
                return
        self._say("the client has not been discovered")

    def _has_sent(self, response: Any, header: Any) -> bool:
        """Send an answer; return False if it took so long that it was probably dropped."""
        begin_ns = self._clock.monotonic_ns()
        try:
            self._send(response, header)
        except InvalidHandle:
            # It has been destroyed meanwhile.
            return True
        except (RuntimeWarning, SystemError) as error:
            # The warning of rclpy, where the program makes errors of warnings. rclpy goes on as if
            # there were none, which Python says in an error of its own.
            if isinstance(error, SystemError) and not isinstance(error.__cause__, RuntimeWarning):
                raise
            return False
        except RCLError as error:
            self._say(Refusals.reason(error))
            return True
        return self._clock.monotonic_ns() - begin_ns < _LONG_NS

    def _say(self, reason: str) -> None:
        self._warn(f"{self._name}: ROS did not send an answer: {reason}")
