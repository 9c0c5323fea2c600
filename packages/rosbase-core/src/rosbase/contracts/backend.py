"""The backend contract: what connects a manager or a lone node to the world.

Must implement: `create_publisher`, `create_subscription`, `destroy_publisher`,
`destroy_subscription`, `declare_parameter`, `get_parameter`, `set_parameters`,
`add_on_set_parameters_callback`, `close`.

May implement, where the world has more to it than this process: `delivers_in_process`,
`log_handler`, `log_name`, `has_console_log`, `begin_run`, `end_run`, `expose_lifecycle`,
`imu_sender`, `create_timer`, `destroy_timer`.

May set, before the constructor returns: `node_name`, `clock`.

Never override, because it is the executor's: `executor`, `call_soon`, `spin_once`, `spin_until`,
`is_in_virtual_time`.

`rosbase.testing.backend_contract` checks all of this. What a backend can do that not every one can
is declared there, not guessed.

Threads: one thread spins the executor, and every callback runs on it. What arrives on threads
of the backend's own is handed over with `call_soon`. Whoever has a backend may call it from any
thread, but for spinning and `close`: those are for one thread, and `close` is not for callbacks.
`call_soon` may be called from a signal handler too.

Waiting: `publish` and `call_soon` wait for nobody. Creating, destroying and declaring may wait for
the backend's own threads, `close` for what is on its way as well: none for more than some seconds,
whatever the world does.

Names: that of the node is one that ROS takes (`Backend.__init__` checks it).

Topics: names are those of ROS (`rosbase.resolve_topic`). Every class of `rosbase.messages` can be
sent, and arrives equal to what was sent; what else can be is the backend's to say. Every
subscription of a topic hears every publisher of it that matches, those of the same backend and of
others in the same process included. The two may take a while to find each other: what is published
before is for TRANSIENT_LOCAL alone. What one publisher sends arrives in order, and also when it is
destroyed, or its backend closed, right after; once it has ended, `publish` and the senders made of
it send nothing, and that is no error, because another thread may have ended it.

Quality of service: a whole number means `QoSProfile(depth)`, as `rosbase.qos.as_profile` has it,
and a backend may take profiles of its world's own too. Of each policy a backend keeps this:

- depth, KEEP_LAST: the last so many messages wait for the callback; older ones are dropped and
  counted. KEEP_ALL: none is dropped.
- TRANSIENT_LOCAL: a publisher keeps its last `depth` messages, or all, as long as it lives. A
  subscription that asks for them gets them when it comes: in order, before what is published
  later, none twice and none left out. VOLATILE: it gets what is published from then on.
- RELIABLE: a message is lost to the depth alone. BEST_EFFORT: it may be lost on the way.
- A subscription gets nothing from a publisher that offers less than it asks for
  (`rosbase.qos.mismatch`), and a warning says so.

Errors are one line, which names the topic, the parameter or the value.
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
    """Sends messages to a topic."""

    @property
    def topic(self) -> str:
        """The full name of the topic, such as `/imu/data`."""
        ...

    def publish(self, message: Any) -> object:
        """Hand the message to every subscription. From any thread; does not wait for them.

        Nothing is sent once the publisher has ended.

        Returns:
            False if the world did not take the message, as DDS does not at some dates of the
            machine; the log says why. That is no exception, because no program can mend it.

        Raises:
            TypeError: The message is not of the topic's type, or a field has a value of another.
            ValueError: A value does not fit into its field in the backend's world.
        """
        ...


class Subscription(Protocol):
    """Receives the messages of a topic."""

    @property
    def topic(self) -> str:
        """The full name of the topic."""
        ...

    @property
    def dropped(self) -> int:
        """How many messages were lost because the callback was slower than the publisher.

        What the world lost before the backend had it is not counted.
        """
        ...


class Timer(Protocol):
    """Calls back again and again. The names are those of rclpy's timer. From any thread."""

    def cancel(self) -> None:
        """Stops it, until `reset`."""
        ...

    def reset(self) -> None:
        """Starts it again: the next call is one period from now. Not once it is destroyed."""
        ...

    def is_canceled(self) -> bool:
        """Whether it is stopped."""
        ...


@frozen
class BackendOptions:
    """What a backend is opened with."""

    node_name: str
    """The name under which the world sees it."""
    parameter_overrides: Mapping[str, ParameterValue] = field(factory=dict)
    """Values that win over the defaults of the parameters declared later."""
    clock: Clock = field(factory=SystemClock)
    """Where the time comes from, where the backend has no clock of its own."""
    is_child: bool = False
    """Whether a manager has started this process. What its command line says of the name of the
    node is meant for the manager then."""


