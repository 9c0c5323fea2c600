"""Services within one process, by name: their providers, clients, and requests without a provider.

A link leads to another process: it provides the services there, and learns which are here. A
service that the program has made itself comes before a standard one of the same name.
"""

import threading
from collections import deque
from collections.abc import Callable
from typing import Any

from rosbase.contracts.service_server import ServiceRequest
from rosbase.errors import BackendError, ServiceFailedError
from rosbase.local.service_interfaces import Provider, ServiceLinkEnd, StandardServices
from rosbase.local.standard.known import KnownServices, names_of

__all__ = ["ServiceRegistry", "type_name"]

_FEW_REQUESTS = 16


class _Service:
    """A service: its providers, its clients, and requests that wait for a provider."""

    __slots__ = ("_look_at", "clients", "providers", "type_name", "waiting")

    def __init__(self, type_name: str) -> None:
        self.type_name = type_name
        # Services of this process first.
        self.providers: tuple[tuple[Provider, ServiceLinkEnd | None], ...] = ()
        self.clients: tuple[Callable[[], object], ...] = ()
        self.waiting: deque[ServiceRequest] = deque()
        self._look_at = _FEW_REQUESTS

    def provider_for(self, asking: ServiceLinkEnd | None) -> Provider | None:
        """Return the first that is not on the side of the process that asks."""
        for provider, link in self.providers:
            if link is None or link is not asking:
                return provider
        return None

    def keep(self, call: ServiceRequest) -> None:
        """Keep a request until there is a provider; forget those that have ended, if many are."""
        if len(self.waiting) >= self._look_at:
            self.waiting = deque(one for one in self.waiting if not one.done())
            self._look_at = max(_FEW_REQUESTS, 2 * len(self.waiting))
        self.waiting.append(call)

    def take_waiting(self) -> deque[ServiceRequest]:
        """Return the requests that have waited for a provider."""
        waiting, self.waiting = self.waiting, deque()
        return waiting


