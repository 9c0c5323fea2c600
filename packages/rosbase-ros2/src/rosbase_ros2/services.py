"""The services and clients of one ROS node."""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias, TypeVar

from rclpy.exceptions import InvalidHandle
from rclpy.qos import QoSProfile

from rosbase import (
    BackendError,
    RosbaseLogger,
    ServiceCallback,
    ServiceType,
    check_service_type,
    resolve_topic,
    service_answer,
)
from rosbase.contracts.recorded_answers import found
from rosbase.wire.values import name_of
from rosbase_ros2.process import Process
from rosbase_ros2.recorded_ends import RecordedService
from rosbase_ros2.refusals import Refusals
from rosbase_ros2.service_client import RosClient
from rosbase_ros2.service_courier import ServiceCourier, service_courier
from rosbase_ros2.service_server import RosService
from rosbase_ros2.service_watch import ServiceWatch
from rosbase_ros2.shared_node import OwnGroup, SharedNode
from rosbase_ros2.spinner import Spinner

__all__ = ["Services"]

EndT = TypeVar("EndT")
RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")

# As many as a service lets wait; with the 10 of rclpy, DDS drops some of a burst.
_PROFILE = QoSProfile(depth=1000)

Key: TypeAlias = tuple[int, str, type]
"""Domain, full name and ROS type of a service."""

# All of this process. Of two backends with the same one, the first.
_served: dict[Key, RosService] = {}


class Services:
    """Creates the services and clients of a node, and destroys them. Any thread may use it."""

    def __init__(
        self,
        process: Process,
        node: SharedNode,
        spinner: Spinner,
        logger: RosbaseLogger,
        refusals: Refusals,
    ) -> None:
        """Prepare for an rclpy node, on which nothing is created yet.

        Args:
            process: What the node shares with others.
            node: The node.
            spinner: The thread that serves it.
            logger: The logger of the node.
            refusals: Says why the middleware refuses a request or an answer.
        """
        self._process = process
        self._node = node
        self._spinner = spinner
        self._logger = logger
        self._refusals = refusals
        self._domain = int(process.context.get_domain_id())
        self._watch = ServiceWatch(node, spinner)
        self._services: list[RosService] = []
        self._clients: list[RosClient[Any, Any]] = []

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: ServiceCallback[RequestT, ResponseT],
    ) -> RosService:
        """Create a service. Each of this process has a name of its own.

        Raises:
            BackendError: Its name or type is invalid, or there is one.
        """

        def create(name: str, courier: ServiceCourier) -> RosService:
            if any(name == known for known, _ in self._known("services")):
                raise ValueError("there is one in this process already")
            conductor = self._process.conductor
            make = (
                RosService if conductor is None else partial(RecordedService, conductor=conductor)
            )
            service = make(
                name,
                courier,
                service_answer(srv_type, name, callback),
                self._process.executor,
                self._logger,
            )
            self._node.create_service(
                courier.ros_type,
                srv_name,
                service.callback,
                qos_profile=_PROFILE,
                callback_group=service.group,
            )
            return service

        service = self._create(srv_type, srv_name, create)
        self._services.append(service)
        _served.setdefault(self._key(service), service)
        return service

    def create_client(
        self, srv_type: ServiceType[RequestT, ResponseT], srv_name: str
    ) -> RosClient[RequestT, ResponseT]:
        """Create a client of a service.

        Raises:
            BackendError: Its name or type is invalid.
        """

        def create(name: str, courier: ServiceCourier) -> RosClient[RequestT, ResponseT]:
            inner = self._node.create_client(
                courier.ros_type, srv_name, qos_profile=_PROFILE, callback_group=OwnGroup()
            )
            return RosClient(
                srv_type,
                inner,
                courier,
                self._process.executor,
                partial(self._find, (self._domain, name, courier.ros_type)),
                self._watch.begin,
                lambda: not self._process.is_on_rclpy_thread(),
                self._refusals,
            )

        client = self._create(srv_type, srv_name, create)
        self._clients.append(client)
        self._watch.add(client)
        return client

    def destroy_service(self, service: object) -> None:
        """Destroy a service: it answers no more. Do nothing if it is none of this node's."""
        if isinstance(service, RosService) and service in self._services:
            self._services.remove(service)
            self._end(service)
            self._spinner.call(lambda: self._node.destroy_service(service.inner))

    def destroy_client(self, client: object) -> None:
        """Destroy a client: its calls fail. Do nothing if it is none of this node's."""
        if isinstance(client, RosClient) and client in self._clients:
            self._clients.remove(client)
            self._watch.remove(client)
            client.close()
            self._spinner.call(lambda: self._node.destroy_client(client.inner))

    def close(self) -> None:
        """Let requests and calls fail; the ends are destroyed with the rclpy node."""
        for service in list(self._services):
            self._end(service)
        for client in list(self._clients):
            self._watch.remove(client)
            client.close()
        self._services.clear()
        self._clients.clear()

    def _key(self, service: RosService) -> Key:
        return self._domain, service.service_name, service.inner.srv_type

    def _end(self, service: RosService) -> None:
        key = self._key(service)
        if _served.get(key) is service:
            del _served[key]
        service.close()

    def _find(self, key: Key) -> RosService | None:
        return _served.get(key)

    def _create(
        self, srv_type: Any, srv_name: str, create: Callable[[str, ServiceCourier], EndT]
    ) -> EndT:
        """Create an end with rclpy; turn a refusal into an error of one line."""
        check_service_type(srv_type, srv_name)
        resolve_topic(srv_name, self._node.get_fully_qualified_name().removeprefix("/"), "service")
        try:
            name = self._resolve(srv_name)
            courier = service_courier(srv_type)
            self._check_type(name, courier.ros_type)
            return create(name, courier)
        except Exception as error:
            reason = f"service {srv_name!r}: {self._refusals.reason(error)}"
            raise BackendError(reason) from error

    def _resolve(self, srv_name: str) -> str:
        conductor = self._process.conductor
        if conductor is None:
            return str(self._node.resolve_service_name(srv_name))
        return found(conductor, lambda: str(self._node.resolve_service_name(srv_name)))

    def _check_type(self, name: str, ros_type: type) -> None:
        # In ROS, ends of different types do not find each other, and nobody says so.
        for known_name, known in (*self._known("services"), *self._known("clients")):
            if known_name == name and known is not ros_type:
                raise TypeError(f"it is a {name_of(known)}, so it cannot be a {name_of(ros_type)}")

    def _known(self, kind: str) -> list[tuple[str, type]]:
        """Return the names and types of all services or clients of this program."""
        found: list[tuple[str, type]] = []
        for node in self._process.nodes:
            for end in node.entities(kind):
                try:
                    found.append((end.service_name, end.srv_type))
                except InvalidHandle:
                    # Another thread has just destroyed it.
                    pass
        return found
