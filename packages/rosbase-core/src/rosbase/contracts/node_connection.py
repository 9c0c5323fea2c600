"""The connection of one node to the outside world: its name, topics, timers and parameters.

A backend is the connection of its manager's own node, or of a standalone node.
`Backend.open_node` opens one for every other node that the manager registers.
"""

import logging
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, TypeVar

from rosbase.clock import Clock
from rosbase.contracts.parameter_store import OnSetParameters, PostSetParameters
from rosbase.contracts.services import Client, Service, ServiceCallback, ServiceType
from rosbase.contracts.tap import Tap
from rosbase.errors import BackendError
from rosbase.lifecycle import ManagedNode
from rosbase.parameters import Parameter, ParameterSpec, SetParametersResult
from rosbase.qos import QoSProfile

if TYPE_CHECKING:
    from rosbase.contracts.graph import Graph
    from rosbase.contracts.message_format import MessageFormat

__all__ = ["NodeConnection", "Publisher", "Sender", "Subscription", "Timer"]

Sender: TypeAlias = Callable[..., object]
"""Function that publishes a message of the values of its varying fields, in their order.

It returns False if the backend did not take the message, as `Publisher.publish` does. It checks no
value: the caller has done so.
"""

MessageT = TypeVar("MessageT")
RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")
MessageT_co = TypeVar("MessageT_co", covariant=True)
MessageT_contra = TypeVar("MessageT_contra", contravariant=True)


class Publisher(Protocol[MessageT_contra]):
    """A publisher: sends messages to a topic."""

    @property
    def topic(self) -> str:
        """Full name of the topic, such as `/imu/data`."""
        ...

    def publish(self, message: MessageT_contra) -> object:
        """Hand the message to every subscription, without waiting for them.

        Call it from any thread.

        Nothing is sent once the publisher has ended.

        Returns:
            False if the backend did not take the message; the log says why. DDS, for example,
            refuses some dates of the machine. No exception is raised, because no program can fix
            it.

        Raises:
            TypeError: The message is not of the topic's type, or a field has a value of another.
            ValueError: A value does not fit into its field in the backend.
        """
        ...


class Subscription(Protocol[MessageT_co]):
    """A subscription: receives the messages of a topic."""

    @property
    def topic(self) -> str:
        """Full name of the topic."""
        ...

    @property
    def dropped(self) -> int:
        """Number of messages lost because the callback was slower than the publisher.

        Messages lost before they reached the backend are not counted.
        """
        ...


class Timer(Protocol):
    """A timer: calls a function periodically.

    Its methods have rclpy's names and work from any thread.
    """

    def cancel(self) -> None:
        """Stop the timer, until `reset`."""
        ...

    def reset(self) -> None:
        """Restart the timer: the next call is one period from now. Ignored once it is destroyed."""
        ...

    def is_canceled(self) -> bool:
        """Return whether the timer is stopped."""
        ...