class ServiceRegistry:
    """All services of a process, or of a test."""

    def __init__(self) -> None:
        self._services: dict[str, _Service] = {}
        self._standard = KnownServices()
        self._links: tuple[ServiceLinkEnd, ...] = ()
        self._lock = threading.Lock()

    def add_provider(
        self, name: str, kind: str, provider: Provider, link: ServiceLinkEnd | None = None
    ) -> None:
        """Add a service: it gets the requests that wait for it, and new ones from now on.

        Args:
            name: Full name of the service.
            kind: Its type (`type_name`).
            provider: Whoever answers the requests.
            link: The link behind which it is, if it is in another process.

        Raises:
            BackendError: The name has another type, or a service of this process already.
        """
        with self._lock:
            service = self._enter(name, kind)
            if link is None and any(other is None for _, other in service.providers):
                raise BackendError(f"there is a service {name} in this process already")
            found = (*service.providers, (provider, link))
            service.providers = tuple(sorted(found, key=lambda entry: entry[1] is not None))
            waiting = service.take_waiting()
            clients = service.clients
            self._tell_links(name, service)
        for call in waiting:
            provider.take(call)
        for changed in clients:
            changed()

    def remove_provider(self, name: str, provider: Provider) -> None:
        """Remove a service from `add_provider`."""
        with self._lock:
            service = self._services[name]
            service.providers = tuple(p for p in service.providers if p[0] is not provider)
            self._tell_links(name, service)
            self._leave(name)

    def add_standard(self, services: StandardServices, link: ServiceLinkEnd | None = None) -> None:
        """Add the standard services of nodes that may come and go, behind a link if it is one."""
        with self._lock:
            self._standard.add(services, link)

    def remove_standard(self, services: StandardServices) -> None:
        """Remove what was added by `add_standard`."""
        with self._lock:
            self._standard.remove(services)
            for node, kind in services.nodes():
                self._tell_links_of_standard(node, kind)

    def standard_changed(self, node: str, kind: str) -> None:
        """Note that standard services of a node, added before, have come or gone."""
        if not (self._services or self._links):
            # Nobody asks yet; without this, each node would cost some microseconds.
            return
        with self._lock:
            asked_for = [name for name in names_of(node, kind) if self._provider(name, None)]
            found = {name: self._services[name] for name in asked_for if name in self._services}
            waiting = [(name, service.take_waiting()) for name, service in found.items()]
            self._tell_links_of_standard(node, kind)
        for name, calls in waiting:
            for call in calls:
                self.send(name, call)
        for service in found.values():
            for changed in service.clients:
                changed()

    def add_client(self, name: str, kind: str, changed: Callable[[], object]) -> None:
        """Add a client: `changed` is called when a service of that name comes.

        Raises:
            BackendError: The name has another type.
        """
        with self._lock:
            service = self._enter(name, kind)
            service.clients = (*service.clients, changed)

    def remove_client(self, name: str, changed: Callable[[], object]) -> None:
        """Remove a client from `add_client`."""
        with self._lock:
            service = self._services[name]
            service.clients = tuple(other for other in service.clients if other != changed)
            self._leave(name)

    def is_served(self, name: str) -> bool:
        """Return whether there is a service of that name."""
        return self._provider(name, None) is not None

    def send(self, name: str, call: ServiceRequest) -> None:
        """Hand the request of a client to the service, now or when there is one."""
        with self._lock:
            service = self._services.get(name)
            provider = self._provider(name, None)
            if service is not None and provider is None:
                service.keep(call)
        if provider is not None:
            provider.take(call)

    def send_from(self, link: ServiceLinkEnd, name: str, call: ServiceRequest) -> None:
        """Hand a request of another process to the service."""
        with self._lock:
            provider = self._provider(name, link)
        if provider is None:
            # It was there when the other process sent the request.
            call.set_exception(ServiceFailedError(name))
        else:
            provider.take(call)

    def add_link(self, link: ServiceLinkEnd) -> None:
        """Tell the link which services are here, now and from now on."""
        with self._lock:
            self._links = (*self._links, link)
            for name, service in self._services.items():
                _tell(link, name, service)
            if nodes := self._standard.nodes(link):
                link.standard_changed(sorted(nodes), is_there=True)

    def remove_link(self, link: ServiceLinkEnd) -> None:
        """Stop telling the link. It must remove its own services."""
        with self._lock:
            self._links = tuple(other for other in self._links if other is not link)

    def _provider(self, name: str, asking: ServiceLinkEnd | None) -> Provider | None:
        """Return whoever answers a request; None if there is nobody."""
        service = self._services.get(name)
        provider = service.provider_for(asking) if service else None
        if provider is not None:
            return provider
        # Without a client here, the other process has looked at the type.
        kind = service.type_name if service and asking is None else None
        return self._standard.provider(name, asking, kind)

    def _tell_links_of_standard(self, node: str, kind: str) -> None:
        for link in self._links:
            is_there = self._standard.has(node, kind, link)
            link.standard_changed([(node, kind)], is_there=is_there)

    def _tell_links(self, name: str, service: _Service) -> None:
        for link in self._links:
            _tell(link, name, service)

    def _enter(self, name: str, kind: str) -> _Service:
        service = self._services.get(name)
        if service is None:
            service = self._services[name] = _Service(kind)
        if service.type_name != kind:
            known, other = (text.rpartition(".")[2] for text in (service.type_name, kind))
            raise BackendError(
                f"service {name} is of type {known}, so it cannot be of type {other}"
            )
        return service

    def _leave(self, name: str) -> None:
        service = self._services[name]
        if not service.providers and not service.clients:
            del self._services[name]


def type_name(srv_type: Any) -> str:
    """Return the name by which two processes compare a type, without importing it."""
    # The child of a program knows the program's main module by another name.
    module = srv_type.__module__.replace("__mp_main__", "__main__")
    return f"{module}.{srv_type.__qualname__}"


def _tell(link: ServiceLinkEnd, name: str, service: _Service) -> None:
    is_there = service.provider_for(link) is not None
    link.service_changed(name, service.type_name, is_there=is_there)
