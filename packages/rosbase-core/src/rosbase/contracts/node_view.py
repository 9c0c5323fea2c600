"""A node that shares the connection of its manager."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from attrs import evolve

from rosbase.contracts.names import check_node_name, resolve_topic
from rosbase.contracts.node_connection import (
    NodeConnection,
    Publisher,
    Sender,
    Subscription,
    Timer,
)
from rosbase.contracts.parameter_store import OnSetParameters, PostSetParameters
from rosbase.contracts.services import Client, Service, ServiceCallback, ServiceType
from rosbase.contracts.tap import Tap
from rosbase.lifecycle import ManagedNode
from rosbase.parameters import Parameter, ParameterSpec, SetParametersResult
from rosbase.qos import QoSProfile

if TYPE_CHECKING:
    from rosbase.contracts.graph import Graph
    from rosbase.contracts.message_format import MessageFormat

__all__ = ["NodeView"]

MessageT = TypeVar("MessageT")
RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


class NodeView(NodeConnection):
    """The connection of one node among several: its parameters have its name in front."""

    def __init__(self, shared: NodeConnection, name: str, *, is_lifecycle: bool) -> None:
        """Take a part of a connection.

        Args:
            shared: The connection of the manager.
            name: The name of the node, in front of its parameters.
            is_lifecycle: Whether it is a node to other programs, with a name of its own.

        Raises:
            BackendError: ROS would refuse the name for a lifecycle node.
        """
        if is_lifecycle:
            check_node_name(name)
            namespace = shared.node_name.rpartition("/")[0]
            self.node_name = f"{namespace}/{name}".removeprefix("/")
            self.log_name = self.node_name.replace("/", ".")
        else:
            self.node_name = shared.node_name
            # Below the name of the manager's logger, as it says.
            self.log_name = None
        self.log_handler = shared.log_handler
        self.has_console_log = shared.has_console_log
        self.clock = shared.clock
        self._shared = shared
        self._prefix = f"{name}."
        self._is_lifecycle = is_lifecycle

    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile
    ) -> Publisher[MessageT]:
        """Create a publisher."""
        return self._shared.create_publisher(msg_type, self._own(topic), qos_profile)

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: int | QoSProfile,
    ) -> Subscription[MessageT]:
        """Create a subscription."""
        return self._shared.create_subscription(msg_type, self._own(topic), callback, qos_profile)

    def destroy_publisher(self, publisher: Publisher[Any]) -> None:
        """Destroy a publisher."""
        self._shared.destroy_publisher(publisher)

    def destroy_subscription(self, subscription: Subscription[Any]) -> None:
        """Destroy a subscription."""
        self._shared.destroy_subscription(subscription)

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: ServiceCallback[RequestT, ResponseT],
    ) -> Service:
        """Create a service."""
        return self._shared.create_service(srv_type, self._own(srv_name, "service"), callback)

    def create_client(
        self, srv_type: ServiceType[RequestT, ResponseT], srv_name: str
    ) -> Client[RequestT, ResponseT]:
        """Create a client."""
        return self._shared.create_client(srv_type, self._own(srv_name, "service"))

    def destroy_service(self, service: Service) -> None:
        """Destroy a service."""
        self._shared.destroy_service(service)

    def destroy_client(self, client: Client[Any, Any]) -> None:
        """Destroy a client."""
        self._shared.destroy_client(client)

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        """Create a timer."""
        return self._shared.create_timer(period_s, callback)

    def destroy_timer(self, timer: Timer) -> None:
        """Destroy a timer."""
        self._shared.destroy_timer(timer)

    def timer_now_ns(self) -> int:
        """Return the time that timers follow."""
        return self._shared.timer_now_ns()

    def declare_parameter(self, spec: ParameterSpec) -> Parameter[Any]:
        """Declare a parameter; others see it with the name of the node in front."""
        return self._inner(
            self._shared.declare_parameter(
                evolve(spec, name=self._prefix + spec.name, general_name=spec.name)
            )
        )

    def get_parameter(self, name: str) -> Parameter[Any]:
        """Return the parameter with its current value."""
        return self._inner(self._shared.get_parameter(self._prefix + name))

    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none."""
        outer = [Parameter(self._prefix + p.name, p.value) for p in parameters]
        return self._shared.set_parameters(outer)

    def parameter_names(self) -> list[str]:
        """Return the names of the node's parameters."""
        names = self._shared.parameter_names()
        return [n.removeprefix(self._prefix) for n in names if n.startswith(self._prefix)]

    def describe_parameter(self, name: str) -> ParameterSpec:
        """Return the declaration of a parameter."""
        return evolve(self._shared.describe_parameter(self._prefix + name), name=name)

    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        """Ask `callback` before parameters of this node are set."""

        def ask(parameters: list[Parameter[Any]]) -> Any:
            own = [self._inner(p) for p in parameters if p.name.startswith(self._prefix)]
            return callback(own) if own else SetParametersResult(successful=True)

        ask.__qualname__ = getattr(callback, "__qualname__", repr(callback))
        ask.prefix = self._prefix  # type: ignore[attr-defined]  # for `ParameterRules`
        self._shared.add_on_set_parameters_callback(ask)

    def add_post_set_parameters_callback(self, callback: PostSetParameters) -> None:
        """Call `callback` after parameters of this node were set."""

        def tell(parameters: list[Parameter[Any]]) -> None:
            if own := [self._inner(p) for p in parameters if p.name.startswith(self._prefix)]:
                callback(own)

        tell.prefix = self._prefix  # type: ignore[attr-defined]  # for `ParameterRules`
        self._shared.add_post_set_parameters_callback(tell)

    def expose_lifecycle(self, node: ManagedNode) -> None:
        """Let other programs see the lifecycle, as far as the backend can."""
        self._shared.expose_lifecycle(node)

    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        """Hear every message of a topic in this process."""
        return self._shared.add_tap(self._own(topic), on_message)

    def kept_messages(self, topic: str) -> list[Any]:
        """Return what the TRANSIENT_LOCAL publishers of a topic keep."""
        return self._shared.kept_messages(self._own(topic))

    def graph(self) -> "Graph":
        """Return the ends of all nodes of the shared connection."""
        return self._shared.graph()

    def message_format(self, msg_type: Any) -> "MessageFormat":
        """Return how the messages of a class look outside this process."""
        return self._shared.message_format(msg_type)

    def find_type(self, type_name: str) -> Any:
        """Return the class of a message or a service by its ROS name."""
        return self._shared.find_type(type_name)

    def prepared_sender(
        self, publisher: Publisher[MessageT], template: MessageT, varying: Sequence[str]
    ) -> Sender:
        """Create a sender of messages like the template."""
        return self._shared.prepared_sender(publisher, template, varying)

    def _inner(self, parameter: Parameter[Any]) -> Parameter[Any]:
        return Parameter(parameter.name.removeprefix(self._prefix), parameter.value)

    def _own(self, name: str, kind: str = "topic") -> str:
        """Return the name to ask the shared connection for: `~` and `{node}` are this node's."""
        return resolve_topic(name, self.node_name, kind) if self._is_lifecycle else name
