"""The serving end of a service: rclpy takes the requests, and the main loop answers them.

rclpy's service sends what its callback returns. Ours cannot return an answer yet, and rclpy's
thread does not wait for it. So the callback returns the request, and the method that would send it
is replaced: it queues the request with its header for the main loop, which sends the answer.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

from rosbase import Executor, RosbaseLogger, ServiceError, ServiceServer
from rosbase_ros2.service_courier import ServiceCourier
from rosbase_ros2.shared_node import ServiceGroup

__all__ = ["Received", "RosService"]

_LOG_S = 1.0


class RosService(ServiceServer):
    """Answers the requests that rclpy takes, and requests of this process."""

    def __init__(
        self,
        name: str,
        courier: ServiceCourier,
        answer: Callable[[Any], Any],
        executor: Executor,
        logger: RosbaseLogger,
    ) -> None:
        """Prepare a service.

        Args:
            name: Its full name.
            courier: Converts what the program handles.
            answer: Answers a request of the program's class.
            executor: Runs it, on the main loop.
            logger: Logs requests that get no answer.
        """
        to_ros, from_ros = courier.response.to_ros, courier.request.from_ros
        super().__init__(name, lambda request: to_ros(answer(from_ros(request))), executor, logger)
        self._log = logger
        self._send: Callable[[Any, Any], object] | None = None
        self.inner: Any = None
        """Service of rclpy."""
        self.group = _Group(self._attach, self._warn)
        """Callback group for the service of rclpy."""

    @staticmethod
    def callback(request: Any, response: Any) -> Any:
        """Return the request, for rclpy to hand it on with its header."""
        return request

    def _attach(self, inner: Any) -> None:
        self.inner, self._send = inner, inner.send_response
        inner.send_response = self._receive

    def _receive(self, request: Any, header: Any) -> None:
        """Take a request, on the thread of rclpy."""
        self.take(Received(request, partial(self._respond, header), self._leave))

    def _respond(self, header: Any, response: Any) -> None:
        """Send an answer, on the main loop."""
        assert self._send is not None
        self._send(response, header)

    def _leave(self, error: ServiceError) -> None:
        # An exception of the callback is in the log already.
        if error.__cause__ is None:
            self._warn(f"{self.service_name}: a request gets no answer: {error}")

    def _warn(self, what: str) -> None:
        self._log.log_throttle(what, _LOG_S, "warning")


class _Group(ServiceGroup):
    """Callback group of one service, which sees it before an executor does."""

    def __init__(self, attach: Callable[[Any], object], warn: Callable[[str], object]) -> None:
        super().__init__(warn)
        self._attach = attach

    def add_entity(self, entity: Any) -> None:
        super().add_entity(entity)
        self._attach(entity)


class Received:
    """A request, a ROS message, and what becomes of its answer."""

    def __init__(
        self,
        request: Any,
        on_answer: Callable[[Any], object],
        on_failure: Callable[[ServiceError], object],
        is_done: Callable[[], bool] = bool,
    ) -> None:
        """Take a request.

        Args:
            request: The request.
            on_answer: Called with the answer, a ROS message.
            on_failure: Called with the reason why there is none.
            is_done: Whether nobody waits for it any more.
        """
        self.request = request
        self._on_answer = on_answer
        self._on_failure = on_failure
        self.done = is_done

    def set_result(self, response: Any) -> bool:
        """Set the answer, a ROS message."""
        self._on_answer(response)
        return True

    def set_exception(self, error: ServiceError) -> bool:
        """Set an error instead."""
        self._on_failure(error)
        return True
