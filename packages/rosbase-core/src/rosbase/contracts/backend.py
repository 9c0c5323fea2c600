"""The backend contract: connects a manager or a standalone node to the outside world.

Must implement: `create_publisher`, `create_subscription`, `destroy_publisher`,
`destroy_subscription`, `declare_parameter`, `get_parameter`, `set_parameters`,
`add_on_set_parameters_callback`, `close`.

May implement, if the backend reaches beyond this process: `delivers_in_process`, `log_handler`,
`log_name`, `has_console_log`, `begin_run`, `end_run`, `expose_lifecycle`, `imu_sender`,
`create_timer`, `destroy_timer`.

May set, before the constructor returns: `node_name`, `clock`.

Never override, because the executor sets them: `executor`, `call_soon`, `spin_once`, `spin_until`,
`is_in_virtual_time`.

`rosbase.testing.backend_contract` checks all of this. Optional abilities of a backend are declared
there, not guessed.

Threads: one thread spins the executor, and every callback runs on it. The backend hands over data
from its own threads with `call_soon`. A backend may be called from any thread, except for spinning
and `close`. Those belong to one thread, and a callback must not call `close`. `call_soon` may be
called from a signal handler too.

Waiting: `publish` and `call_soon` never wait. Creating, destroying and declaring may wait for the
backend's own threads. `close` may also wait for messages on their way. None waits for more than
some seconds, whatever the other side does.

Names: ROS accepts the name of the node (`Backend.__init__` checks it).

Topics: names follow the rules of ROS (`rosbase.resolve_topic`). Every class of `rosbase.messages`
can be sent, and arrives equal to the message sent; a backend may support more types. Every
subscription of a topic hears every matching publisher, including those of the same backend and of
others in the same process. The two may take a while to find each other; only TRANSIENT_LOCAL
delivers messages published before. The messages of one publisher arrive in order. They also arrive
if the publisher is destroyed, or its backend closed, right after. Once the publisher has ended,
`publish` and the senders made of it send nothing. That is no error, because another thread may
have ended it.

Quality of service: a whole number means `QoSProfile(depth)`, as `rosbase.qos.as_profile` has it,
and a backend may accept its own profiles too. A backend keeps each policy as follows:

- depth, KEEP_LAST: the last `depth` messages wait for the callback; older ones are dropped and
  counted. KEEP_ALL: none is dropped.
- TRANSIENT_LOCAL: a publisher keeps its last `depth` messages, or all, as long as it lives. A
  subscription that asks for them gets them when it starts: in order, before later messages, none
  twice and none left out. VOLATILE: it gets messages published from then on.
- RELIABLE: a message is lost only if the queue is full. BEST_EFFORT: it may be lost on the way.
- A subscription gets nothing from a publisher that offers less than it asks for
  (`rosbase.qos.mismatch`), and a warning says so.

Error messages are one line that names the topic, the parameter or the value.
"""

import logging
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeVar

from attrs import field, frozen

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.imu_sender import ImuSender, message_sender
from rosbase.contracts.names import check_node_name
from rosbase.contracts.parameter_store import OnSetParameters
from rosbase.lifecycle import ManagedNode
from rosbase.messages import Imu
from rosbase.parameters import Parameter, ParameterSpec, ParameterValue, SetParametersResult
from rosbase.qos import QoSProfile
from rosbase.runtime.executor import Executor, ExecutorTimer

__all__ = ["Backend", "BackendOptions", "Publisher", "Subscription", "Timer", "timer_period_ns"]

MessageT = TypeVar("MessageT")


class Publisher(Protocol):
    """A publisher: sends messages to a topic."""

    @property
    def topic(self) -> str:
        """Full name of the topic, such as `/imu/data`."""
        ...

    def publish(self, message: Any) -> object:
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


class Subscription(Protocol):
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


@frozen
class BackendOptions:
    """Options for opening a backend."""

    node_name: str
    """Name of the node, as other programs see it."""
    parameter_overrides: Mapping[str, ParameterValue] = field(factory=dict)
    """Values that override the defaults of the parameters declared later."""
    clock: Clock = field(factory=SystemClock)
    """Clock for a backend that has none of its own."""
    is_child: bool = False
    """Whether a manager has started this process.

    If so, a node name on its command line is for the manager.
    """


