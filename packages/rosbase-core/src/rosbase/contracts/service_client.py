"""Base class of the clients of backends: waits, timeouts, and answers that come too late."""

import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from rosbase.contracts.service_call import ServiceCall
from rosbase.contracts.services import ServiceType
from rosbase.entries.conductor import conductor_of
from rosbase.errors import (
    ServiceDepthError,
    ServiceError,
    ServiceStoppedError,
    ServiceTimeoutError,
)
from rosbase.runtime.executor import Executor
from rosbase.runtime.waiting import Waiting

if TYPE_CHECKING:
    from rosbase.contracts.guarded_services import CallEntrance
    from rosbase.entries.entrance import Form

__all__ = ["DEFAULT_TIMEOUT_S", "MOST_CALLS_DEEP", "ServiceClient"]

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")

DEFAULT_TIMEOUT_S = 5.0
"""Seconds that a call waits for the service and its answer, unless it is told otherwise."""

MOST_CALLS_DEEP = 16
"""Number of calls that may wait on one thread, each in a callback that the one before runs."""

_LONGEST_S = 1e6
_NS_PER_S = 1_000_000_000


class ServiceClient(ABC, Generic[RequestT, ResponseT]):
    """A client of a service, but for what depends on the backend.

    Must implement: `send`, `service_is_ready`. May implement: `check_thread`, `response_form`.
    Call `changed` when the service comes or goes.
    """

    def __init__(
        self, srv_type: ServiceType[RequestT, ResponseT], service_name: str, executor: Executor
    ) -> None:
        """Prepare a client.

        Args:
            srv_type: Type of the service.
            service_name: Its full name.
            executor: The executor of the backend.
        """
        self._request_type: Any = srv_type.Request
        self._response_type: Any = srv_type.Response
        self._type_name = getattr(srv_type, "__name__", str(srv_type))
        self._name = service_name
        self._executor = executor
        self._waiting = Waiting(executor)
        # No set, which would order them by address: calls fail in the order of their begin.
        self._pending: dict[ServiceCall[Any, Any], None] = {}
        self._dropped = 0
        self._drop_lock = threading.Lock()
        self._is_closed = False
        self._entrance = self._make_entrance()

    @abstractmethod
    def send(self, call: ServiceCall[RequestT, ResponseT]) -> None:
        """Send the request of a call as soon as the service is there; do not wait for it.

        Called on any thread. The answer goes to `call.set_result`, and a failure to
        `call.set_exception`, from any thread. Nothing needs to be sent any more once the call is
        `done`.
        """

    @abstractmethod
    def service_is_ready(self) -> bool:
        """Return whether the service is there."""

    def check_thread(self) -> None:
        """Check that the thread of the caller may wait for an answer.

        Raises:
            ServiceError: It may not, because the answer could not come meanwhile.
        """

    def response_form(self) -> "Form":
        """Return the form of the answers, for a recording.

        Raises:
            TypeError: They have no schema.
        """
        from rosbase.contracts.message_format import message_format

        return message_format(self._response_type)

    def changed(self) -> None:
        """Look again whether the service is there. Call it from any thread."""
        self._waiting.changed()

    def close(self) -> None:
        """Let all calls that are under way fail, and all later ones. Idempotent."""
        self._is_closed = True
        for call in list(self._pending):
            call.expire(self._closed_error())
        self._waiting.changed()

    @property
    def is_closed(self) -> bool:
        """Whether the client has been destroyed. No service is ready for it then."""
        return self._is_closed

    @property
    def service_name(self) -> str:
        """Full name of the service."""
        return self._name

    @property
    def dropped(self) -> int:
        """Number of answers that came after the end of their call."""
        return self._dropped

    def call(self, request: RequestT, timeout_s: float = DEFAULT_TIMEOUT_S) -> ResponseT:
        """Send a request, wait for the answer, and return it."""
        self._check_wait(timeout_s)
        call = self._begin(request)
        try:
            deadline_ns, make_error = self._limit(timeout_s)
            call.limit(deadline_ns, make_error)
            self.send(call)
            self._waiting.wait(call.done, timeout_s)
            if not call.done():
                is_stopping = self._executor.is_stopping
                call.expire(self._stopped_error() if is_stopping else make_error())
            if call.exception() is not None:
                # Perhaps because a service of this program has just been ended by it.
                self._check_stop()
            return call.result()
        finally:
            # Such as after a KeyboardInterrupt.
            call.cancel()

    def call_async(
        self, request: RequestT, timeout_s: float = DEFAULT_TIMEOUT_S
    ) -> ServiceCall[RequestT, ResponseT]:
        """Send a request, and return a future of its answer."""
        _check_timeout(timeout_s)
        call = self._begin(request)
        if timeout_s < _LONGEST_S:
            timeout_ns = max(1, int(timeout_s * _NS_PER_S))
            call.expire_after(timeout_ns, lambda: self._timeout_error(timeout_s))
        try:
            self.send(call)
        except BaseException:
            call.cancel()
            raise
        return call

    def wait_for_service(self, timeout_s: float = DEFAULT_TIMEOUT_S) -> bool:
        """Wait until the service is there; return whether it is."""
        self._check_wait(timeout_s)
        self._check_open()
        self._waiting.wait(lambda: self._is_closed or self.service_is_ready(), timeout_s)
        self._check_stop()
        self._check_open()
        return self.service_is_ready()

    def _begin(self, request: RequestT) -> ServiceCall[RequestT, ResponseT]:
        if not isinstance(request, self._request_type):
            raise TypeError(
                f"{self._name} takes {self._type_name}.Request, not {type(request).__name__}"
            )
        begin = ServiceCall if self._entrance is None else self._entrance.begin
        call: ServiceCall[RequestT, ResponseT] = begin(
            self._name, request, self._executor, self._ended, self.count_late
        )
        self._pending[call] = None
        # Looked at only now: whoever closes it afterwards finds the call.
        if self._is_closed:
            call.cancel()
            raise self._closed_error()
        return call

    def _make_entrance(self) -> "CallEntrance | None":
        conductor = conductor_of(self._executor.clock)
        if conductor is None:
            return None
        from rosbase.contracts.guarded_services import CallEntrance

        return CallEntrance(conductor, self._name, self.response_form, self.count_late)

    def _ended(self, call: ServiceCall[Any, Any]) -> None:
        self._pending.pop(call, None)
        self._waiting.changed()

    def count_late(self) -> None:
        """Count an answer to a call that has ended. For those that `send` has forgotten."""
        with self._drop_lock:
            self._dropped += 1

    def _check_wait(self, timeout_s: float) -> None:
        """Refuse a wait that must not begin."""
        _check_timeout(timeout_s)
        self.check_thread()
        self._check_stop()
        executor = self._executor
        if executor.depth >= MOST_CALLS_DEEP and executor.is_on_own_thread:
            raise ServiceDepthError(
                f"{self._name}: {MOST_CALLS_DEEP} calls wait already, each within another;"
                " do services call each other in a circle?"
            )

    def _check_stop(self) -> None:
        if self._executor.is_stopping:
            raise self._stopped_error()

    def _check_open(self) -> None:
        if self._is_closed:
            raise self._closed_error()

    def _limit(self, timeout_s: float) -> tuple[int, Callable[[], ServiceError]]:
        """Return when a call that waits must end, and a function that makes its error."""
        executor, timeout_s = self._executor, min(timeout_s, _LONGEST_S)
        now_ns = executor.clock.monotonic_ns()
        deadline_ns = now_ns + int(timeout_s * _NS_PER_S)
        if executor.is_on_own_thread and executor.waits_end_ns < deadline_ns:
            deadline_ns = executor.waits_end_ns
            left_s = max(0, deadline_ns - now_ns) / _NS_PER_S
            return deadline_ns, lambda: self._timeout_error(left_s, is_cut=True)
        return deadline_ns, lambda: self._timeout_error(timeout_s)

    def _timeout_error(self, waited_s: float, *, is_cut: bool = False) -> ServiceTimeoutError:
        what = "no answer" if self.service_is_ready() else "no such service"
        why = ", all that was left of the call that waits for this one" if is_cut else ""
        return ServiceTimeoutError(f"{self._name}: {what} after {waited_s:.3g} s{why}")

    def _stopped_error(self) -> ServiceStoppedError:
        return ServiceStoppedError(f"{self._name}: the program was asked to stop")

    def _closed_error(self) -> ServiceError:
        return ServiceError(f"{self._name}: the client has been destroyed")


def _check_timeout(timeout_s: float) -> None:
    if not isinstance(timeout_s, (int, float)) or math.isnan(timeout_s) or timeout_s < 0:
        hint = "; math.inf never ends" if timeout_s is None else ""
        raise ValueError(f"a timeout is a number of seconds from 0 up, not {timeout_s!r}{hint}")
