"""The `ros2` backend: its own rclpy node, handled on the main-loop thread."""

import copy
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import rclpy
from rclpy.qos import QoSProfile

from rosbase import (
    Backend,
    BackendError,
    BackendOptions,
    ImuSender,
    ManagedNode,
    OnSetParameters,
    Parameter,
    ParameterError,
    ParameterSpec,
    Publisher,
    SetParametersResult,
    Subscription,
    SystemClock,
    Timer,
    installed_plugins,
    make_logger,
    name_undeclared,
    one_line,
    resolve_topic,
    timer_period_ns,
)
from rosbase.messages import Imu
from rosbase_ros2.clock import RosClock
from rosbase_ros2.conversion import Accept, Conversions, Converter
from rosbase_ros2.delivery import Retirement, await_delivery
from rosbase_ros2.given import given_parameters, name_strange_files
from rosbase_ros2.host import Host
from rosbase_ros2.kinds import name_of
from rosbase_ros2.lifecycle_services import LifecycleServices
from rosbase_ros2.log_file import LogFile
from rosbase_ros2.parameters import Overrides, RosParameters
from rosbase_ros2.qos import queue_depth, to_profile
from rosbase_ros2.qos_overrides import PREFIX, QoSOverrides
from rosbase_ros2.questions import Questions
from rosbase_ros2.refusals import Refusals
from rosbase_ros2.rosout import RosoutHandler
from rosbase_ros2.sim_time import SimTimeWatch
from rosbase_ros2.spinner import Spinner
from rosbase_ros2.starting import is_enabled, prepare_machine, ros_arguments, start_node
from rosbase_ros2.timers import RosTimer, Timers
from rosbase_ros2.topics import RosPublisher, RosSubscription
from rosbase_ros2.written import RosArguments

__all__ = ["Ros2Backend"]

MessageT = TypeVar("MessageT")

# How long the last messages may take to arrive, of all publishers together.
_LAST_MESSAGES_S = 0.5


