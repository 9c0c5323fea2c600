"""The ends of services: requests and answers of other processes come from the recording."""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias, TypeVar

from rosbase.contracts.guarded_services import UnheardRequest
from rosbase.contracts.message_format import MessageFormat
from rosbase.contracts.service_call import ServiceCall
from rosbase.contracts.service_callback import service_answer
from rosbase.contracts.service_client import ServiceClient
from rosbase.contracts.service_server import ServiceServer
from rosbase.contracts.services import ServiceCallback, ServiceType
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Numbered
from rosbase.entries.script import Entry
from rosbase.errors import ServiceError
from rosbase.logger import RosbaseLogger
from rosbase.runtime.executor import Executor

__all__ = ["ReplayedClient", "ReplayedServer"]

FindForm: TypeAlias = Callable[[Any], MessageFormat]

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


class ReplayedServer(ServiceServer):
    """Answers requests in bytes, as on the middleware, from the recording and from the program.

    A field that cannot be sent is a fault of the callback here too.
    """

    def __init__(
        self,
        conductor: Conductor,
        srv_type: ServiceType[Any, Any],
        name: str,
        callback: ServiceCallback[Any, Any],
        executor: Executor,
        logger: RosbaseLogger,
        form: FindForm,
    ) -> None:
        """Number the service.

        Args:
            conductor: The replay.
            srv_type: Type of the service.
            name: Its full name.
            callback: Answers a request.
            executor: As for `ServiceServer`.
            logger: Likewise.
            form: Returns the format of a class of messages.
        """
        read, write = form(srv_type.Request).decode, form(srv_type.Response).encode
        answer = service_answer(srv_type, name, callback)
        super().__init__(name, lambda data: write(answer(read(data))), executor, logger)
        conductor.number(Numbered.SERVICE, name, self._replay)

    def _replay(self, entry: Entry) -> None:
        self.take(UnheardRequest(entry.payload))


class ReplayedClient(ServiceClient[RequestT, ResponseT]):
    """Asks a service of the program itself; other answers come from the recording."""

    def __init__(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        name: str,
        executor: Executor,
        find_own: Callable[[], ServiceServer | None],
        form: FindForm,
    ) -> None:
        """Prepare a client, which has a number.

        Args:
            srv_type: Type of the service.
            name: Its full name.
            executor: The executor of the backend.
            find_own: Returns the service if the program has it.
            form: Returns the format of a class of messages.
        """
        super().__init__(srv_type, name, executor)
        self._write, self._form = form(srv_type.Request).encode, form(srv_type.Response)
        self._find_own = find_own

    def response_form(self) -> MessageFormat:
        """Return the form of the answers."""
        return self._form

    def service_is_ready(self) -> bool:
        """Return whether the service was there."""
        if self._entrance is None:
            return self._is_own()
        return self._entrance.ask(self._is_own)

    def send(self, call: ServiceCall[RequestT, ResponseT]) -> None:
        """Send the request of a call, if the program itself answers it."""
        try:
            request = self._write(call.request)
        except Exception:
            call.cancel()
            raise
        own = self._find_own()
        if own is not None:
            own.take(_OwnRequest(call, request, self._form.decode))

    def _is_own(self) -> bool:
        return not self.is_closed and self._find_own() is not None


class _OwnRequest:
    """A request of the program to itself, in bytes."""

    def __init__(
        self, call: ServiceCall[Any, Any], request: bytes, read: Callable[[bytes], Any]
    ) -> None:
        self.request: Any = request
        self.done = call.done
        self.set_exception: Callable[[ServiceError], bool] = call.set_exception
        self.set_result: Callable[[bytes], bool] = partial(_answer, call, read)


def _answer(call: ServiceCall[Any, Any], read: Callable[[bytes], Any], data: bytes) -> bool:
    return call.set_result(read(data))