class NodeConnection(ABC):
    """The connection of one node."""

    node_name: str
    """Name of the node as other programs see it, with its namespace in front if there is one."""
    clock: Clock
    """Clock for stamps. Its date may come from the backend."""

    log_handler: logging.Handler | None = None
    """Handler for every record of the node, beside the console.

    It is called from any thread. If the application has set up no logging, its level is the
    minimum for both. The message is one line of printable characters, with a traceback
    indented below it. The handler must never raise, even after `close`. Set it before the
    constructor returns.
    """

    log_name: str | None = None
    """Name of the node's logger, such as `robot.left`.

    None stands for the name of the manager or standalone node. Set it before the constructor
    returns.
    """

    has_console_log: bool = True
    """Whether records go to the console if the application has set up no logging.

    Set it before the constructor returns.
    """

    @abstractmethod
    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile
    ) -> Publisher[MessageT]:
        """Create a publisher that offers the given profile.

        Raises:
            BackendError: The topic has another type, the name or the profile is invalid, or the
                backend is closed.
        """

    @abstractmethod
    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: int | QoSProfile,
    ) -> Subscription[MessageT]:
        """Create a subscription that asks for the given profile.

        Raises:
            BackendError: The topic has another type, the name or the profile is invalid, or the
                backend is closed.
        """

    @abstractmethod
    def destroy_publisher(self, publisher: Publisher[Any]) -> None:
        """Destroy a publisher of this backend; sent messages still arrive.

        Do nothing if it has ended.
        """

    @abstractmethod
    def destroy_subscription(self, subscription: Subscription[Any]) -> None:
        """Destroy a subscription: its callback is not called again. Do nothing if it has ended."""

    @abstractmethod
    def declare_parameter(self, spec: ParameterSpec) -> Parameter[Any]:
        """Declare a parameter, with its override if there is one, else its default.

        The value is of the spec's kind: 5 for a number is 5.0. A refused parameter stays
        undeclared.

        Raises:
            ParameterError: It is declared already, or the override is not a valid value.
        """

    @abstractmethod
    def get_parameter(self, name: str) -> Parameter[Any]:
        """Return the parameter with its current value.

        Values set from outside count, unless they are invalid.

        Raises:
            ParameterError: It has not been declared.
        """

    @abstractmethod
    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none: one that is undeclared, read-only or wrong is refused.

        Each keeps its declared type. Call it on the spinning thread.
        """

    @abstractmethod
    def parameter_names(self) -> list[str]:
        """Return the names of the declared parameters, in the order of their declaration.

        Those of a lifecycle node belong to its own connection, and are not among its manager's.
        Call it from any thread.
        """

    @abstractmethod
    def describe_parameter(self, name: str) -> ParameterSpec:
        """Return the declaration of a parameter under that name. Call it from any thread.

        Its default is the one of the program, not the current value.

        Raises:
            ParameterError: It has not been declared.
        """

    @abstractmethod
    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        """Ask `callback` on the spinning thread before parameters are set, from any source."""

    @abstractmethod
    def add_post_set_parameters_callback(self, callback: PostSetParameters) -> None:
        """Call `callback` on the spinning thread after parameters were set, from any source."""

    @abstractmethod
    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        """Create a timer with absolute deadlines; missed calls are skipped, not caught up.

        The first call is one period from now. Deadlines are on the monotonic clock, unless
        the backend has a time of its own that timers should follow, such as simulated
        time.

        Raises:
            ValueError: The period is not a positive, finite number of seconds.
            BackendError: The backend is closed.
        """

    @abstractmethod
    def destroy_timer(self, timer: Timer) -> None:
        """Destroy a timer of this connection. Do nothing if it has ended."""

    @abstractmethod
    def timer_now_ns(self) -> int:
        """Return the time that timers follow, in nanoseconds."""

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: ServiceCallback[RequestT, ResponseT],
    ) -> Service:
        """Create a service: `callback` answers its requests, on the spinning thread.

        `service_answer` has the rules of the callback, and `ServiceServer` most of what a service
        needs: it hands each request to `executor.call_urgently`, so that it is answered even
        while that thread waits for an answer. An exception of the callback is logged, and the
        caller gets ServiceFailedError, if the backend can send it.

        Raises:
            BackendError: The service has another type, the name is invalid, or the backend is
                closed or has no services.
        """
        raise BackendError(f"{srv_name}: this backend has no services")

    def create_client(
        self, srv_type: ServiceType[RequestT, ResponseT], srv_name: str
    ) -> Client[RequestT, ResponseT]:
        """Create a client of a service. `ServiceClient` has most of what one needs.

        Raises:
            BackendError: The service has another type, the name is invalid, or the backend is
                closed or has no services.
        """
        raise BackendError(f"{srv_name}: this backend has no services")

    def destroy_service(self, service: Service) -> None:  # noqa: B027 - nothing by default
        """Destroy a service: requests that wait for it fail. Do nothing if it has ended."""

    def destroy_client(self, client: Client[Any, Any]) -> None:  # noqa: B027 - likewise
        """Destroy a client: its calls fail. Do nothing if it has ended."""

    def expose_lifecycle(self, node: ManagedNode) -> None:  # noqa: B027 - nothing by default
        """Let other programs see and drive the lifecycle of a node of this backend.

        Called once for each node, when it is built and unconfigured. A backend that can
        show only one shows the first, and logs a warning for each of the others.
        """

    def add_tap(self, topic: str, on_message: Callable[[Any], object]) -> Tap:
        """Hear every message of a topic in this process, until the tap is closed.

        `on_message(message)` is called for each message that this backend publishes on the topic,
        by prepared senders too, on the thread that publishes; and for each that arrives from
        outside this process for a subscription of this backend, once, however many subscriptions
        there are. The message is an object of the topic's class, or its CDR as bytes if the backend
        has these anyway. An object that can be changed may change after the call. The function must
        be quick, and must not publish. If it raises, the tap ends, and the log says so once; the
        message reaches everybody else.

        A tap hears messages from now on, also of publishers that come later, and none that was
        kept. A publisher without a tap has no cost. Call it from any thread.

        Raises:
            BackendError: The name is invalid, or the backend is closed or has no taps.
        """
        raise BackendError(f"{topic}: this backend has no taps")

    def kept_messages(self, topic: str) -> list[Any]:
        """Return what the TRANSIENT_LOCAL publishers of a topic keep, of each the oldest first.

        The messages are as those that a tap hears. Call it from any thread.

        Raises:
            BackendError: The name is invalid, or the backend is closed.
        """
        return []

    def graph(self) -> "Graph":
        """Return the publishers, subscriptions, services and clients of all nodes of the backend.

        Call it from any thread. An end that is created or destroyed meanwhile may be left out.

        Raises:
            BackendError: The backend does not know.
        """
        raise BackendError("this backend has no graph")

    def message_format(self, msg_type: Any) -> "MessageFormat":
        """Return how the messages of a class look outside this process.

        Raises:
            TypeError: They have no schema.
        """
        from rosbase.contracts.message_format import message_format

        return message_format(msg_type)

    def find_type(self, type_name: str) -> Any:
        """Return the class of a message or a service by its ROS name.

        Raises:
            TypeError: There is none.
        """
        from rosbase.contracts.message_format import find_type

        return find_type(type_name)

    def prepared_sender(
        self, publisher: Publisher[MessageT], template: MessageT, varying: Sequence[str]
    ) -> Sender:
        """Create a sender of messages that differ from `template` only in some numbers.

        Override it in a backend that can send messages without building an object for each;
        the received messages are the same. The sender may be called from any thread, by
        one at a time.

        Args:
            publisher: A publisher of this connection.
            template: All that does not vary.
            varying: Paths of the fields that vary, such as `header.stamp` or `orientation`; see
                `rosbase.wire.maker` for their values.

        Raises:
            TypeError: The template is no message (see `rosbase.message`).
            ValueError: A path leads to no numbers.
        """
        # Most programs prepare none, and need not import it.
        from rosbase.wire import maker

        make, publish = maker(template, varying), publisher.publish

        def send(*values: Any) -> object:
            return publish(make(*values))

        return send