class Ros2Backend(Backend):
    """A connection to ROS 2: one rclpy context, one node, one thread that receives messages."""

    def __init__(self, options: BackendOptions) -> None:
        """Start a node, with the arguments after `--ros-args` on the command line.

        Raises:
            BackendError: ROS refuses the arguments or the name, or cannot start on this machine.
            ParameterError: An override of a quality of service is invalid.
        """
        super().__init__(SystemClock(), options.node_name)
        self._context = rclpy.Context()
        warning, words = prepare_machine(), ros_arguments(sys.argv)
        arguments = RosArguments(words)
        self.node = start_node(self._context, options, arguments)
        """Node of rclpy, for everything else that a program needs: actions, services, tf2."""
        # It may have been given another one on the command line.
        self.node_name = self.node.get_fully_qualified_name().removeprefix("/")
        self.clock = clock = RosClock(self.node)
        self.log_name = self.node.get_logger().name
        self.has_console_log = is_enabled("stdout-logs", words)
        log_file = LogFile.of_this_process() if is_enabled("external-lib-logs", words) else None
        self.log_handler = self._rosout = RosoutHandler(self.node, log_file)
        self._logger = make_logger(
            self.log_name, None, clock, self.log_handler, has_console=self.has_console_log
        )
        if warning:
            self._logger.warning(warning)
        self._refusals = Refusals(self._context, self._logger)
        given = given_parameters(self.node)
        self._overrides = self._read_given(options, arguments, given)
        self._timers = Timers(clock, self.call_soon)
        self._sim_time = SimTimeWatch(self.node, clock, self.executor, self._logger.warning)
        questions = Questions(self.call_soon, self._is_on_spinner)
        written = arguments.written_for(self.node.get_fully_qualified_name())
        overrides = Overrides(options.parameter_overrides, given, written)
        self._parameters = RosParameters(
            self.node, overrides, questions, self._refusals, self._logger.error
        )
        self._conversions = Conversions(_ask_plugins)
        self._publishers: list[RosPublisher] = []
        self._retirement = Retirement(self.node)
        self._subscriptions: list[RosSubscription] = []
        self._services: list[LifecycleServices] = []
        self._closed = False
        self._host = Host(self._logger.info)
        self._spinner = Spinner(
            self._context,
            self.node,
            self._report,
            lambda: self._host.shut_down("the context of the node has been shut down"),
        )

    def create_publisher(self, msg_type: type[MessageT], topic: str, qos_profile: Any) -> Publisher:
        """Create a publisher of rosbase messages, which are converted, or of native ROS ones.

        Args:
            msg_type: The class of the messages.
            topic: Name as in ROS: relative, absolute, or private with `~/`; remapping applies.
            qos_profile: The depth of a reliable, volatile topic, or a profile of rosbase or rclpy.
        """
        self._check_open()
        converter, profile = self._conversions.of(msg_type), to_profile(qos_profile, topic)
        inner = self._create("publisher", converter.ros_type, topic, profile)
        publisher = RosPublisher(inner, converter, self._refusals)
        self._publishers.append(publisher)
        return publisher

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: Any,
    ) -> Subscription:
        """Create a subscription; the callback runs on the main-loop thread."""
        self._check_open()
        converter, profile = self._conversions.of(msg_type), to_profile(qos_profile, topic)
        subscription = RosSubscription(converter, callback, queue_depth(profile), self.call_soon)
        subscription.attach(
            self._create("subscription", converter.ros_type, topic, profile, subscription.deliver)
        )
        self._subscriptions.append(subscription)
        return subscription

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        """Create a timer of the main loop, which follows `/clock` while `use_sim_time` is true."""
        self._check_open()
        return self._timers.add(self.executor.create_timer(timer_period_ns(period_s), callback))

    def destroy_timer(self, timer: Timer) -> None:
        """Destroy a timer."""
        if isinstance(timer, RosTimer):
            self._timers.remove(timer)

    def destroy_publisher(self, publisher: Publisher) -> None:
        """Destroy a publisher; ROS sees it until its last messages have arrived."""
        if isinstance(publisher, RosPublisher) and publisher in self._publishers:
            self._publishers.remove(publisher)
            publisher.close()
            self._spinner.call(lambda: self._retirement.take(publisher.inner))

    def destroy_subscription(self, subscription: Subscription) -> None:
        """Destroy a subscription."""
        if isinstance(subscription, RosSubscription) and subscription in self._subscriptions:
            self._subscriptions.remove(subscription)
            subscription.close()
            self._spinner.call(lambda: self.node.destroy_subscription(subscription.inner))

    def declare_parameter(self, spec: ParameterSpec) -> Parameter:
        """Declare a parameter of the node."""
        return self._parameters.declare(spec)

    def get_parameter(self, name: str) -> Parameter:
        """Return the parameter with its current value, also if it was set from outside."""
        return self._parameters.get(name)

    def set_parameters(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        """Set parameters of the node, or none of them if one is refused."""
        return self._parameters.set(parameters)

    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        """Ask `callback` on the main loop before parameters are set, from any source."""
        self._parameters.add_callback(callback)

    def begin_run(self, request_stop: Callable[[], object]) -> None:
        """End the run when the program shuts rclpy down, in any way."""
        if self._host.begin_run(request_stop):
            self._spinner.look_now_and_then(self._host.look)
        if not self._context.ok():
            request_stop()

    def end_run(self) -> None:
        """Shut rclpy down, if the program has initialised it: `rclpy.ok()` is false from now on."""
        self._host.end_run()

    def expose_lifecycle(self, node: ManagedNode) -> None:
        """Create the five services and the topic with which the ROS tools drive a managed node."""
        self._check_open()
        if self._services:
            self._logger.warning(
                f"{type(node).__name__} is not seen by the ROS tools: the services of"
                f" {self.node.get_name()} are those of its first lifecycle node"
            )
            return
        self._services.append(LifecycleServices(self.node, node, self.call_soon, self._logger))

    def imu_sender(self, publisher: Publisher, template: Imu) -> ImuSender:
        """Return a sender of samples as bytes."""
        if isinstance(publisher, RosPublisher):
            return publisher.imu_sender(template)
        return super().imu_sender(publisher, template)

    def close(self) -> None:
        """Close everything, in bounded time; published messages are delivered first."""
        if self._closed:
            return
        self._closed = True
        for publisher in self._publishers:
            publisher.close()
        self._publishers.clear()
        if self._context.ok():
            await_delivery(list(self.node.publishers), _LAST_MESSAGES_S, self.executor.clock)
        self._overrides.name_unused()
        self._rosout.close()
        for services in self._services:
            services.close()
        for subscription in self._subscriptions:
            subscription.close()
        if self._spinner.close():
            self._timers.close()
            self._sim_time.close()
            self.node.destroy_node()
        self._context.try_shutdown()
        self.executor.close()

    def _create(
        self, end: str, ros_type: type, topic: str, profile: QoSProfile, *callback: Any
    ) -> Any:
        """Create an end of a topic with rclpy; turn a refusal into an error of one line."""
        resolve_topic(topic, self.node_name)
        is_publisher = end == "publisher"
        create = self.node.create_publisher if is_publisher else self.node.create_subscription
        try:
            name = self.node.resolve_topic_name(topic)
            self._check_type(name, ros_type)
            options = self._overrides.options(name, end)
            # rclpy changes the profile, which may be used for other topics too.
            profile = copy.copy(profile) if options else profile
            return create(ros_type, topic, *callback, profile, qos_overriding_options=options)
        except Exception as error:
            reason = one_line(str(error))
            if fault := self._refusals.explain(error):
                reason = f"{fault} ({reason})"
            raise BackendError(f"topic {topic!r}: {reason}") from error
        finally:
            if self._overrides.is_unused:
                # When whoever creates topics has created them all.
                self.call_soon(self._overrides.name_near_misses)

    def _read_given(
        self, options: BackendOptions, arguments: RosArguments, given: Mapping[str, Any]
    ) -> QoSOverrides:
        """Read the node's parameters from outside, and name those without a meaning here."""
        # What a program is given is meant for its manager or one of its children.
        warn = self._logger.debug if options.is_child else self._logger.warning
        try:
            overrides = QoSOverrides(given, warn)
        except ParameterError:
            self.node.destroy_node()
            self._context.try_shutdown()
            raise
        name_strange_files(arguments.files, given, f"/{self.node_name}", warn)
        names = [n for n in (*given, *options.parameter_overrides) if not n.startswith(PREFIX)]
        if names:
            # When the constructors have declared their parameters.
            self.call_soon(lambda: self._name_undeclared(names, warn))
        return overrides

    def _name_undeclared(self, names: Iterable[str], warn: Callable[[str], object]) -> None:
        declared = self.node.list_parameters([], 0).names
        missing = [name for name in names if not self.node.has_parameter(name)]
        name_undeclared(missing, declared, warn)

    def _check_type(self, name: str, ros_type: type) -> None:
        # rmw would refuse it too, but rclpy says nothing then of topics and types.
        for end in (*self.node.publishers, *self.node.subscriptions):
            if end.topic_name == name and end.msg_type is not ros_type:
                known, new = name_of(end.msg_type), name_of(ros_type)
                raise TypeError(f"it carries {known}, so it cannot carry {new}")

    def _check_open(self) -> None:
        if self._closed:
            raise BackendError("the backend is closed")

    def _is_on_spinner(self) -> bool:
        return self._spinner.is_current_thread

    def _report(self, error: BaseException) -> None:
        self._logger.error(f"a callback of rclpy raised {type(error).__name__}: {error}")


def _ask_plugins(msg_type: type, accept: Accept) -> Converter | None:
    return installed_plugins().create_conversion(msg_type, "ros2", accept)
