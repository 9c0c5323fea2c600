"""One node of a replayed program, as its middleware has shown it to others."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from rosbase.contracts.backend import timer_period_ns
from rosbase.contracts.graph import Graph, TopicEnd, type_name_of
from rosbase.contracts.message_format import MessageFormat
from rosbase.contracts.names import resolve_topic
from rosbase.contracts.node_connection import Publisher, Subscription, Timer
from rosbase.contracts.recorded_answers import change_state, found
from rosbase.contracts.service_callback import check_service_type
from rosbase.contracts.services import Client, Service, ServiceCallback, ServiceType
from rosbase.contracts.stored_parameters import StoredParameters
from rosbase.contracts.tap import Tap
from rosbase.entries.kinds import Numbered
from rosbase.entries.payloads import from_json
from rosbase.entries.script import Entry
from rosbase.errors import BackendError
from rosbase.lifecycle import ManagedNode, TransitionEvent
from rosbase.local.replayed.parameters import ReplayedParameters
from rosbase.local.replayed.services import ReplayedClient, ReplayedServer
from rosbase.local.replayed.topics import ReplayedPublisher, ReplayedSubscription
from rosbase.local.standard.lifecycle_answers import event_message
from rosbase.logger import make_logger
from rosbase.messages import lifecycle_msgs, rcl_interfaces
from rosbase.qos import QoSProfile
from rosbase.runtime.executor import ExecutorTimer
from rosbase.wire import writer

if TYPE_CHECKING:
    from rosbase.local.replayed.program import ReplayedProgram

__all__ = ["ReplayedNode"]

MessageT = TypeVar("MessageT")
RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")

_PARAMETER_EVENTS = "/parameter_events"


class ReplayedNode(StoredParameters):
    """The connection of one node. It asks for what was noted when its program was recorded."""

    def set_up(self, program: "ReplayedProgram", name: str) -> None:
        """Take the name that the node had.

        Args:
            program: What it shares with other nodes.
            name: Its name in the program.
        """
        self._program, conductor = program, program.conductor
        self.clock = conductor.clock
        names = found(conductor, lambda: [name, name.replace("/", ".")])
        self.node_name, self.log_name = map(str, names)
        self._logger = make_logger(self.log_name, None, self.clock)
        self._parameters: ReplayedParameters = ReplayedParameters(
            conductor,
            f"/{self.node_name}",
            self._logger.error,
            program.executor.call_soon,
            self._publish_parameters,
        )
        program.nodes[self.node_name] = self._parameters
        self._write_event: Callable[[Any], bytes] = writer(rcl_interfaces.ParameterEvent)
        self._has_lifecycle = False

    @property
    def node(self) -> Any:
        """The node of the middleware, which is not there.

        Raises:
            BackendError: The program uses it.
        """
        raise BackendError(
            f"the program uses the rclpy node {self.node_name} itself, which a replay lacks"
        )

    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile
    ) -> Publisher[MessageT]:
        """Create a publisher, which taps hear."""
        self._program.check_open()
        name, encode = self._resolve(topic), self._program.form(msg_type).encode
        publisher = ReplayedPublisher(
            self._program.conductor, name, msg_type, encode, self._program.taps
        )
        self._program.publishers.append(publisher)
        self._tell_of(name, msg_type)
        return publisher

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: int | QoSProfile,
    ) -> Subscription[MessageT]:
        """Create a subscription, which hears the recording."""
        self._program.check_open()
        conductor, schedule = self._program.conductor, self._program.executor.call_soon
        name, decode = self._resolve(topic), self._program.form(msg_type).decode
        subscription = ReplayedSubscription(
            conductor, name, callback, decode, schedule, self._logger
        )
        depth: Any = getattr(qos_profile, "queue_depth", qos_profile)
        subscription.resize(found(conductor, lambda: depth))
        self._program.subscriptions.append(subscription)
        self._tell_of(name, msg_type)
        return subscription

    def destroy_publisher(self, publisher: Publisher[Any]) -> None:
        """Destroy a publisher."""
        if isinstance(publisher, ReplayedPublisher):
            publisher.close()

    def destroy_subscription(self, subscription: Subscription[Any]) -> None:
        """Destroy a subscription."""
        if isinstance(subscription, ReplayedSubscription):
            subscription.close()

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: ServiceCallback[RequestT, ResponseT],
    ) -> Service:
        """Create a service."""
        program = self._program
        program.check_open()
        check_service_type(srv_type, srv_name)
        name = self._resolve(srv_name, "service")
        service = ReplayedServer(
            program.conductor,
            srv_type,
            name,
            callback,
            program.executor,
            self._logger,
            program.form,
        )
        program.services[name] = service
        return service

    def create_client(
        self, srv_type: ServiceType[RequestT, ResponseT], srv_name: str
    ) -> Client[RequestT, ResponseT]:
        """Create a client of a service."""
        program = self._program
        program.check_open()
        check_service_type(srv_type, srv_name)
        name = self._resolve(srv_name, "service")
        find_own = partial(program.services.get, name)
        client = ReplayedClient(srv_type, name, program.executor, find_own, program.form)
        program.clients.append(client)
        return client

    def destroy_service(self, service: Service) -> None:
        """Destroy a service."""
        if self._program.services.get(service.service_name) is service:
            self._program.services.pop(service.service_name).close()

    def destroy_client(self, client: Client[Any, Any]) -> None:
        """Destroy a client."""
        if isinstance(client, ReplayedClient):
            client.close()

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        """Create a timer."""
        self._program.check_open()
        return self._program.executor.create_timer(timer_period_ns(period_s), callback)

    def destroy_timer(self, timer: Timer) -> None:
        """Destroy a timer."""
        if isinstance(timer, ExecutorTimer):
            timer.destroy()

    def timer_now_ns(self) -> int:
        """Return the time that timers followed."""
        now_ns: Any = self._program.conductor.fact(self._program.machine.monotonic_ns)
        return int(now_ns)

    def expose_lifecycle(self, node: ManagedNode) -> None:
        """Take the transitions that others have asked for, and publish all."""
        self._program.check_open()
        if self._has_lifecycle:
            own = self.node_name.rpartition("/")[2]
            self._logger.warning(
                f"{type(node).__name__} is not seen by the ROS tools: the services of {own} are"
                " those of its first lifecycle node"
            )
            return
        self._has_lifecycle = True
        self._parameters.describe_transition = node.describe_transition
        topic = self._resolve("~/transition_event")
        conductor = self._program.conductor
        conductor.number(Numbered.SERVICE, topic, partial(self._change_state, node))
        self._tell_of(topic, lifecycle_msgs.TransitionEvent)
        write = writer(lifecycle_msgs.TransitionEvent)

        def publish(event: TransitionEvent) -> None:
            self._program.hear(topic, write(event_message(event, self.clock.now_ns())))

        node.add_transition_listener(publish)

    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        """Hear what is published on a topic, as bytes."""
        self._program.check_open()
        return self._program.add_tap(resolve_topic(topic, self.node_name), on_message)

    def kept_messages(self, topic: str) -> list[Any]:
        """Return nothing: a tap of a replay is older than any message."""
        return []

    def graph(self) -> Graph:
        """Return the publishers and subscriptions of the program."""
        program = self._program
        return Graph((f"/{self.node_name}",), tuple(program.ends))

    def message_format(self, msg_type: Any) -> MessageFormat:
        """Return how the messages of a class looked outside."""
        return self._program.form(msg_type)

    def _resolve(self, name: str, kind: str = "topic") -> str:
        """Return the full name that a topic or a service had, which others may have remapped."""
        conductor = self._program.conductor
        return str(found(conductor, lambda: resolve_topic(name, self.node_name, kind)))

    def _tell_of(self, topic: str, msg_type: Any) -> None:
        self._program.add_end(
            TopicEnd(f"/{self.node_name}", topic, type_name_of(msg_type), msg_type)
        )

    def _change_state(self, node: ManagedNode, entry: Entry) -> None:
        asked: Any = from_json(entry.payload)
        self._program.executor.call_urgently(
            lambda: change_state(node, asked["id"], asked["label"], self._logger)
        )

    def _publish_parameters(self, event: rcl_interfaces.ParameterEvent) -> None:
        self._program.hear(_PARAMETER_EVENTS, self._write_event(event))
