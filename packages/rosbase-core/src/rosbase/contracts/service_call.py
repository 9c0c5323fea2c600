"""One call of a service, from the request to its answer or error."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any, Generic, TypeVar

from rosbase.contracts.services import ServiceFuture
from rosbase.errors import ServiceError
from rosbase.runtime.executor import Executor, ExecutorTimer

__all__ = ["ServiceCall"]

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


class ServiceCall(Generic[RequestT, ResponseT]):
    """A request, and the future of its answer, which a backend sets from any thread."""

    def __init__(
        self,
        service_name: str,
        request: RequestT,
        executor: Executor,
        on_end: Callable[["ServiceCall[Any, Any]"], object],
        on_late: Callable[[], object],
    ) -> None:
        """Begin a call.

        Args:
            service_name: Full name of the service.
            request: The request to send.
            executor: Runs the callbacks of the future.
            on_end: Called once, when it is done, on the thread that sets the answer.
            on_late: Called for each answer that comes after that.
        """
        self.service_name = service_name
        self.request = request
        self._executor = executor
        self._on_end = on_end
        self._on_late = on_late
        # Guards what follows; held for a few instructions.
        self._lock = threading.Lock()
        self._is_done = self._is_cancelled = False
        self._response: ResponseT | None = None
        self._error: ServiceError | None = None
        self._timer: ExecutorTimer | None = None
        self._deadline_ns: int | None = None
        self._make_error: Callable[[], ServiceError] | None = None
        self._callbacks: list[Callable[[ServiceFuture[Any]], object]] = []

    # For whoever calls.

    def done(self) -> bool:
        """Return whether there is an answer or an error, or the call was cancelled."""
        return self._is_done

    def result(self) -> ResponseT:
        """Return the answer."""
        if not self._is_done:
            raise ServiceError(f"{self.service_name}: the answer is not there yet")
        if self._error is not None:
            raise self._error
        return self._response  # type: ignore[return-value]  # there is one, or an error

    def exception(self) -> ServiceError | None:
        """Return the error of a call that has failed or was cancelled."""
        return self._error

    def cancel(self) -> None:
        """Stop waiting for the answer, if it is not there."""
        if self._end(None, ServiceError(f"{self.service_name}: the call was cancelled")):
            self._is_cancelled = True

    def cancelled(self) -> bool:
        """Return whether `cancel` came before the answer."""
        return self._is_cancelled

    def add_done_callback(self, callback: Callable[[ServiceFuture[Any]], object]) -> None:
        """Call `callback(future)` on the main loop once it is done, or soon if it is."""
        with self._lock:
            if not self._is_done:
                self._callbacks.append(callback)
                return
        self._executor.call_soon(partial(callback, self))

    # For the backend.

    def set_result(self, response: ResponseT) -> bool:
        """Set the answer; return False if nobody waits for it any more."""
        return self._arrive(response, None)

    def set_exception(self, error: ServiceError) -> bool:
        """Let the call fail; return False if nobody waits for it any more."""
        return self._arrive(None, error)

    # For the client.

    def expire(self, error: ServiceError) -> None:
        """Let the call fail, unless its answer is there."""
        self._end(None, error)

    def limit(self, deadline_ns: int, make_error: Callable[[], ServiceError]) -> None:
        """Take no answer after the deadline, on the monotonic clock: the call fails instead."""
        self._deadline_ns, self._make_error = deadline_ns, make_error

    def expire_after(self, timeout_ns: int, make_error: Callable[[], ServiceError]) -> None:
        """Let the call fail unless it is done by then."""
        self.limit(self._now_ns() + timeout_ns, make_error)
        timer = self._executor.create_timer(timeout_ns, lambda: self.expire(make_error()))
        with self._lock:
            if not self._is_done:
                self._timer = timer
                return
        timer.destroy()

    def _arrive(self, response: ResponseT | None, error: ServiceError | None) -> bool:
        # Whoever would let it fail may be busy, perhaps with the service itself.
        if self._make_error is not None and self._is_late():
            self.expire(self._make_error())
        is_awaited = self._end(response, error)
        if not is_awaited:
            self._on_late()
        return is_awaited

    def _is_late(self) -> bool:
        deadline_ns = self._deadline_ns
        return deadline_ns is not None and self._now_ns() > deadline_ns

    def _now_ns(self) -> int:
        return self._executor.clock.monotonic_ns()

    def _end(self, response: ResponseT | None, error: ServiceError | None) -> bool:
        with self._lock:
            if self._is_done:
                return False
            self._response, self._error = response, error
            self._is_done = True
            callbacks, self._callbacks = self._callbacks, []
            timer, self._timer = self._timer, None
        if timer is not None:
            timer.destroy()
        self._on_end(self)
        for callback in callbacks:
            self._executor.call_soon(partial(callback, self))
        return True
