"""A lifecycle node of a manager: it shares the connection, and has services of its own name."""

from collections.abc import Callable
from typing import Any, TypeVar

from rosbase.contracts.node_connection import NodeConnection, Publisher, Subscription
from rosbase.contracts.node_view import NodeView
from rosbase.contracts.services import Client, Service, ServiceCallback, ServiceType
from rosbase.lifecycle import ManagedNode
from rosbase.local.standard.offers import StandardOffers
from rosbase.qos import QoSProfile

__all__ = ["LocalNode"]

MessageT = TypeVar("MessageT")
RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


class LocalNode(NodeView):
    """The connection of a lifecycle node."""

    def __init__(
        self,
        shared: NodeConnection,
        name: str,
        standard: StandardOffers,
        claim: Callable[[Any, str], object],
    ) -> None:
        """Share a connection.

        Args:
            shared: The manager's.
            name: The name of the node.
            standard: Answers the standard services of its nodes.
            claim: Notes that a publisher, subscription, service or client is a node's.
        """
        super().__init__(shared, name, is_lifecycle=True)
        self._standard = standard
        self._claim = claim

    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile
    ) -> Publisher[MessageT]:
        """Create a publisher."""
        publisher = super().create_publisher(msg_type, topic, qos_profile)
        self._claim(publisher, self.node_name)
        return publisher

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: int | QoSProfile,
    ) -> Subscription[MessageT]:
        """Create a subscription."""
        subscription = super().create_subscription(msg_type, topic, callback, qos_profile)
        self._claim(subscription, self.node_name)
        return subscription

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: ServiceCallback[RequestT, ResponseT],
    ) -> Service:
        """Create a service."""
        service = super().create_service(srv_type, srv_name, callback)
        self._claim(service, self.node_name)
        return service

    def create_client(
        self, srv_type: ServiceType[RequestT, ResponseT], srv_name: str
    ) -> Client[RequestT, ResponseT]:
        """Create a client of a service."""
        client = super().create_client(srv_type, srv_name)
        self._claim(client, self.node_name)
        return client

    def parameter_names(self) -> list[str]:
        """Return the names of the node's parameters."""
        return self._standard.parameters_of(self._prefix).names()

    def expose_lifecycle(self, node: ManagedNode) -> None:
        """Answer the standard services of a lifecycle node under the name of this one."""
        self._standard.offer_lifecycle(self.node_name, node)