class Backend(ABC):
    """A connection to the world, for one manager or one lone node."""

    delivers_in_process = False
    """Whether messages get to this process's own subscriptions without leaving it, so that
    listening costs next to nothing."""

    def __init__(self, clock: Clock, node_name: str) -> None:
        """Starts with an executor that nobody spins yet.

        Raises:
            BackendError: The name is none that ROS would take for a node.
        """
        check_node_name(node_name)
        self.node_name = node_name
        """The name under which the world sees it, its namespace in front if there is one."""
        self.clock = clock
        """The clock for stamps. Its date is the world's, where the world has one of its own; its
        monotonic time is always that of `executor.clock`."""
        self.executor = Executor(clock)
        """What runs callbacks, on the thread that spins it. Deadlines are on `executor.clock`."""
        self.call_soon = self.executor.call_soon
        """Has the spinning thread call a function. From any thread, and from signal handlers."""
        self.spin_once = self.executor.spin_once
        """Handles one callback, waiting for one so many seconds; tells whether there was one.
        What it raises is raised here."""
        self.spin_until = self.executor.spin_until
        """Handles callbacks as they come, until a deadline on the monotonic clock."""
        self.is_in_virtual_time = not isinstance(clock, SystemClock)
        """Whether deadlines are those of a test's clock, not of this machine's."""

    @abstractmethod
    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile
    ) -> Publisher:
        """A publisher that offers what the profile says.

        Raises:
            BackendError: The topic has another type, the name is not one, the profile is none,
                or the backend is closed.
        """

    @abstractmethod
    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: int | QoSProfile,
    ) -> Subscription:
        """A subscription that asks for what the profile says.

        Raises:
            BackendError: The topic has another type, the name is not one, the profile is none,
                or the backend is closed.
        """

    @abstractmethod
    def destroy_publisher(self, publisher: Publisher) -> None:
        """Ends a publisher of this backend: what it sent arrives. Harmless when it has ended."""

    @abstractmethod
    def destroy_subscription(self, subscription: Subscription) -> None:
        """Ends a subscription: its callback is not called again. Harmless when it has ended."""

    @abstractmethod
    def declare_parameter(self, spec: ParameterSpec) -> Parameter:
        """Makes a parameter known, with its override if there is one, else its default.

        The value is of the spec's kind: 5 for a number is 5.0. What is refused stays undeclared.

        Raises:
            ParameterError: It is declared already, or the override is not a value of it.
        """

    @abstractmethod
    def get_parameter(self, name: str) -> Parameter:
        """The parameter as it is now, also where the world may set it, but for wrong values.

        Raises:
            ParameterError: It has not been declared.
        """

    @abstractmethod
    def set_parameters(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        """Set all of them, or none: one that is undeclared, read-only or wrong is refused.

        Each keeps its declared type. For the spinning thread.
        """

    @abstractmethod
    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        """Ask `callback` on the spinning thread before parameters are set, from wherever."""

    @abstractmethod
    def close(self) -> None:
        """Ends everything that was created, and every thread of the backend's own.

        Idempotent, and bounded in time. What was published arrives, if the other side lets it
        within a moment; nothing is called back afterwards, and destroying is harmless.
        """

    # May implement.

    log_handler: logging.Handler | None = None
    """Given every record of the backend's manager or lone node, beside the console, from any
    thread; where the application has set up no logging, its level is the least for both. The
    message is one line of printable characters, with a traceback indented below it. It must
    raise nothing, also after `close`. Set before the constructor returns."""

    log_name: str | None = None
    """What the world calls the logger of the backend's manager or lone node, such as
    `robot.left`; None stands for the name of the role. Set before the constructor returns."""

    has_console_log: bool = True
    """Whether records go to the console, where the application has set up no logging. Set before
    the constructor returns."""

    def begin_run(self, request_stop: Callable[[], object]) -> None:  # noqa: B027 - as below
        """Note that a manager or lone node begins to spin.

        Args:
            request_stop: For a world that can end a program: ends it in order. From any thread.
        """

    def end_run(self) -> None:  # noqa: B027 - as below
        """End what keeps the rest of the program going in the same world, beside this backend.

        Called when a manager or lone node ends: before its clean-up if it was told to from outside
        the program, otherwise after `close`; and when a signal ends its constructor.
        """

    def expose_lifecycle(self, node: ManagedNode) -> None:  # noqa: B027 - nothing by default
        """Lets the outside see and drive the lifecycle of a node of this backend.

        Called once for each, when it is built; the node is unconfigured then. A world that can
        have but one for each backend shows the first, and a warning says so of any other.
        """

    def imu_sender(self, publisher: Publisher, template: Imu) -> ImuSender:
        """What publishes samples that are like `template` but for their stamp and numbers.

        A backend that can send them without building a message for each overrides it; what
        arrives is the same. What it gives may be called from any thread, one at a time.
        """
        return message_sender(publisher.publish, template)

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        """A timer with absolute deadlines; calls that were missed are skipped, not caught up.

        The first call is one period from now. Deadlines are on the monotonic clock, unless the
        world has a time of its own that timers should follow, such as that of a simulation.

        Raises:
            ValueError: The period is not a positive, finite number of seconds.
            BackendError: The backend is closed.
        """
        return self.executor.create_timer(timer_period_ns(period_s), callback)

    def destroy_timer(self, timer: Timer) -> None:
        """Ends a timer of this backend; harmless when it has ended."""
        if isinstance(timer, ExecutorTimer):
            timer.destroy()


def timer_period_ns(period_s: float) -> int:
    """The period of a timer in nanoseconds.

    Raises:
        ValueError: The period is not a positive, finite number of seconds.
    """
    if not (math.isfinite(period_s) and period_s > 0):
        raise ValueError(f"a timer's period is a positive number of seconds, not {period_s!r}")
    return max(1, int(period_s * 1e9))
