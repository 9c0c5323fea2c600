"""The two ends of a service: a client hands its requests to the one that answers them."""

from collections import deque
from collections.abc import Callable
from typing import Any, TypeVar

from rosbase.contracts.service_call import ServiceCall
from rosbase.contracts.service_client import ServiceClient
from rosbase.contracts.services import ServiceType
from rosbase.errors import ServiceError, ServiceFailedError, ServiceStoppedError
from rosbase.local.service_interfaces import GONE, Request
from rosbase.local.service_registry import ServiceRegistry
from rosbase.logger import RosbaseLogger
from rosbase.runtime.executor import Executor
from rosbase.text.printable import one_line

__all__ = ["MOST_WAITING", "LocalClient", "LocalService"]

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")

MOST_WAITING = 1000
"""Number of requests that wait for one service at most."""


class LocalClient(ServiceClient[RequestT, ResponseT]):
    """A client of the services of this process, and of those behind its links."""

    def __init__(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        name: str,
        executor: Executor,
        registry: ServiceRegistry,
    ) -> None:
        super().__init__(srv_type, name, executor)
        self._registry = registry

    def service_is_ready(self) -> bool:
        """Return whether the service is there."""
        return self._registry.is_served(self.service_name)

    def send(self, call: ServiceCall[RequestT, ResponseT]) -> None:
        """Send the request of a call as soon as the service is there."""
        self._registry.send(self.service_name, call)


class LocalService:
    """Answers requests on the thread that spins."""

    def __init__(
        self, name: str, answer: Callable[[Any], Any], executor: Executor, logger: RosbaseLogger
    ) -> None:
        self._name = name
        self._answer = answer
        self._executor = executor
        self._logger = logger
        self._waiting: deque[Request] = deque()
        self._is_closed = False

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        return self._name

    def take(self, call: Request) -> None:
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
            call.set_exception(self._failed(GONE))

    def _failed(self, reason: str) -> ServiceFailedError:
        return ServiceFailedError(self._name, reason)
