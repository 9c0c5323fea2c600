"""The `local` backend: topics, services, timers and parameters within one process."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from rosbase.contracts.backend import Backend, BackendOptions, Publisher, Subscription
from rosbase.contracts.names import resolve_topic
from rosbase.contracts.node_connection import NodeConnection
from rosbase.contracts.parameter_store import ParameterStore
from rosbase.contracts.services import Client, Service, ServiceCallback, ServiceType
from rosbase.contracts.stored_parameters import StoredParameters
from rosbase.contracts.tap import Tap
from rosbase.entries.conductor import conductor_of
from rosbase.errors import BackendError
from rosbase.lifecycle import ManagedNode
from rosbase.local.bus import Bus, process_bus
from rosbase.local.endpoints import LocalPublisher, LocalSubscription, make_publisher
from rosbase.local.node import LocalNode
from rosbase.local.service_registry import type_name
from rosbase.local.standard.offers import StandardOffers
from rosbase.logger import make_logger
from rosbase.parameters import Parameter, ParameterSpec, SetParametersResult
from rosbase.qos import QoSProfile, as_profile

if TYPE_CHECKING:
    from rosbase.contracts.graph import Graph, TopicEnd
    from rosbase.contracts.service_server import ServiceServer
    from rosbase.local.guard import Guard
    from rosbase.local.service_client import LocalClient

__all__ = ["LocalBackend"]

MessageT = TypeVar("MessageT")
RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


class LocalBackend(StoredParameters, Backend):
    """Connects a node to the other nodes of this process."""

    delivers_in_process = True

    def __init__(self, options: BackendOptions, bus: Bus | None = None) -> None:
        """Open the backend on the bus of this process, or on a given one."""
        super().__init__(options.clock, options.node_name)
        self._options = options
        self._bus = bus or process_bus()
        self._guard = self._make_guard()
        self._logger = logger = make_logger(options.node_name, None, options.clock)
        self._parameters: ParameterStore = ParameterStore(
            options.parameter_overrides, logger.error, self.call_soon
        )
        self._publishers: list[LocalPublisher] = []
        self._subscriptions: list[LocalSubscription] = []
        self._services: list[ServiceServer] = []
        self._clients: list[LocalClient[Any, Any]] = []
        # Ends of lifecycle nodes, by what they are; the others are this node's.
        self._owners: dict[Any, str] = {}
        self._nodes = [self.node_name]
        self._srv_types: dict[Any, Any] = {}
        self._taps: dict[Tap, None] = {}
        self._taken_over: list[str] = []
        self._closed = False
        self._standard = StandardOffers(self, self._bus, self._parameters, logger)
        self._standard.offer_parameters(self.node_name, "")
        if options.parameter_overrides:
            # When the constructors have declared their parameters.
            self.call_soon(lambda: self._parameters.name_undeclared(logger.warning))

    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile
    ) -> Publisher[MessageT]:
        """Create a publisher. Unless it is TRANSIENT_LOCAL, its depth has no effect.

        Within one process nothing is lost on the way: BEST_EFFORT delivers as RELIABLE
        does, and differs only in which subscriptions match.
        """
        name = self._check(topic)
        make = make_publisher if self._guard is None else self._guard.make_publisher
        publisher = self._bus.add_publisher(name, msg_type, as_profile(qos_profile, topic), make)
        self._publishers.append(publisher)
        self.new_ends.tell(lambda: self._topic_end(publisher, msg_type))
        return publisher

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: int | QoSProfile,
    ) -> Subscription[MessageT]:
        """Create a subscription that keeps as many messages as its profile says."""
        name, profile = self._check(topic), as_profile(qos_profile, topic)
        make = LocalSubscription if self._guard is None else self._guard.subscription_of(msg_type)
        subscription = make(name, callback, profile, self.call_soon)
        self._bus.add_subscription(subscription, msg_type)
        self._subscriptions.append(subscription)
        self.new_ends.tell(lambda: self._topic_end(subscription, msg_type))
        return subscription

    def destroy_publisher(self, publisher: Publisher[Any]) -> None:
        """Destroy a publisher."""
        self._note_outside("destroys a publisher")
        if publisher in self._publishers:
            self._publishers.remove(publisher)
            self._owners.pop(publisher, None)
            self._bus.remove_publisher(publisher)

    def destroy_subscription(self, subscription: Subscription[Any]) -> None:
        """Destroy a subscription."""
        self._note_outside("destroys a subscription")
        if subscription in self._subscriptions:
            self._subscriptions.remove(subscription)
            self._owners.pop(subscription, None)
            self._bus.remove_subscription(subscription)

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: ServiceCallback[RequestT, ResponseT],
    ) -> Service:
        """Create a service; in one process, each has a name of its own."""
        # Most programs have no service of their own.
        from rosbase.contracts.service_callback import check_service_type, service_answer
        from rosbase.contracts.service_server import ServiceServer
        from rosbase.local.isolation import isolated

        check_service_type(srv_type, srv_name)
        name = self._check(srv_name, "service")
        answer = isolated(service_answer(srv_type, name, callback), srv_type.Response)
        make = ServiceServer if self._guard is None else self._guard.server_of(srv_type)
        service = make(name, answer, self.executor, self._logger)
        self._bus.services.add_provider(name, type_name(srv_type), service)
        self._srv_types[service] = srv_type
        self._services.append(service)
        return service

    def create_client(
        self, srv_type: ServiceType[RequestT, ResponseT], srv_name: str
    ) -> Client[RequestT, ResponseT]:
        """Create a client of a service."""
        from rosbase.contracts.service_callback import check_service_type
        from rosbase.local.service_client import LocalClient

        check_service_type(srv_type, srv_name)
        name, services = self._check(srv_name, "service"), self._bus.services
        client = LocalClient(srv_type, name, self.executor, services)
        services.add_client(name, type_name(srv_type), client.changed)
        self._srv_types[client] = srv_type
        self._clients.append(client)
        return client

    def destroy_service(self, service: Service) -> None:
        """Destroy a service."""
        self._note_outside("destroys a service")
        if service in self._services:
            self._services.remove(service)
            self._owners.pop(service, None)
            self._srv_types.pop(service, None)
            self._bus.services.remove_provider(service.service_name, service)
            service.close()

    def destroy_client(self, client: Client[Any, Any]) -> None:
        """Destroy a client."""
        self._note_outside("destroys a client")
        if client in self._clients:
            self._clients.remove(client)
            self._owners.pop(client, None)
            self._srv_types.pop(client, None)
            self._bus.services.remove_client(client.service_name, client.changed)
            client.close()

    def declare_parameter(self, spec: ParameterSpec) -> Parameter[Any]:
        """Declare a parameter, with its override if there is one."""
        self._note_outside("declares a parameter")
        return super().declare_parameter(spec)

    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none if one is refused."""
        self._note_outside("sets parameters")
        return super().set_parameters(parameters)

    def parameter_names(self) -> list[str]:
        """Return the names of the parameters that belong to no lifecycle node."""
        return self._standard.parameters_of("").names()

    def open_node(self, name: str, *, is_lifecycle: bool) -> NodeConnection:
        """Open the connection of a node; a lifecycle node has standard services of its own."""
        if not is_lifecycle:
            return super().open_node(name, is_lifecycle=False)
        node = LocalNode(self, name, self._standard, self._owners.__setitem__)
        self._nodes.append(node.node_name)
        self._standard.offer_parameters(node.node_name, f"{name}.")
        return node

    def expose_lifecycle(self, node: ManagedNode) -> None:
        """Answer the standard services of a lifecycle node under the name of this one."""
        self._standard.offer_lifecycle(self.node_name, node)

    def take_over(self, topic: str, *, depth: int = 0) -> Callable[[Any], None]:
        """Publish a topic in place of the programs on the bus, until this backend is closed."""
        name = self._check(topic)
        self._taken_over.append(name)
        return self._bus.take_over(name, depth)

    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        """Hear every message of a topic on the bus, and what comes from links."""
        tap = Tap(self._check(topic), on_message, self._remove_tap, self._fail_tap)
        self._taps[tap] = None
        self._bus.add_tap(tap)
        return tap

    def kept_messages(self, topic: str) -> list[Any]:
        """Return what the TRANSIENT_LOCAL publishers of a topic on the bus keep."""
        return self._bus.kept_messages(self._check(topic))

    def graph(self) -> "Graph":
        """Return the ends of the nodes of this backend, without others on the bus."""
        from rosbase.local.graph import Ends, local_graph

        ends = Ends(
            list(self._publishers),
            list(self._subscriptions),
            list(self._services),
            list(self._clients),
        )
        return local_graph(
            list(self._nodes),
            ends,
            dict(self._owners),
            dict(self._srv_types),
            self._standard.nodes(),
            self._bus,
        )

    def close(self) -> None:
        """Destroy everything that was created."""
        self._closed = True
        self._standard.close()
        for tap in list(self._taps):
            tap.close()
        for name in self._taken_over:
            self._bus.give_back(name)
        for publisher in list(self._publishers):
            self.destroy_publisher(publisher)
        for subscription in list(self._subscriptions):
            self.destroy_subscription(subscription)
        for service in list(self._services):
            self.destroy_service(service)
        for client in list(self._clients):
            self.destroy_client(client)
        self.executor.close()

    def _note_outside(self, what: str) -> None:
        if self._guard is not None:
            self._guard.note_outside(what)

    def _make_guard(self) -> "Guard | None":
        conductor = conductor_of(self.clock)
        if conductor is None:
            return None
        from rosbase.local.guard import Guard

        return Guard(conductor, self.message_format)

    def _topic_end(self, end: LocalPublisher | LocalSubscription, msg_type: type) -> "TopicEnd":
        # A node that has it is known only later; listeners look for topics.
        from rosbase.contracts.graph import TopicEnd, type_name_of

        name = f"/{self.node_name}"
        return TopicEnd(name, end.topic, type_name_of(msg_type), msg_type, end.profile)

    def _remove_tap(self, tap: Tap) -> None:
        self._taps.pop(tap, None)
        self._bus.remove_tap(tap)

    def _fail_tap(self, tap: Tap, error: Exception) -> None:
        """Log the exception of a tap, and close it, when nobody publishes in this call."""
        self.call_soon(partial(self._end_tap, tap, f"{type(error).__name__}: {error}"))

    def _end_tap(self, tap: Tap, reason: str) -> None:
        self._logger.error(f"{tap.topic}: a tap has ended, because it raised {reason}")
        tap.close()

    def _check(self, name: str, kind: str = "topic") -> str:
        """Return the full name of a topic or a service."""
        if self._closed:
            raise BackendError("the backend is closed")
        return resolve_topic(name, self._options.node_name, kind)
