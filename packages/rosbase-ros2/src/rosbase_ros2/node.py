"""One node of ROS: its topics, parameters, lifecycle and log, and the thread that serves it."""

import copy
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, TypeVar

from rclpy.qos import QoSProfile

from rosbase import (
    BackendError,
    Client,
    Clock,
    Graph,
    ManagedNode,
    MessageFormat,
    Publisher,
    Sender,
    Service,
    ServiceCallback,
    ServiceType,
    Subscription,
    Tap,
    Timer,
    make_logger,
    name_undeclared,
    one_line,
    resolve_topic,
    timer_period_ns,
)
from rosbase.contracts.recorded_answers import found
from rosbase.contracts.stored_parameters import StoredParameters
from rosbase.entries.conductor import Conductor
from rosbase.entries.recorded_clock import RecordedClock
from rosbase.wire.values import name_of
from rosbase_ros2.clock import RosClock
from rosbase_ros2.courier import courier_of
from rosbase_ros2.deadline import Deadline
from rosbase_ros2.delivery import Retirement
from rosbase_ros2.formats import find_ros_type, ros_format
from rosbase_ros2.given import given_parameters, own_first
from rosbase_ros2.graph import ros_graph, topic_end
from rosbase_ros2.lifecycle_services import LifecycleServices
from rosbase_ros2.parameters import Overrides, RosParameters
from rosbase_ros2.process import Process
from rosbase_ros2.qos import queue_depth, to_profile
from rosbase_ros2.qos_overrides import QoSOverrides
from rosbase_ros2.questions import Questions
from rosbase_ros2.recorded_ends import RecordedPublisher, RecordedSubscription
from rosbase_ros2.recorded_lifecycle import RecordedLifecycleServices
from rosbase_ros2.recorded_parameters import RecordedParameters
from rosbase_ros2.refusals import Refusals
from rosbase_ros2.rosout import RosoutHandler
from rosbase_ros2.services import Services
from rosbase_ros2.shared_node import OwnGroup, SharedNode
from rosbase_ros2.sim_time import SimTimeWatch
from rosbase_ros2.spinner import Spinner
from rosbase_ros2.starting import is_enabled
from rosbase_ros2.timers import RosTimer, Timers
from rosbase_ros2.topics import RosPublisher, RosSubscription

__all__ = ["RosNode"]

MessageT = TypeVar("MessageT")
RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")


