"""The ends of services of a recorded program: what comes from outside is an entry."""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias, TypeVar

from rosbase.contracts.service_call import ServiceCall
from rosbase.contracts.service_server import ServiceRequest, ServiceServer
from rosbase.contracts.services import ServiceFuture
from rosbase.entries.conductor import Conductor
from rosbase.entries.entrance import Entrance, Form, Remaker
from rosbase.entries.kinds import Kind, Numbered
from rosbase.entries.outcomes import error_from_json, error_to_json
from rosbase.entries.payloads import Json, from_json, to_json
from rosbase.entries.script import Entry
from rosbase.errors import ServiceError, ServiceFailedError
from rosbase.logger import RosbaseLogger
from rosbase.runtime.executor import Executor

__all__ = ["CallEntrance", "GuardedCall", "GuardedServer", "UnheardRequest"]

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")
Arrive: TypeAlias = Callable[[Any, ServiceError | None], object]
OnLate: TypeAlias = Callable[[], object]

_NUMBER_BYTES = 8


class UnheardRequest:
    """A request of a recording: whoever sent it is not there, and hears no answer."""

    def __init__(self, request: Any) -> None:
        self.request = request

    def done(self) -> bool:
        """Return whether nobody waits: no, so that it is answered as it was."""
        return False

    def set_result(self, response: Any) -> bool:
        """Drop the answer."""
        return True

    def set_exception(self, error: ServiceError) -> bool:
        """Drop the error."""
        return True


class GuardedServer(ServiceServer):
    """A service whose requests from outside are entries."""

    def __init__(
        self,
        name: str,
        answer: Callable[[Any], Any],
        executor: Executor,
        logger: RosbaseLogger,
        conductor: Conductor,
        find_form: Callable[[], Form],
    ) -> None:
        """Prepare a service.

        Args:
            name: As for `ServiceServer`.
            answer: Likewise.
            executor: Likewise.
            logger: Likewise.
            conductor: The conductor of the program.
            find_form: Returns the form of its requests, as for `Remaker`.
        """
        super().__init__(name, answer, executor, logger)
        self._entrance = Entrance(conductor, Kind.REQUEST, name, find_form, self._take_again)

    def take(self, call: ServiceRequest) -> None:
        """Queue a request. Call it from any thread."""
        if not self._entrance.is_inside:
            self._entrance.let_in(call.request, partial(self._take_from_outside, call))
            return
        if isinstance(call, GuardedCall) and call.number is None:
            # Nothing says so in a replay: it comes with the service that it has waited for.
            call.spoil("has called it before it was there")
        super().take(call)

    def _take_from_outside(self, call: ServiceRequest, request: Any) -> None:
        call.request = request
        super().take(call)

    def _take_again(self, request: Any) -> None:
        super().take(UnheardRequest(request))


class CallEntrance:
    """The way into the program for the answers of one client."""

    def __init__(
        self, conductor: Conductor, name: str, find_form: Callable[[], Form], on_late: OnLate
    ) -> None:
        """Number the client.

        Args:
            conductor: The conductor of the program.
            name: Full name of the service.
            find_form: Returns the form of its answers, as for `Remaker`.
            on_late: Called in a replay for an answer that comes after the end of its call.
        """
        self.conductor = conductor
        self._on_late = on_late
        self._remaker = Remaker(conductor, name, find_form)
        self._number = conductor.number(Numbered.CLIENT, name, self._replay)
        self._calls: dict[int, GuardedCall[Any, Any]] = {}
        self._count = 0

    def begin(
        self,
        service_name: str,
        request: Any,
        executor: Executor,
        on_end: Callable[[ServiceCall[Any, Any]], object],
        on_late: OnLate,
    ) -> "GuardedCall[Any, Any]":
        """Begin a call, as `ServiceCall` does."""
        call: GuardedCall[Any, Any] = GuardedCall(service_name, request, executor, on_end, on_late)
        call.entrance = self
        if self.conductor.is_inside:
            call.number, self._count = self._count, self._count + 1
            self._calls[call.number] = call
        return call

    def ask(self, is_ready: Callable[[], bool]) -> bool:
        """Return whether the service is there, which it may be in another process."""
        return bool(self.conductor.fact(is_ready))

    def forget(self, number: int | None) -> None:
        """Forget a call that has ended."""
        self._calls.pop(-1 if number is None else number, None)

    def let_in(
        self, number: int, response: Any, error: ServiceError | None, arrive: Arrive
    ) -> None:
        """Have the answer of another thread come in, as an entry."""
        if error is None:
            data, response = self._remaker.remake(response)
        else:
            data = to_json(_error_facts(error))
        self.conductor.come_in(
            Kind.ANSWER,
            (self._number, int(error is None)),
            number.to_bytes(_NUMBER_BYTES, "little") + data,
            lambda: arrive(response, error),
        )

    def _replay(self, entry: Entry) -> None:
        number = int.from_bytes(entry.payload[:_NUMBER_BYTES], "little")
        data, is_answer = entry.payload[_NUMBER_BYTES:], entry.ints[2]
        call = self._calls.get(number)
        if call is None:
            self._on_late()
        elif is_answer:
            call.set_result(self._remaker.make(data))
        else:
            call.set_exception(_error_of(from_json(data)))


class GuardedCall(ServiceCall[RequestT, ResponseT]):
    """A call whose answer is an entry if it comes from outside."""

    entrance: CallEntrance
    number: int | None = None
    """Number among the calls of the client; None if another thread has made it."""

    def add_done_callback(self, callback: Callable[[ServiceFuture[Any]], object]) -> None:
        """Call `callback(future)` on the main loop once it is done, or soon if it is."""
        if self.number is None:
            self.spoil("waits with a callback for the answer of its call")
        super().add_done_callback(callback)

    def expire_after(self, timeout_ns: int, make_error: Callable[[], ServiceError]) -> None:
        """Let the call fail unless it is done by then."""
        if self.number is None:
            self.spoil("calls it without waiting for the answer")
        super().expire_after(timeout_ns, make_error)

    def _arrive(self, response: ResponseT | None, error: ServiceError | None) -> bool:
        if self.number is None or self.entrance.conductor.is_inside:
            return super()._arrive(response, error)
        self.entrance.let_in(self.number, response, error, super()._arrive)
        return not self.done()

    def _now_ns(self) -> int:
        clock = self._executor.clock
        if self.number is None:
            # A replay does not have the call, and so must not miss what it reads.
            clock = getattr(clock, "machine", clock)
        return clock.monotonic_ns()

    def _end(self, response: ResponseT | None, error: ServiceError | None) -> bool:
        self.entrance.forget(self.number)
        return super()._end(response, error)

    def spoil(self, what: str) -> None:
        """Spoil the recording, because a thread of the program has done something."""
        reason = f"{self.service_name}: a thread of the program {what}"
        self.entrance.conductor.spoil(reason)


def _error_facts(error: ServiceError) -> Json:
    facts = error_to_json(error)
    reason = error.reason if isinstance(error, ServiceFailedError) else None
    return {**facts, "reason": reason} if isinstance(facts, dict) else facts


def _error_of(facts: Json) -> ServiceError:
    error = error_from_json(facts)
    if isinstance(error, ServiceFailedError) and isinstance(facts, dict):
        error.reason = str(facts["reason"])
    return error if isinstance(error, ServiceError) else ServiceError(str(error))
