"""Which nodes have standard services, in this process and behind its links."""

from collections.abc import Iterator

from rosbase.local.service_interfaces import Provider, ServiceLinkEnd, StandardServices
from rosbase.local.standard.catalog import TYPES, standard_type

__all__ = ["KnownServices", "names_of"]


class KnownServices:
    """The standard services of all nodes. Changes are guarded by the registry.

    Of several nodes with one name, one of this process answers, and of those the first.
    """

    def __init__(self) -> None:
        # Those of this process first; replaced, so that reading needs no lock.
        self._all: tuple[tuple[StandardServices, ServiceLinkEnd | None], ...] = ()

    def add(self, services: StandardServices, link: ServiceLinkEnd | None) -> None:
        """Add the services of a backend, or of the other side of a link."""
        found = (*self._all, (services, link))
        self._all = tuple(sorted(found, key=lambda entry: entry[1] is not None))

    def remove(self, services: StandardServices) -> None:
        """Remove services. Do nothing if they have been removed."""
        self._all = tuple(entry for entry in self._all if entry[0] is not services)

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
        return (services for services, link in self._all if link is None or link is not asking)


def names_of(node: str, kind: str) -> list[str]:
    """Return the full names of the standard services of a node."""
    return [f"{node}/{service}" for service in TYPES.get(kind, ())]
