"""Services shared with one other process: the part of a link that is about them.

Each side tells the other the services that it has, by name and type, and answers requests for them.
"""

import threading
from collections.abc import Callable, Iterable
from functools import partial
from itertools import count
from types import NoneType
from typing import Any

from rosbase.contracts.service_server import MOST_WAITING, ServiceRequest
from rosbase.errors import ServiceError, ServiceFailedError
from rosbase.local.service_registry import ServiceRegistry

__all__ = ["Kinds", "ServiceLink"]

Kinds = dict[str, tuple[Callable[..., None], tuple[Any, ...]]]
"""By the first word of a message: what is done with the other values, and of which types they are.
"""

Send = Callable[..., str]
"""Sends some values to the other side at once; returns the reason if they cannot be sent."""


class ServiceLink:
    """Services of one side of a link, and requests under way to the other side."""

    def __init__(
        self,
        registry: ServiceRegistry,
        send: Send,
        call_soon: Callable[[Callable[[], object]], object],
    ) -> None:
        """Prepare one end.

        Args:
            registry: The services to share.
            send: For the sending thread.
            call_soon: Asks the sending thread to call a function.
        """
        self._registry = registry
        self._send = send
        self._call_soon = call_soon
        self._told: set[str] = set()
        self._there: dict[str, _RemoteService] = {}
        self._told_standard: set[tuple[str, str]] = set()
        self._standard_there = _RemoteStandard(self)
        # What the other side was asked and has not answered.
        self._asked: dict[int, tuple[str, ServiceRequest]] = {}
        self._unsent = 0
        self._lock = threading.Lock()
        self._numbers = count(1)
        self._is_closed = False
        self.kinds: Kinds = {
            "serve": (self._take_serve, (str, str, bool)),
            "standard": (self._take_standard, (list, bool)),
            "request": (self._take_request, (str, int, object)),
            "answer": (self._take_answer, (int, object, (str, NoneType))),
        }
        """Messages from the other end."""

    def start(self) -> None:
        """Start to share services."""
        self._registry.add_standard(self._standard_there, self)
        self._registry.add_link(self)

    def service_changed(self, name: str, type_name: str, *, is_there: bool) -> None:
        """Tell the other side that a service has come or gone."""
        if is_there == (name in self._told):
            return
        (self._told.add if is_there else self._told.discard)(name)
        self._call_soon(partial(self._send, "serve", name, type_name, is_there))

    def standard_changed(self, nodes: Iterable[tuple[str, str]], *, is_there: bool) -> None:
        """Tell the other side that the standard services of nodes have come or gone."""
        changed = [one for one in nodes if is_there != (one in self._told_standard)]
        if changed:
            self._told_standard.symmetric_difference_update(changed)
            self._call_soon(partial(self._send, "standard", changed, is_there))

    def ask(self, name: str, call: ServiceRequest) -> None:
        """Send a request to the other side. Call it from any thread."""
        with self._lock:
            is_full, is_closed = self._unsent >= MOST_WAITING, self._is_closed
            if not (is_full or is_closed):
                self._unsent += 1
                number = next(self._numbers)
                self._forget_late()
                self._asked[number] = name, call
        if is_closed:
            call.set_exception(ServiceFailedError(name))
        elif is_full:
            reason = f"{MOST_WAITING} requests wait to be sent already"
            call.set_exception(ServiceFailedError(name, reason))
        else:
            self._call_soon(partial(self._send_request, number, name, call))

    def close(self) -> None:
        """End the services of the other side: what it was asked fails. Idempotent."""
        self._registry.remove_link(self)
        while self._there:
            name, remote = self._there.popitem()
            self._registry.remove_provider(name, remote)
        self._registry.remove_standard(self._standard_there)
        with self._lock:
            self._is_closed = True
            asked, self._asked = self._asked, {}
        for name, call in asked.values():
            call.set_exception(ServiceFailedError(name))

    def _forget_late(self) -> None:
        """Forget calls that have ended, if there are many: their answers may never come."""
        if len(self._asked) >= MOST_WAITING:
            left = {number: one for number, one in self._asked.items() if not one[1].done()}
            self._asked = left

    # On the sending thread.

    def _send_request(self, number: int, name: str, call: ServiceRequest) -> None:
        with self._lock:
            self._unsent -= 1
        if call.done():
            reason = ""
        elif not (reason := self._send("request", name, number, call.request)):
            return
        with self._lock:
            self._asked.pop(number, None)
        if reason:
            call.set_exception(ServiceFailedError(name, reason))

    def _send_answer(self, number: int, response: Any, reason: str | None) -> None:
        """Send an answer, or the reason why there is none."""
        if failure := self._send("answer", number, response, reason):
            self._send("answer", number, None, failure)

    # On the receiving thread.

    def _take_serve(self, name: str, type_name: str, is_there: bool) -> None:
        if is_there and name not in self._there:
            remote = _RemoteService(name, self)
            self._registry.add_provider(name, type_name, remote, self)
            self._there[name] = remote
        elif not is_there and name in self._there:
            # The other side answers what it was asked before, if only that the service has gone.
            self._registry.remove_provider(name, self._there.pop(name))

    def _take_standard(self, nodes: list[tuple[str, str]], is_there: bool) -> None:
        self._standard_there.note(nodes, is_there=is_there)
        for node, kind in nodes:
            self._registry.standard_changed(node, kind)

    def _take_request(self, name: str, number: int, request: Any) -> None:
        def answer(response: Any, reason: str | None) -> None:
            self._call_soon(partial(self._send_answer, number, response, reason))

        self._registry.send_from(self, name, _RemoteRequest(request, answer))

    def _take_answer(self, number: int, response: Any, reason: str | None) -> None:
        with self._lock:
            name, call = self._asked.pop(number, ("", None))
        if call is None:
            return
        if reason is None:
            call.set_result(response)
        else:
            call.set_exception(ServiceFailedError(name, reason))


