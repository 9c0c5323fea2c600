"""Answers about services, and calls of them."""

from functools import partial
from typing import Any

from rosbase.clock import SystemClock
from rosbase.contracts.backend import Backend
from rosbase.contracts.services import ServiceFuture
from rosbase.control.answers.ends import (
    all_graphs,
    find_class,
    find_service,
    format_facts,
    format_of,
    program_for,
    type_class,
)
from rosbase.control.claim import Claim
from rosbase.control.programs import Program
from rosbase.control.requests import DEFAULT_TIMEOUT_NS, Answerer, Later, Request
from rosbase.control.session import Session
from rosbase.errors import BackendError, ControlError, ServiceError, ServiceTimeoutError, WireError

__all__ = ["ANSWERS"]

_CLOCK = SystemClock()
_NS_PER_S = 1_000_000_000
# The client of the backend says why there is no answer, and needs a moment for it.
_GRACE_NS = 500_000_000


def _list(_: Session, __: Request) -> dict[str, Any]:
    services: dict[tuple[str, str], dict[str, Any]] = {}
    for _program, _backend, graph in all_graphs():
        for kind, ends in (("servers", graph.services), ("clients", graph.clients)):
            for end in ends:
                service = services.setdefault(
                    (end.name, end.type_name),
                    {"name": end.name, "type": end.type_name, "servers": [], "clients": []},
                )
                service[kind].append(end.node)
    return {"services": [services[key] for key in sorted(services)]}


def _type(_: Session, request: Request) -> dict[str, Any]:
    name = request.text("service", "")
    if name:
        _program, backend, end = find_service(name)
        type_name, kind = end.type_name, type_class(backend, end.type_name, end.srv_type)
    else:
        type_name = request.text("type")
        backend, kind = find_class(type_name)
    return {
        "type": type_name,
        "request": format_facts(format_of(backend, f"{type_name}_Request", _part(kind, "Request"))),
        "response": format_facts(
            format_of(backend, f"{type_name}_Response", _part(kind, "Response"))
        ),
    }


def _part(kind: Any, name: str) -> Any:
    part = getattr(kind, name, None)
    if part is None:
        raise ControlError(f"{kind!r} is no type of a service"[:200], "invalid")
    return part


def _call(_: Session, request: Request) -> Later:
    name, wanted = request.text("service"), request.text("type", "")
    program, backend, full_name, type_name, kind = _target(name, wanted)
    kind = type_class(backend, type_name, kind)
    requests = format_of(backend, f"{type_name}_Request", _part(kind, "Request"))
    responses = format_of(backend, f"{type_name}_Response", _part(kind, "Response"))
    try:
        question = requests.decode(request.data)
    except WireError as error:
        raise ControlError(str(error)[:1000], "invalid") from None
    if program.phase == "stopping":
        raise ControlError(f"{program.name} is stopping", "refused")
    call = _ServiceCall(request, backend, full_name, kind, responses.encode)
    timeout_ns = request.whole("timeout_ns", DEFAULT_TIMEOUT_NS, 1)
    request.arguments["timeout_ns"] = timeout_ns + _GRACE_NS
    later = request.wait(partial(call.give_up, program))
    backend.executor.call_as_guest(partial(call.begin, question, timeout_ns))
    return later


def _target(name: str, wanted: str) -> tuple[Program, Backend, str, str, Any]:
    """Return where to call, the full name, and the type of a service: its own if it is here."""
    try:
        program, backend, end = find_service(name)
    except ControlError:
        if not wanted:
            raise
        # It may be one of another program.
        program, backend = program_for("")
        return program, backend, name, wanted, None
    if wanted not in ("", end.type_name):
        raise ControlError(f"{end.name} is of type {end.type_name}, not {wanted[:200]}", "invalid")
    return program, backend, end.name, end.type_name, end.srv_type


class _ServiceCall:
    """A call of a service: begun on the main loop, answered when the answer comes."""

    def __init__(
        self, request: Request, backend: Backend, name: str, kind: Any, encode: Any
    ) -> None:
        self._request = request
        self._backend = backend
        self._name = name
        self._kind = kind
        self._encode = encode
        self._begin_ns = 0
        self._claim = Claim()

    def begin(self, question: Any, timeout_ns: int) -> None:
        """Send the request. Called by the main loop."""
        if not self._claim.take():
            return
        self._begin_ns = _CLOCK.monotonic_ns()
        try:
            client = self._backend.create_client(self._kind, self._name)
        except BackendError as error:
            self._request.fail(ControlError(str(error), "invalid"))
            return
        try:
            future = client.call_async(question, timeout_ns / _NS_PER_S)
            future.add_done_callback(partial(self._end, client))
        except Exception as error:
            self._backend.destroy_client(client)
            self._request.fail(ControlError(f"{type(error).__name__}: {error}"[:1000]))

    def give_up(self, program: Program) -> str:
        """Say why there is no answer."""
        if self._claim.take():
            return f"the main loop of {program.name} is busy: {self._name} was not called"
        return f"{self._name} has not answered, and the main loop of {program.name} is busy"

    def _end(self, client: Any, future: ServiceFuture[Any]) -> None:
        """Answer. Called by the main loop."""
        self._backend.destroy_client(client)
        try:
            data = self._encode(future.result())
        except ServiceTimeoutError as error:
            self._request.fail(ControlError(str(error), "timeout"))
        except (ServiceError, TypeError, ValueError) as error:
            self._request.fail(ControlError(str(error)[:1000]))
        else:
            took_ns = _CLOCK.monotonic_ns() - self._begin_ns
            self._request.answer({"took_ns": took_ns}, data)


ANSWERS: dict[str, Answerer] = {
    "service.list": _list,
    "service.type": _type,
    "service.call": _call,
}
