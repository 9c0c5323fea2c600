"""Interfaces of services within one process: providers and links."""

from collections.abc import Iterable
from typing import Protocol

from rosbase.contracts.service_server import ServiceRequest

__all__ = ["Provider", "ServiceLinkEnd", "StandardServices"]


class Provider(Protocol):
    """A service of this process, or of another one behind a link."""

    def take(self, call: ServiceRequest) -> None:
        """Answer the request soon. Called on any thread."""
        ...


class ServiceLinkEnd(Protocol):
    """Interface through which the registry informs a link."""

    def service_changed(self, name: str, type_name: str, *, is_there: bool) -> None:
        """Note that a service that is not the other side's own has come or gone."""
        ...

    def standard_changed(self, nodes: Iterable[tuple[str, str]], *, is_there: bool) -> None:
        """Note that standard services that are not the other side's own have come or gone.

        Args:
            nodes: Full names of nodes, each with a kind of services.
            is_there: Whether they are there now.
        """
        ...


class StandardServices(Protocol):
    """The standard services of the nodes of one backend, or of another process."""

    def has(self, node: str, kind: str) -> bool:
        """Return whether a node has services of that kind. Called on any thread."""
        ...

    def nodes(self) -> list[tuple[str, str]]:
        """Return the full name of each node, such as `/camera`, with the kinds that it has."""
        ...

    def provider(self, node: str, kind: str, service: str) -> Provider:
        """Return whoever answers requests for a service of a node."""
        ...