class RosNode(StoredParameters):
    """The connection of one node, which ROS sees under its name."""

    def set_up(
        self,
        process: Process,
        node: SharedNode,
        on_context_end: Callable[[], object],
        prefix: str = "",
    ) -> None:
        """Take over an rclpy node, and begin to serve it.

        Args:
            process: What it shares with other nodes.
            node: The rclpy node.
            on_context_end: Called on the thread of the node when its context ends first.
            prefix: Beginning of the names of parameters that are given to this node alone, such
                as `left.`.

        Raises:
            ParameterError: An override of a quality of service is invalid.
        """
        self._process = process
        process.nodes.append(node)
        for known in node.publishers:
            # Publishers of rclpy itself, such as the one for parameter events.
            process.taps.welcome(known)
        node.publisher_listener = self._welcome
        self.node = node
        """Node of rclpy, for everything else that a program needs: actions, services, tf2."""
        # It may have been given another one on the command line.
        self.node_name = node.get_fully_qualified_name().removeprefix("/")
        clock = RosClock(node)
        self.log_name = node.get_logger().name
        self._conductor = conductor = process.conductor
        self.clock = clock if conductor is None else self._recorded_clock(conductor, clock)
        self.has_console_log = is_enabled("stdout-logs", process.words)
        self.log_handler = self._rosout = RosoutHandler(
            node, process.log_file, is_published=is_enabled("rosout-logs", process.words)
        )
        self._logger = make_logger(
            self.log_name, None, self.clock, self.log_handler, has_console=self.has_console_log
        )
        self._refusals = Refusals(process.context, self._logger)
        self._values = own_first(process.options.parameter_overrides, prefix)
        self._given = own_first(given_parameters(node), prefix)
        # What a program is given is meant for its manager or one of its children.
        is_child = process.options.is_child
        self._warn = self._logger.debug if is_child else self._logger.warning
        self._overrides = QoSOverrides(self._given, self._warn)
        questions = Questions(process.executor.call_urgently, process.is_on_rclpy_thread)
        written = process.arguments.written_for(node.get_fully_qualified_name())
        overrides = Overrides(self._values, self._given, own_first(written, prefix))
        make_parameters = (
            RosParameters if conductor is None else self._recorded_parameters(conductor)
        )
        self._parameters: RosParameters = make_parameters(
            node,
            overrides,
            questions,
            self._refusals,
            self._logger.error,
            process.executor.call_soon,
        )
        self._publishers: list[RosPublisher] = []
        self._retirement = Retirement(node)
        self._subscriptions: list[RosSubscription] = []
        self._lifecycle_services: list[LifecycleServices] = []
        self._timers = Timers(clock, process.executor.call_soon, conductor)
        self._sim_time = SimTimeWatch(node, clock, process.executor, self._logger.warning)
        self._spinner = Spinner(process.context, node, self._report, on_context_end)
        process.spinners.append(self._spinner)
        self._services = Services(process, node, self._spinner, self._logger, self._refusals)

    @property
    def given_names(self) -> list[str]:
        """Names of the parameters that the node is given."""
        return [*self._given, *self._values]

    def name_undeclared(self, names: Iterable[str]) -> None:
        """Warn of parameters that are given and not declared."""
        declared = self.node.list_parameters([], 0).names
        name_undeclared(names, declared, self._warn)

    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: Any
    ) -> Publisher[MessageT]:
        """Create a publisher of rosbase messages, which are converted, or of native ROS ones.

        Args:
            msg_type: The class of the messages.
            topic: Name as in ROS: relative, absolute, or private with `~/`; remapping applies.
            qos_profile: The depth of a reliable, volatile topic, or a profile of rosbase or rclpy.
        """
        self._process.check_open()
        courier = courier_of(msg_type, self._process.conversions)
        profile = to_profile(qos_profile, topic)
        if self._conductor is not None:
            self._resolved(self._conductor, topic)
        inner = self._create("publisher", courier.ros_type, topic, profile)
        make: Callable[..., RosPublisher] = RosPublisher
        if self._conductor is not None:
            make = partial(RecordedPublisher, conductor=self._conductor)
        publisher = make(inner, courier, self._refusals)
        self._publishers.append(publisher)
        self._process.taps.add_publisher(publisher)
        return publisher

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: Any,
    ) -> Subscription[MessageT]:
        """Create a subscription; the callback runs on the main-loop thread."""
        self._process.check_open()
        courier = courier_of(msg_type, self._process.conversions)
        profile = to_profile(qos_profile, topic)
        make: Callable[..., RosSubscription] = RosSubscription
        if self._conductor is not None:
            name = self._resolved(self._conductor, topic)
            make = partial(RecordedSubscription, conductor=self._conductor, topic=name)
        subscription = make(
            courier, callback, queue_depth(profile), self._process.executor.call_soon, self._logger
        )
        deliver = subscription.deliver
        inner = self._create(
            "subscription", courier.ros_type, topic, profile, deliver, is_raw=courier.is_raw
        )
        subscription.attach(inner)
        self._subscriptions.append(subscription)
        self._process.taps.add_subscription(subscription)
        self._process.new_ends.tell(lambda: topic_end(self.node, inner, msg_type))
        return subscription

    def destroy_publisher(self, publisher: Publisher[Any]) -> None:
        """Destroy a publisher; ROS sees it until its last messages have arrived."""
        self._note_outside("destroys a publisher")
        if isinstance(publisher, RosPublisher) and publisher in self._publishers:
            self._publishers.remove(publisher)
            self._process.taps.remove_publisher(publisher)
            publisher.close()
            self._spinner.call(lambda: self._retirement.take(publisher.inner))

    def destroy_subscription(self, subscription: Subscription[Any]) -> None:
        """Destroy a subscription."""
        self._note_outside("destroys a subscription")
        if isinstance(subscription, RosSubscription) and subscription in self._subscriptions:
            self._subscriptions.remove(subscription)
            self._process.taps.remove_subscription(subscription)
            subscription.close()
            self._spinner.call(lambda: self.node.destroy_subscription(subscription.inner))

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: ServiceCallback[RequestT, ResponseT],
    ) -> Service:
        """Create a service of a type of rosbase or ROS; the callback runs on the main loop.

        A client that is not in this process gets no answer if it raises, because ROS has none
        for that; the log says why.
        """
        self._process.check_open()
        return self._services.create_service(srv_type, srv_name, callback)

    def create_client(
        self, srv_type: ServiceType[RequestT, ResponseT], srv_name: str
    ) -> Client[RequestT, ResponseT]:
        """Create a client of a service of a type of rosbase or ROS."""
        self._process.check_open()
        return self._services.create_client(srv_type, srv_name)

    def destroy_service(self, service: Service) -> None:
        """Destroy a service."""
        self._note_outside("destroys a service")
        self._services.destroy_service(service)

    def destroy_client(self, client: Client[Any, Any]) -> None:
        """Destroy a client."""
        self._note_outside("destroys a client")
        self._services.destroy_client(client)

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        """Create a timer of the main loop, which follows `/clock` while `use_sim_time` is true."""
        self._process.check_open()
        period_ns = timer_period_ns(period_s)
        return self._timers.add(self._process.executor.create_timer(period_ns, callback))

    def timer_now_ns(self) -> int:
        """Return the time of `/clock` while `use_sim_time` is true, else monotonic time."""
        if self._conductor is None:
            return self._timers.now_ns()
        now_ns: Any = self._conductor.fact(self._timers.now_ns)
        return int(now_ns)

    def destroy_timer(self, timer: Timer) -> None:
        """Destroy a timer."""
        if isinstance(timer, RosTimer):
            self._timers.remove(timer)

    def expose_lifecycle(self, node: ManagedNode) -> None:
        """Create the five services and the topic with which the ROS tools drive a managed node."""
        self._process.check_open()
        if self._lifecycle_services:
            self._logger.warning(
                f"{type(node).__name__} is not seen by the ROS tools: the services of"
                f" {self.node.get_name()} are those of its first lifecycle node"
            )
            return
        self._parameters.watch_transitions(node.describe_transition)
        # A program may ask for a transition of its own node, and wait.
        call_urgently = self._process.executor.call_urgently
        make: Callable[..., LifecycleServices] = LifecycleServices
        if self._conductor is not None:
            make = partial(RecordedLifecycleServices, conductor=self._conductor, clock=self.clock)
        self._lifecycle_services.append(make(self.node, node, call_urgently, self._logger))

    def prepared_sender(
        self, publisher: Publisher[MessageT], template: MessageT, varying: Sequence[str]
    ) -> Sender:
        """Return a sender of messages as bytes."""
        if isinstance(publisher, RosPublisher):
            return publisher.prepared_sender(template, varying)
        return super().prepared_sender(publisher, template, varying)

    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        """Hear what all nodes of the backend publish on a topic, as bytes or as a ROS message."""
        self._process.check_open()
        resolve_topic(topic, self.node_name)
        return self._process.taps.open(self.node.resolve_topic_name(topic), on_message)

    def kept_messages(self, topic: str) -> list[Any]:
        """Return what the TRANSIENT_LOCAL publishers of rosbase on a topic keep, as bytes."""
        self._process.check_open()
        resolve_topic(topic, self.node_name)
        return self._process.taps.kept_messages(self.node.resolve_topic_name(topic))

    def graph(self) -> Graph:
        """Return the ends of all nodes of the backend, as rclpy sees them."""
        return ros_graph(self._process.nodes, self._process.taps)

    def message_format(self, msg_type: Any) -> MessageFormat:
        """Return how the messages of a class of rosbase or ROS look outside this process."""
        return ros_format(msg_type, self._process.conversions)

    def find_type(self, type_name: str) -> Any:
        """Return the class of rosbase or ROS for a message or a service."""
        try:
            return super().find_type(type_name)
        except TypeError:
            return find_ros_type(type_name)

    def has_parameter(self, name: str) -> bool:
        """Return whether the node has declared a parameter, or takes one for every node."""
        return name in self._parameters.general_names or bool(self.node.has_parameter(name))

    # The end, step by step: `Ros2Backend.close` takes each with all nodes.

    def stop_sending(self) -> list[Any]:
        """Send nothing more; return the publishers of rclpy."""
        for publisher in self._publishers:
            self._process.taps.remove_publisher(publisher)
            publisher.close()
        self._publishers.clear()
        return list(self.node.publishers)

    def stop_receiving(self) -> None:
        """Refuse requests, and hand on nothing more."""
        self._overrides.name_unused()
        self._rosout.close()
        self._services.close()
        for services in self._lifecycle_services:
            services.close()
        for subscription in self._subscriptions:
            subscription.close()

    def begin_end(self) -> None:
        """Let the threads of the node end."""
        self._spinner.begin_end()

    def destroy(self, deadline: Deadline) -> bool:
        """Destroy the rclpy node; return whether that was possible: no callback hangs."""
        if not self._spinner.close(deadline):
            return False
        self._timers.close()
        self._sim_time.close()
        self.node.destroy_node()
        return True

    # Only while the program is recorded.

    def _recorded_clock(self, conductor: Conductor, clock: RosClock) -> Clock:
        """Note the names of the node, and return its clock, whose readings are noted."""
        found(conductor, lambda: [self.node_name, self.log_name])
        self.node.native_listener = lambda: conductor.spoil(
            f"the program uses the rclpy node {self.node_name} itself, which a replay lacks"
        )
        recorded: RecordedClock = conductor.clock  # type: ignore[assignment]  # of a recorder
        return recorded.beside(clock)

    def _recorded_parameters(self, conductor: Conductor) -> Callable[..., RosParameters]:
        urgently = self._process.executor.call_urgently
        return partial(
            RecordedParameters,
            conductor=conductor,
            now_ns=self.clock.now_ns,
            call_urgently=urgently,
        )

    def _resolved(self, conductor: Conductor, topic: str) -> str:
        """Note the full name of a topic, which may be remapped."""

        def resolve() -> str:
            resolve_topic(topic, self.node_name)
            return str(self.node.resolve_topic_name(topic))

        return found(conductor, resolve)

    def _note_outside(self, what: str) -> None:
        if self._conductor is not None and not self._conductor.is_inside:
            self._conductor.spoil(f"a thread of the program's own {what}")

    def _welcome(self, inner: Any) -> None:
        """Note a new publisher of rclpy, of rosbase or of the program."""
        self._process.taps.welcome(inner)
        self._process.new_ends.tell(lambda: topic_end(self.node, inner, inner.msg_type))

    def _create(
        self,
        end: str,
        ros_type: type,
        topic: str,
        profile: QoSProfile,
        *callback: Any,
        is_raw: bool = False,
    ) -> Any:
        """Create an end of a topic with rclpy; turn a refusal into an error of one line."""
        resolve_topic(topic, self.node_name)
        is_publisher = end == "publisher"
        create = self.node.create_publisher if is_publisher else self.node.create_subscription
        try:
            name = self.node.resolve_topic_name(topic)
            self._check_type(name, ros_type)
            options = self._overrides.options(name, end)
            raw: dict[str, Any] = {} if is_publisher else {"raw": is_raw}
            # rclpy changes the profile, which may be used for other topics too.
            profile = copy.copy(profile) if options else profile
            return create(
                *(ros_type, topic, *callback, profile),
                qos_overriding_options=options,
                callback_group=OwnGroup(),
                **raw,
            )
        except Exception as error:
            reason = one_line(str(error))
            if fault := self._refusals.explain(error):
                reason = f"{fault} ({reason})"
            raise BackendError(f"topic {topic!r}: {reason}") from error
        finally:
            if self._overrides.is_unused:
                # When whoever creates topics has created them all.
                self._process.executor.call_aside(self._overrides.name_near_misses)

    def _check_type(self, name: str, ros_type: type) -> None:
        # rmw would refuse it too, but rclpy says nothing then of topics and types.
        ends = (
            end
            for n in self._process.nodes
            for end in (*n.publishers, *n.entities("subscriptions"))
        )
        for end in ends:
            if end.topic_name == name and end.msg_type is not ros_type:
                known, new = name_of(end.msg_type), name_of(ros_type)
                raise TypeError(f"it carries {known}, so it cannot carry {new}")

    def _report(self, error: BaseException) -> None:
        self._logger.error(f"a callback of rclpy raised {type(error).__name__}: {error}")
