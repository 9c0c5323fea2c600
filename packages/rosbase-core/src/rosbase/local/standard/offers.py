"""The standard services that a backend offers for its nodes, and the topics of changes."""

import threading
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from rosbase.contracts.backend import Backend, Publisher
from rosbase.contracts.parameter_store import ParameterStore
from rosbase.contracts.service_server import ServiceRequest, ServiceServer
from rosbase.errors import ServiceFailedError
from rosbase.lifecycle import ManagedNode, TransitionEvent
from rosbase.local.bus import Bus
from rosbase.local.service_registry import type_name
from rosbase.local.standard.catalog import (
    LIFECYCLE,
    PARAMETER_EVENT,
    PARAMETERS,
    TRANSITION_EVENT,
    class_of,
)
from rosbase.local.standard.node_parameters import NodeParameters
from rosbase.logger import RosbaseLogger
from rosbase.parameters import Parameter

if TYPE_CHECKING:
    from rosbase.contracts.graph import TopicEnd
    from rosbase.local.standard.entrance import StandardEntrance

__all__ = ["StandardOffers"]

# As in rcl_lifecycle and rclpy.
_TRANSITION_DEPTH = 10
_PARAMETER_DEPTH = 1000
_PARAMETER_EVENTS = "/parameter_events"


class StandardOffers:
    """Standard services of the nodes of one backend.

    Until the first request comes, a node is an entry in a dict: whoever uses no standard service
    pays for no more. Modules are imported then too.
    """

    def __init__(
        self, backend: Backend, bus: Bus, store: ParameterStore, logger: RosbaseLogger
    ) -> None:
        """Offer nothing yet.

        Args:
            backend: The backend. The answers are made on the thread that spins it.
            bus: Where others find the services.
            store: The parameters of all nodes.
            logger: Logs requests that fail.
        """
        self._backend = backend
        self._bus = bus
        self._store = store
        self._logger = logger
        # By node: what its parameters in the store begin with, and its lifecycle.
        self._prefixes: dict[str, str] = {}
        self._lifecycles: dict[str, ManagedNode] = {}
        # What was asked for, by node and kind; guarded with _is_closed by the lock.
        self._made: dict[tuple[str, str], dict[str, ServiceServer]] = {}
        self._is_closed = False
        self._lock = threading.Lock()
        self._events: dict[str, Publisher[Any]] = {}
        self._entrance = self._make_entrance()
        bus.services.add_standard(self)
        store.add_listener(self._publish_parameters)

    def offer_parameters(self, node_name: str, prefix: str) -> None:
        """Answer for the parameters of a node, which have the prefix in the store."""
        node = f"/{node_name}"
        self._prefixes.setdefault(node, prefix)
        self._bus.services.standard_changed(node, PARAMETERS)

    def offer_lifecycle(self, node_name: str, managed: ManagedNode) -> None:
        """Answer for the lifecycle of a node, and publish its transitions."""
        node = f"/{node_name}"
        first = self._lifecycles.setdefault(node, managed)
        if first is not managed:
            self._logger.warning(
                f"{type(managed).__name__} has no services of its lifecycle: those of {node} are"
                f" of its first lifecycle node, {type(first).__name__}"
            )
            return
        managed.add_transition_listener(partial(self._publish, node))
        self._bus.services.standard_changed(node, LIFECYCLE)
        self._backend.new_ends.tell(partial(_transition_end, node))

    def parameters_of(self, prefix: str) -> NodeParameters:
        """Return the parameters of the node whose names in the store have the prefix."""
        return NodeParameters(self._store, prefix, self._prefixes.values())

    def has(self, node: str, kind: str) -> bool:
        """Return whether a node has services of that kind."""
        return node in (self._lifecycles if kind == LIFECYCLE else self._prefixes)

    def nodes(self) -> list[tuple[str, str]]:
        """Return the nodes with the kinds that they have."""
        return [
            *((node, PARAMETERS) for node in list(self._prefixes)),
            *((node, LIFECYCLE) for node in list(self._lifecycles)),
        ]

    def provider(self, node: str, kind: str, service: str) -> "_Offer":
        """Return whoever answers requests for a service."""
        return _Offer(self, node, kind, service)

    def take(self, node: str, kind: str, service: str, call: ServiceRequest) -> None:
        """Answer a request soon. Call it from any thread."""
        if self._entrance is None or self._entrance.is_inside:
            self._take(node, kind, service, call)
        else:
            self._entrance.let_in(node, kind, service, call)

    def _take(self, node: str, kind: str, service: str, call: ServiceRequest) -> None:
        with self._lock:
            if self._is_closed:
                found = None
            else:
                if (node, kind) not in self._made:
                    self._made[node, kind] = self._make(node, kind)
                found = self._made[node, kind][service]
        if found is None:
            call.set_exception(ServiceFailedError(f"{node}/{service}"))
        else:
            found.take(call)

    def close(self) -> None:
        """Answer no more requests: those that wait fail. Idempotent."""
        self._bus.services.remove_standard(self)
        with self._lock:
            self._is_closed = True
            made, self._made = self._made, {}
        for services in made.values():
            for service in services.values():
                service.close()

    def _make_entrance(self) -> "StandardEntrance | None":
        conductor = self._backend.conductor
        if conductor is None:
            return None
        from rosbase.local.standard.entrance import StandardEntrance

        return StandardEntrance(conductor, self._take)

    def _make(self, node: str, kind: str) -> dict[str, ServiceServer]:
        from rosbase.local.standard.node_services import make_services

        if kind == LIFECYCLE:
            from rosbase.local.standard.lifecycle_answers import lifecycle_answers

            refuse = partial(self._warn_of_refusal, node)
            answers = lifecycle_answers(self._lifecycles[node], refuse)
        else:
            from rosbase.local.standard.parameter_answers import parameter_answers

            answers = parameter_answers(self.parameters_of(self._prefixes[node]))
        return make_services(node, answers, self._backend.executor, self._logger)

    def _warn_of_refusal(self, node: str, line: str) -> None:
        self._logger.warning(f"{node}/{line}")

    def _publish(self, node: str, event: TransitionEvent) -> None:
        """Publish a step of a node if anybody listens. Called on the thread that takes it."""
        topic = f"{node}/transition_event"
        heard = self._heard_type(topic, TRANSITION_EVENT)
        if heard is None:
            return
        from rosbase.local.standard.lifecycle_answers import event_message

        message = event_message(event, self._backend.clock.now_ns())
        self._publisher(heard, topic, _TRANSITION_DEPTH).publish(message)

    def _publish_parameters(self, changed: Sequence[Parameter[Any]], *, are_new: bool) -> None:
        """Publish changes if anybody listens. Called on the thread that makes them."""
        heard = self._heard_type(_PARAMETER_EVENTS, PARAMETER_EVENT)
        if heard is None:
            return
        from rosbase.local.standard.parameter_events import parameter_events

        names = [parameter.name for parameter in changed]
        stamp = self._backend.clock.now()
        publisher = self._publisher(heard, _PARAMETER_EVENTS, _PARAMETER_DEPTH)
        for event in parameter_events(self._store, self._prefixes, names, stamp, are_new=are_new):
            publisher.publish(event)

    def _heard_type(self, topic: str, kind: str) -> type | None:
        """Return the class of a topic if it has subscriptions of that type, or a tap."""
        heard = self._find_heard(topic, kind)
        conductor = self._backend.conductor
        if conductor is None:
            return heard
        # In a replay, nobody listens who does not belong to the program.
        is_heard = conductor.fact(lambda: heard is not None)
        return heard or class_of(kind) if is_heard else None

    def _find_heard(self, topic: str, kind: str) -> type | None:
        if self._is_closed:
            return None
        heard = self._bus.heard_type(topic)
        if heard is None and self._bus.is_tapped(topic):
            heard = class_of(kind)
        return heard if heard is not None and type_name(heard) == kind else None

    def _publisher(self, heard: type, topic: str, depth: int) -> Publisher[Any]:
        if topic not in self._events:
            self._events[topic] = self._backend.create_publisher(heard, topic, depth)
        return self._events[topic]


def _transition_end(node: str) -> "TopicEnd":
    from rosbase.local.graph import transition_end

    return transition_end(node)


class _Offer:
    """One of the services."""

    def __init__(self, offers: StandardOffers, node: str, kind: str, service: str) -> None:
        self._take = partial(offers.take, node, kind, service)

    def take(self, call: ServiceRequest) -> None:
        """Answer the request soon."""
        self._take(call)
