"""Help for checks of services: ends that carry numbers, and callers that may hang."""

from collections.abc import Callable
from typing import Any

from rosbase.contracts.backend import Backend
from rosbase.contracts.services import Client
from rosbase.errors import ServiceError
from rosbase.testing.backend_kit.promises import promise
from rosbase.testing.backend_kit.rig import BackendRig
from rosbase.testing.promise import BrokenPromiseError, Promise
from rosbase.testing.seen import raised

__all__ = ["ServiceRig", "take_over"]


class ServiceRig(BackendRig):
    """Base class of checks that create services and call them."""

    def begin(self, name: str) -> tuple[Promise, Backend]:
        """Return a promise and a backend, if backends of this kind have services."""
        self.needs("has_services")
        self._kept: list[Exception] = []
        return promise(name), self.open()

    def serve(self, backend: Backend, name: str) -> list[int]:
        """Create a service that answers the next number; return the numbers that come."""
        served: list[int] = []

        def answer(request: Any) -> Any:
            served.append(self.service_kind.number(request))
            return self.answer(request)

        backend.create_service(self.service_kind.srv_type, name, answer)
        return served

    def answer(self, request: Any, response: Any = None) -> Any:
        """Answer a request with the next number."""
        return self.service_kind.response(self.service_kind.number(request) + 1)

    def client(self, backend: Backend, name: str) -> Client[Any, Any]:
        """Create a client."""
        return backend.create_client(self.service_kind.srv_type, name)

    def ask(self, client: Client[Any, Any], number: int, timeout_s: float | None = None) -> int:
        """Call with a number; return the answer's number."""
        limit_s = self.patience_s if timeout_s is None else timeout_s
        answer = client.call(self.service_kind.request(number), timeout_s=limit_s)
        return self.service_kind.number(answer)

    def fails(self, promised: Promise, call: Callable[[], object]) -> ServiceError:
        """Return the error of a call that must fail, with one line."""
        try:
            call()
        except ServiceError as error:
            promised.require("\n" not in str(error), f"the error has several lines: {error}")
            return error
        raise promised.broken("a call that cannot have an answer raised no ServiceError")

    def calling(self, promised: Promise, backend: Backend, work: Callable[[], object]) -> None:
        """Do it on a thread that spins the backend, which may hang if a promise is broken."""

        def spin_and_work() -> None:
            take_over(backend)
            work()

        self.on_thread(promised, self.keeping(spin_and_work), "a call")
        self.require_kept(promised)

    def keeping(self, work: Callable[[], object]) -> Callable[[], object]:
        """Keep the failure of a check for the thread of the test."""

        def keep() -> None:
            try:
                work()
            except Exception as error:
                self._kept.append(error)

        return keep

    def require_kept(self, promised: Promise) -> None:
        """Raise the first kept failure; an exception of another kind breaks the promise."""
        for error in self._kept:
            if isinstance(error, BrokenPromiseError):
                raise error
            raise promised.broken(raised("a call", error)) from error


def take_over(backend: Backend) -> None:
    """Become the thread that spins."""
    backend.spin_until(backend.executor.clock.monotonic_ns(), lambda: False)
