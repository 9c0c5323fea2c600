"""The callback of a service, checked: what backends call for each request."""

import inspect
from collections.abc import Callable
from typing import Any, TypeVar

from rosbase.contracts.services import ServiceCallback, ServiceType
from rosbase.errors import BackendError
from rosbase.text.printable import printable

__all__ = ["check_service_type", "service_answer"]

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


def check_service_type(srv_type: object, name: object) -> None:
    """Refuse a type of a service that has no classes `Request` and `Response`.

    Raises:
        BackendError: It has not; the message names the service.
    """
    for part in ("Request", "Response"):
        if not inspect.isclass(getattr(srv_type, part, None)):
            raise BackendError(
                f"service {printable(repr(name))} takes a class with Request and Response,"
                f" not {printable(repr(srv_type))}"
            )


def service_answer(
    srv_type: ServiceType[RequestT, ResponseT],
    name: str,
    callback: ServiceCallback[RequestT, ResponseT],
) -> Callable[[RequestT], ResponseT]:
    """Return a function that answers a request by that callback, and checks the answer.

    A callback of two parameters without defaults, or of `*args`, also gets a new `Response()`, or
    None if it cannot be made without arguments.

    Args:
        srv_type: Type of the service.
        name: Its name, for errors. The function raises TypeError for an answer of another class.
        callback: The function of the program.
    """
    ask: Callable[..., Any] = callback
    kind: Any = srv_type.Response
    takes_both = _takes_two(ask)
    make: Callable[[], object] = kind
    if takes_both and not _can_be_made(make):
        make = _none

    def answer(request: RequestT) -> ResponseT:
        response = ask(request, make()) if takes_both else ask(request)
        if not isinstance(response, kind):
            raise TypeError(
                f"the callback of {name} returned {type(response).__name__},"
                f" not {getattr(srv_type, '__name__', srv_type)}.Response"
            )
        return response  # type: ignore[no-any-return]  # as has just been seen

    return answer


def _takes_two(callback: Callable[..., object]) -> bool:
    try:
        signature = inspect.signature(callback)
    except ValueError:
        # Some builtins have none.
        return True
    kinds = {parameter.kind for parameter in signature.parameters.values()}
    # A second parameter with a default is the program's own, such as `name=name` of a lambda.
    # With `*args`, as of a decorated function, it gets what rclpy would give it.
    takes_one = _binds(signature, None) and inspect.Parameter.VAR_POSITIONAL not in kinds
    return _binds(signature, None, None) and not takes_one


def _binds(signature: inspect.Signature, *arguments: object) -> bool:
    try:
        signature.bind(*arguments)
    except TypeError:
        return False
    return True


def _can_be_made(make: Callable[[], object]) -> bool:
    try:
        make()
    except TypeError:
        return False
    return True


def _none() -> None:
    """Return nothing, in place of an answer that cannot be made."""
