"""Services: a request to a node by the name of the service, and its answer."""

from collections.abc import Callable
from typing import Any, Protocol, TypeAlias, TypeVar

from rosbase.errors import ServiceError

__all__ = ["Client", "Service", "ServiceCallback", "ServiceFuture", "ServiceType"]

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")
RequestT_co = TypeVar("RequestT_co", covariant=True)
RequestT_contra = TypeVar("RequestT_contra", contravariant=True)
ResponseT_co = TypeVar("ResponseT_co", covariant=True)

ServiceCallback: TypeAlias = (
    Callable[[RequestT, ResponseT], ResponseT] | Callable[[RequestT], ResponseT]
)
"""Function that answers requests: `callback(request, response)` as in rclpy, or without response.
"""


class ServiceType(Protocol[RequestT_co, ResponseT_co]):
    """Type of a service: a class with the classes `Request` and `Response`, as rclpy has them.

    Type checkers see each as the function that makes an object of it, because mypy takes no nested
    class for an attribute.
    """

    def Request(self, *args: Any, **kwargs: Any) -> RequestT_co:  # noqa: N802 - as in rclpy
        """Class of its requests."""
        ...

    def Response(self, *args: Any, **kwargs: Any) -> ResponseT_co:  # noqa: N802 - as in rclpy
        """Class of its answers."""
        ...


class Service(Protocol):
    """A service: answers requests."""

    @property
    def service_name(self) -> str:
        """Full name of the service, such as `/gripper/open`."""
        ...


class ServiceFuture(Protocol[ResponseT_co]):
    """The answer to a request, which may not be there yet. Any thread may use it."""

    def done(self) -> bool:
        """Return whether there is an answer or an error, or the call was cancelled."""
        ...

    def result(self) -> ResponseT_co:
        """Return the answer. It does not wait.

        Raises:
            ServiceError: There is none: the call failed, was cancelled, or is not done.
        """
        ...

    def exception(self) -> ServiceError | None:
        """Return the error of a call that has failed or was cancelled."""
        ...

    def cancel(self) -> None:
        """Stop waiting for the answer, if it is not there. One that still comes is dropped."""
        ...

    def cancelled(self) -> bool:
        """Return whether `cancel` came before the answer."""
        ...

    def add_done_callback(self, callback: "Callable[[ServiceFuture[Any]], object]") -> None:
        """Call `callback(future)` on the main loop once it is done, or soon if it is."""
        ...


class Client(Protocol[RequestT_contra, ResponseT_co]):
    """A client: calls a service."""

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        ...

    @property
    def dropped(self) -> int:
        """Number of answers that came after the end of their call: too late, or cancelled."""
        ...

    def call(self, request: RequestT_contra, timeout_s: float = ...) -> ResponseT_co:
        """Send a request, wait for the answer, and return it. Call it from any thread.

        On the thread that spins, service requests are handled meanwhile, by callbacks of this
        process, and nothing else: ticks, timers and messages wait. So two nodes may call each
        other. Within such a callback, another call has at most the time that is left of this one.

        Args:
            request: An object of the service's class `Request`.
            timeout_s: How long to wait for the service and its answer, 5 seconds by default.

        Raises:
            ServiceTimeoutError: The service is absent, or has not answered in time. It may come
                later than the timeout, when a callback returns that runs on the same thread.
            ServiceFailedError: It raised an exception, or went away.
            ServiceStoppedError: The program was asked to stop.
            ServiceDepthError: 16 calls of this thread wait already, each within another.
            ServiceError: The client has been destroyed.
            TypeError: The request is of another class.
        """
        ...

    def call_async(
        self, request: RequestT_contra, timeout_s: float = ...
    ) -> ServiceFuture[ResponseT_co]:
        """Send a request, and return a future of its answer. It does not wait.

        It takes the arguments of `call`. No answer is taken after the timeout: the future fails,
        when the loop gets to it.

        Raises:
            ServiceError: The client has been destroyed.
            TypeError: The request is of another class.
        """
        ...

    def service_is_ready(self) -> bool:
        """Return whether the service is there."""
        ...

    def wait_for_service(self, timeout_s: float = ...) -> bool:
        """Wait until the service is there, 5 seconds by default; return whether it is.

        It waits as `call` does.

        Raises:
            ServiceStoppedError: The program was asked to stop.
            ServiceDepthError: As for `call`.
            ServiceError: The client has been destroyed.
        """
        ...
