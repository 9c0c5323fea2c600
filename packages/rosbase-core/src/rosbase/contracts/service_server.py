"""The serving end of a service: requests wait for the thread that spins, which answers them."""

from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from rosbase.errors import ServiceError, ServiceFailedError, ServiceStoppedError
from rosbase.logger import RosbaseLogger
from rosbase.runtime.executor import Executor
from rosbase.text.printable import one_line

__all__ = ["MOST_WAITING", "ServiceRequest", "ServiceServer"]

MOST_WAITING = 1000
"""Number of requests that wait for one service at most."""


class ServiceRequest(Protocol):
    """A request, and the place for its answer."""

    request: Any

    def done(self) -> bool:
        """Return whether nobody waits for the answer any more."""
        ...

    def set_result(self, response: Any) -> bool:
        """Set the answer; return False if nobody waits for it."""
        ...

    def set_exception(self, error: ServiceError) -> bool:
        """Set an error instead; return False if nobody waits for it."""
        ...


class ServiceServer:
    """Answers the requests of a service on the thread that spins.

    A backend creates one for each of its services, and hands it the requests.
    """

    def __init__(
        self, name: str, answer: Callable[[Any], Any], executor: Executor, logger: RosbaseLogger
    ) -> None:
        """Prepare a service.

        Args:
            name: Its full name.
            answer: Answers a request; see `service_answer`.
            executor: The executor of the backend.
            logger: Logs the exceptions of `answer`.
        """
        self._name = name
        self._answer = answer
        self._executor = executor
        self._logger = logger
        self._waiting: deque[ServiceRequest] = deque()
        self._is_closed = False

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        return self._name

    def take(self, call: ServiceRequest) -> None:
        """Queue a request. Call it from any thread."""
        if len(self._waiting) >= MOST_WAITING:
            call.set_exception(self._failed(f"{MOST_WAITING} requests wait for it already"))
            return
        self._waiting.append(call)
        self._executor.call_urgently(self._handle_one)
        # Looked at only now: whoever closes it afterwards finds the request.
        if self._is_closed:
            self._refuse_waiting()

    def close(self) -> None:
        """Answer no more requests: those that wait fail."""
        self._is_closed = True
        self._refuse_waiting()

    def _handle_one(self) -> None:
        try:
            call = self._waiting.popleft()
        except IndexError:
            # The service has ended, perhaps just now.
            return
        if call.done():
            return
        try:
            response = self._answer(call.request)
        except Exception as error:
            call.set_exception(self._explain(error))
        except BaseException:
            call.set_exception(self._failed("it was interrupted"))
            raise
        else:
            call.set_result(response)

    def _explain(self, error: Exception) -> ServiceFailedError:
        """Log the exception of the callback, and return the error for the caller."""
        if isinstance(error, ServiceFailedError):
            reason = error.reason
        elif isinstance(error, ServiceError):
            reason = str(error)
        else:
            reason = one_line(f"{type(error).__name__}: {error}")
        failure = self._failed(reason)
        failure.__cause__ = error
        # The log has the failure of another service already, and a stop is none.
        if not isinstance(error, (ServiceFailedError, ServiceStoppedError)):
            is_of_program = not isinstance(error, ServiceError)
            self._logger.error(str(failure), exc_info=error if is_of_program else None)
        return failure

    def _refuse_waiting(self) -> None:
        while self._waiting:
            try:
                call = self._waiting.popleft()
            except IndexError:
                return
            call.set_exception(ServiceFailedError(self._name))

    def _failed(self, reason: str) -> ServiceFailedError:
        return ServiceFailedError(self._name, reason)
