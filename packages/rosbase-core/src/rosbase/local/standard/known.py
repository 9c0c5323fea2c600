"""Which nodes have standard services, in this process and behind its links."""

import weakref
from collections.abc import Iterator
from typing import TypeAlias

from rosbase.local.service_interfaces import Provider, ServiceLinkEnd, StandardServices
from rosbase.local.standard.catalog import TYPES, standard_type

__all__ = ["KnownServices", "names_of"]

_Entry: TypeAlias = tuple["weakref.ref[StandardServices]", ServiceLinkEnd | None]


class KnownServices:
    """The standard services of all nodes. Changes are guarded by the registry.

    Of several nodes with one name, one of this process answers, and of those the newest. A backend
    that nobody closes can be collected all the same, because it is not kept here.
    """

    def __init__(self) -> None:
        # This process's first; replaced, so that reading needs no lock.
        self._all: tuple[_Entry, ...] = ()

    def add(self, services: StandardServices, link: ServiceLinkEnd | None) -> None:
        """Add the services of a backend, or of the other side of a link."""
        entry, known = (weakref.ref(services), link), self._without(None)
        self._all = (entry, *known) if link is None else (*known, entry)

    def remove(self, services: StandardServices) -> None:
        """Remove services. Do nothing if they have been removed."""
        self._all = self._without(services)

    def has(self, node: str, kind: str, asking: ServiceLinkEnd | None) -> bool:
        """Return whether a node has services of that kind not on the side of `asking`."""
        return any(services.has(node, kind) for services in self._not_of(asking))

    def provider(
        self, name: str, asking: ServiceLinkEnd | None, type_name: str | None = None
    ) -> Provider | None:
        """Return whoever answers for a service.

        Args:
            name: Full name of the service.
            asking: The link behind which the client is, if it is in another process.
            type_name: Type for which the client asks; None if the other process has checked it.
        """
        node, _, service = name.rpartition("/")
        for kind in TYPES:
            standard = standard_type(kind, service)
            if standard and type_name in (standard, None):
                for services in self._not_of(asking):
                    if services.has(node, kind):
                        return services.provider(node, kind, service)
        return None

    def nodes(self, asking: ServiceLinkEnd | None) -> set[tuple[str, str]]:
        """Return the nodes and kinds that are not on the side of `asking`."""
        return {one for services in self._not_of(asking) for one in services.nodes()}

    def _not_of(self, asking: ServiceLinkEnd | None) -> Iterator[StandardServices]:
        for found, link in self._all:
            services = found()
            if services is not None and (link is None or link is not asking):
                yield services

    def _without(self, removed: StandardServices | None) -> tuple[_Entry, ...]:
        return tuple(one for one in self._all if one[0]() not in (removed, None))


def names_of(node: str, kind: str) -> list[str]:
    """Return the full names of the standard services of a node."""
    return [f"{node}/{service}" for service in TYPES.get(kind, ())]