class _RemoteService:
    """A service of the other side."""

    def __init__(self, name: str, link: ServiceLink) -> None:
        self._name = name
        self._link = link

    def take(self, call: ServiceRequest) -> None:
        """Send the request to the other side."""
        self._link.ask(self._name, call)


class _RemoteStandard:
    """Standard services of the nodes of the other side."""

    def __init__(self, link: ServiceLink) -> None:
        self._link = link
        # Replaced, so that other threads may read it.
        self._nodes: frozenset[tuple[str, str]] = frozenset()

    def note(self, nodes: Iterable[tuple[str, str]], *, is_there: bool) -> None:
        """Note that services have come or gone."""
        self._nodes = self._nodes.union(nodes) if is_there else self._nodes.difference(nodes)

    def has(self, node: str, kind: str) -> bool:
        """Return whether a node of the other side has services of that kind."""
        return (node, kind) in self._nodes

    def nodes(self) -> list[tuple[str, str]]:
        """Return the nodes and kinds of the other side."""
        return sorted(self._nodes)

    def provider(self, node: str, kind: str, service: str) -> _RemoteService:
        """Return whoever sends requests for a service to the other side."""
        return _RemoteService(f"{node}/{service}", self._link)


class _RemoteRequest:
    """A request of the other side."""

    def __init__(self, request: Any, answer: Callable[[Any, str | None], None]) -> None:
        self.request = request
        self._answer = answer
        self._is_done = False

    def done(self) -> bool:
        """Return whether it has its answer."""
        return self._is_done

    def set_result(self, response: Any) -> bool:
        """Send the answer."""
        self._is_done = True
        self._answer(response, None)
        return True

    def set_exception(self, error: ServiceError) -> bool:
        """Send the reason why there is no answer."""
        self._is_done = True
        self._answer(None, error.reason if isinstance(error, ServiceFailedError) else str(error))
        return True
