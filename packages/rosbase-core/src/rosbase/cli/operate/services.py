"""`rosbase service list`, `type` and `call`."""

from __future__ import annotations

from rosbase.control.names import is_hidden
from rosbase.control.questions.services import ServiceQuestions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

__all__ = ["call", "show_list", "show_type"]


def show_list(given: Any) -> None:
    """Print the names of the services, one a line, as `ros2 service list` does."""
    types: dict[str, list[str]] = {}
    for service in ServiceQuestions(given.program).services():
        if service["servers"] and (given.all or not is_hidden(service["name"])):
            known = types.setdefault(service["name"], [])
            known += [service["type"]] * (service["type"] not in known)
    if given.count_services:
        print(len(types))
        return
    for name, of in types.items():
        print(name + (f" [{', '.join(of)}]" if given.show_types else ""))


def show_type(given: Any) -> None:
    """Print the type of a service."""
    print(ServiceQuestions(given.program).find_service(given.service, None)[2])


def call(given: Any) -> None:
    """Call a service; print the request and the response as `ros2 service call` does."""
    from rosbase.cli.operate.values import (
        as_call,
        decoded,
        encoded,
        parsed,
        read_values,
    )

    kind, text = given.type, given.values
    if kind is not None and text is None and _is_values(kind):
        kind, text = None, kind
    request = read_values(text)
    service = ServiceQuestions(given.program).prepare(given.service, kind)
    data = encoded(service.encode, request)
    shown = decoded(service.request, data)
    print(f"requester: making request: {shown}\n", flush=True)
    answer = service.call(data, given.timeout)
    print(f"response:\n{as_call(parsed(service.response), answer)}\n")


def _is_values(text: str) -> bool:
    """Return whether a text is values, and no type such as std_srvs/srv/Trigger."""
    return text[:1] in ("{", "[", '"', "'") or ":" in text