class Backend(ABC):
    """A connection to the outside world, for one manager or one standalone node."""

    delivers_in_process = False
    """Whether messages reach this process's own subscriptions without leaving it.

    Listening costs next to nothing then.
    """

    def __init__(self, clock: Clock, node_name: str) -> None:
        """Start with an executor that nobody spins yet.

        Raises:
            BackendError: ROS would refuse the name for a node.
        """
        check_node_name(node_name)
        self.node_name = node_name
        """Name of the node as other programs see it, with its namespace in front if there is one.
        """
        self.clock = clock
        """Clock for stamps.

        Its date may come from the backend; its monotonic time is always that of
        `executor.clock`.
        """
        self.executor = Executor(clock)
        """Runs callbacks, on the thread that spins it. Deadlines are on `executor.clock`."""
        self.call_soon = self.executor.call_soon
        """Ask the spinning thread to call a function. Call it from any thread or signal handler."""
        self.spin_once = self.executor.spin_once
        """Handle one callback; return whether there was one.

        It waits for a callback up to the given number of seconds. Exceptions of the
        callback are raised here.
        """
        self.spin_until = self.executor.spin_until
        """Handle callbacks as they come, until a deadline on the monotonic clock."""
        self.is_in_virtual_time = not isinstance(clock, SystemClock)
        """Whether deadlines follow a test's clock instead of this machine's."""

    @abstractmethod
    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile
    ) -> Publisher:
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
    ) -> Subscription:
        """Create a subscription that asks for the given profile.

        Raises:
            BackendError: The topic has another type, the name or the profile is invalid, or the
                backend is closed.
        """

    @abstractmethod
    def destroy_publisher(self, publisher: Publisher) -> None:
        """Destroy a publisher of this backend; sent messages still arrive.

        Do nothing if it has ended.
        """

    @abstractmethod
    def destroy_subscription(self, subscription: Subscription) -> None:
        """Destroy a subscription: its callback is not called again. Do nothing if it has ended."""

    @abstractmethod
    def declare_parameter(self, spec: ParameterSpec) -> Parameter:
        """Declare a parameter, with its override if there is one, else its default.

        The value is of the spec's kind: 5 for a number is 5.0. A refused parameter stays
        undeclared.

        Raises:
            ParameterError: It is declared already, or the override is not a valid value.
        """

    @abstractmethod
    def get_parameter(self, name: str) -> Parameter:
        """Return the parameter with its current value.

        Values set from outside count, unless they are invalid.

        Raises:
            ParameterError: It has not been declared.
        """

    @abstractmethod
    def set_parameters(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        """Set all parameters, or none: one that is undeclared, read-only or wrong is refused.

        Each keeps its declared type. Call it on the spinning thread.
        """

    @abstractmethod
    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        """Ask `callback` on the spinning thread before parameters are set, from any source."""

    @abstractmethod
    def close(self) -> None:
        """Close everything that was created, and end every thread of the backend.

        Idempotent, and bounded in time. Published messages arrive, if the other side takes
        them within a moment. Afterwards no callback is called, and destroying is harmless.
        """

    # May implement.

    log_handler: logging.Handler | None = None
    """Handler for every record of the backend's manager or standalone node, beside the console.

    It is called from any thread. If the application has set up no logging, its level is the
    minimum for both. The message is one line of printable characters, with a traceback
    indented below it. The handler must never raise, even after `close`. Set it before the
    constructor returns.
    """

    log_name: str | None = None
    """Name of the logger of the backend's manager or standalone node, such as `robot.left`.

    None stands for the name of the role. Set it before the constructor returns.
    """

    has_console_log: bool = True
    """Whether records go to the console if the application has set up no logging.

    Set it before the constructor returns.
    """

    def begin_run(self, request_stop: Callable[[], object]) -> None:  # noqa: B027 - as below
        """Note that a manager or standalone node begins to spin.

        Args:
            request_stop: Ends the program in order, for a backend that can end it. Call it from
                any thread.
        """

    def end_run(self) -> None:  # noqa: B027 - as below
        """End whatever else keeps the program running on the same middleware.

        Called when a manager or standalone node ends: before its clean-up if it was
        stopped from outside the program, otherwise after `close`. Also called when a
        signal ends its constructor.
        """

    def expose_lifecycle(self, node: ManagedNode) -> None:  # noqa: B027 - nothing by default
        """Let other programs see and drive the lifecycle of a node of this backend.

        Called once for each node, when it is built and unconfigured. A backend that can
        show only one shows the first, and logs a warning for each of the others.
        """

    def imu_sender(self, publisher: Publisher, template: Imu) -> ImuSender:
        """Create a sender of samples that differ from `template` only in stamp and numbers.

        Override it in a backend that can send samples without building a message for each;
        the received messages are the same. The sender may be called from any thread, by
        one at a time.
        """
        return message_sender(publisher.publish, template)

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        """Create a timer with absolute deadlines; missed calls are skipped, not caught up.

        The first call is one period from now. Deadlines are on the monotonic clock, unless
        the backend has a time of its own that timers should follow, such as simulated
        time.

        Raises:
            ValueError: The period is not a positive, finite number of seconds.
            BackendError: The backend is closed.
        """
        return self.executor.create_timer(timer_period_ns(period_s), callback)

    def destroy_timer(self, timer: Timer) -> None:
        """Destroy a timer of this backend. Do nothing if it has ended."""
        if isinstance(timer, ExecutorTimer):
            timer.destroy()


def timer_period_ns(period_s: float) -> int:
    """Return the period of a timer in nanoseconds.

    Raises:
        ValueError: The period is not a positive, finite number of seconds.
    """
    if not (math.isfinite(period_s) and period_s > 0):
        raise ValueError(f"a timer's period is a positive number of seconds, not {period_s!r}")
    return max(1, int(period_s * 1e9))
