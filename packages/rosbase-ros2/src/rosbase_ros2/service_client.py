"""The calling end of a service: rclpy sends the requests and takes the answers.

rclpy's client would need another turn of the executor for each answer, and forget the ones that
come too late. So the method that finds its future is replaced, which rclpy calls on its thread.

A service of the same process is asked without the network. So its client is told why it has failed,
which ROS cannot send.
"""

import copy
import threading
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar
from weakref import WeakValueDictionary

from attrs import frozen
from rclpy.exceptions import InvalidHandle
from rclpy.serialization import deserialize_message, serialize_message

from rosbase import (
    Executor,
    ServiceCall,
    ServiceClient,
    ServiceError,
    ServiceFailedError,
    ServiceType,
    one_line,
)
from rosbase.entries.entrance import Form
from rosbase_ros2.refusals import RCLError, Refusals
from rosbase_ros2.service_courier import ServiceCourier
from rosbase_ros2.service_server import Received, RosService

__all__ = ["RosClient"]

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


class RosClient(ServiceClient[RequestT, ResponseT]):
    """Sends requests by rclpy, or to a service of this process."""

    def __init__(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        inner: Any,
        courier: ServiceCourier,
        executor: Executor,
        find_own: Callable[[], RosService | None],
        on_send: Callable[[], object],
        may_wait: Callable[[], bool],
        refusals: Refusals,
    ) -> None:
        """Take over a client of rclpy.

        Args:
            srv_type: Type of the service.
            inner: The client of rclpy.
            courier: Converts what the program handles.
            executor: Runs the callbacks of the program.
            find_own: Returns the service, if it is in this process.
            on_send: Called when a call has begun, so that `look` is called from now on.
            may_wait: Whether the thread of the caller may wait for an answer.
            refusals: Says why the middleware does not take a request.
        """
        super().__init__(srv_type, inner.service_name, executor)
        self.inner = inner
        """Client of rclpy."""
        self._request, self._response = courier.request, courier.response
        self._is_native = courier.is_native
        self._isolate = copy.deepcopy if courier.is_native else _same
        self._find_own = find_own
        self._on_send = on_send
        self._may_wait = may_wait
        self._refusals = refusals
        # By the number of rclpy, as long as somebody knows of the call. Guarded by the lock.
        self._sent: WeakValueDictionary[int, ServiceCall[Any, Any]] = WeakValueDictionary()
        self._unsent: list[tuple[ServiceCall[Any, Any], Any]] = []
        self._lock, self._order = threading.Lock(), threading.Lock()
        self._was_there = True
        inner.get_pending_request = self._find

    def check_thread(self) -> None:
        """Check that the caller is no callback of rclpy."""
        if not self._may_wait():
            raise ServiceError(
                f"{self.service_name}: a callback of rclpy may not wait for a service: use"
                " call_async there"
            )

    def service_is_ready(self) -> bool:
        """Return whether the service is there."""
        if self._entrance is not None:
            return self._entrance.ask(self._is_ready)
        return self._is_ready()

    def response_form(self) -> Form:
        """Return the form of the answers, for a recording."""
        kind = self._response_type
        if not self._is_native:
            return super().response_form()
        return _Form(lambda answer: bytes(serialize_message(answer)), partial(_read, kind))

    def send(self, call: ServiceCall[RequestT, ResponseT]) -> None:
        """Send the request of a call as soon as the service is there."""
        try:
            # A copy of what the program may change before it is sent.
            request = self._isolate(self._request.to_ros(call.request))
        except Exception:
            call.cancel()
            raise
        if not self._send_here(call, request):
            with self._lock:
                self._unsent.append((call, request))
            if self._is_there():
                self._send_waiting()
            self._on_send()

    def look(self) -> bool:
        """Look whether the service is there; return whether calls are under way.

        Requests that wait for it are sent, and calls of one that has gone fail. Called on the
        thread of rclpy.
        """
        with self._lock:
            self._unsent = [one for one in self._unsent if not one[0].done()]
            sent = [call for call in self._sent.values() if not call.done()]
        if not (sent or self._unsent):
            self._was_there = True
            return False
        is_there = self._is_there()
        if is_there or self._find_own():
            self._send_waiting()
        elif not self._was_there:
            # Not at the first look: its last answer may be here, and not yet be handled.
            for call in sent:
                call.set_exception(ServiceFailedError(self.service_name))
        self._was_there = is_there
        return True

    def _is_ready(self) -> bool:
        return not self.is_closed and (self._find_own() is not None or self._is_there())

    def _is_there(self) -> bool:
        try:
            return bool(self.inner.service_is_ready())
        except (InvalidHandle, RCLError):
            # The client or its context has ended.
            return False

    def _send_waiting(self) -> None:
        # One thread at a time, so that they are sent in order.
        with self._order:
            with self._lock:
                waiting, self._unsent = self._unsent, []
            for call, request in waiting:
                if not (call.done() or self._send_here(call, request)):
                    self._transmit(call, request)

    def _send_here(self, call: ServiceCall[Any, Any], request: Any) -> bool:
        """Hand the request to a service of this process; return whether there is one."""
        service = self._find_own()
        if service is None:
            return False
        entrance = self._entrance
        if entrance is not None and not entrance.conductor.is_inside:
            # A replay does not know that the service was there only now.
            entrance.conductor.spoil(
                f"{self.service_name}: a call has waited for the program itself"
            )

        def arrive(response: Any) -> None:
            self._arrive(call, self._isolate(response))

        service.take(Received(request, arrive, call.set_exception, call.done))
        return True

    def _transmit(self, call: ServiceCall[Any, Any], request: Any) -> None:
        try:
            with self._lock, self.inner.handle:
                # The lock: the answer may come before the number is noted.
                self._sent[self.inner.handle.send_request(request)] = call
        except InvalidHandle:
            # Whoever has destroyed it lets the call fail.
            pass
        except RCLError as error:
            reason = f"ROS did not send the request: {self._refusals.reason(error)}"
            call.set_exception(ServiceFailedError(self.service_name, reason))

    def _find(self, number: int) -> "_Answer":
        """Return what takes an answer, on the thread of rclpy."""
        with self._lock:
            call = self._sent.pop(number, None)
        return _Answer(partial(self._arrive, call))

    def _arrive(self, call: ServiceCall[Any, Any] | None, response: Any) -> None:
        if call is None:
            self.count_late()
            return
        try:
            answer = self._response.from_ros(response)
        except Exception as error:
            reason = one_line(f"the answer cannot be read: {type(error).__name__}: {error}")
            call.set_exception(ServiceFailedError(self.service_name, reason))
        else:
            call.set_result(answer)


@frozen
class _Form:
    encode: Callable[[Any], bytes]
    decode: Callable[[bytes], Any]


def _read(kind: Any, data: bytes) -> Any:
    return deserialize_message(data, kind)


class _Answer:
    """Receives an answer in place of a future: rclpy sets it on its thread."""

    def __init__(self, set_result: Callable[[Any], object]) -> None:
        self.set_result = set_result

    def _set_executor(self, executor: Any) -> None:
        """Need no executor: no callback waits."""


def _same(message: Any) -> Any:
    return message
