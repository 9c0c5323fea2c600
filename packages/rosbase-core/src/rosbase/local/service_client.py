"""The client of a service: hands its requests to the one that answers them."""

from typing import Any, TypeVar

from rosbase.contracts.service_call import ServiceCall
from rosbase.contracts.service_client import ServiceClient
from rosbase.contracts.services import ServiceType
from rosbase.local.isolation import isolated
from rosbase.local.service_registry import ServiceRegistry
from rosbase.runtime.executor import Executor

__all__ = ["LocalClient"]

RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


class LocalClient(ServiceClient[RequestT, ResponseT]):
    """A client of the services of this process, and of those behind its links."""

    def __init__(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        name: str,
        executor: Executor,
        registry: ServiceRegistry,
    ) -> None:
        super().__init__(srv_type, name, executor)
        self._registry = registry
        self._isolate = isolated(_same, srv_type.Request)

    def service_is_ready(self) -> bool:
        """Return whether the service is there."""
        if self._entrance is not None:
            return self._entrance.ask(self._is_served)
        return self._is_served()

    def send(self, call: ServiceCall[RequestT, ResponseT]) -> None:
        """Send the request of a call as soon as the service is there."""
        call.request = self._isolate(call.request)
        self._registry.send(self.service_name, call)

    def _is_served(self) -> bool:
        return not self.is_closed and self._registry.is_served(self.service_name)


def _same(request: Any) -> Any:
    return request
