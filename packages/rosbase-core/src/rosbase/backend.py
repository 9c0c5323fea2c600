"""The backend contract: what connects a manager or a lone node to the world.

Must implement: every abstract method. May implement: those under that head, where the world has
more to it than this process. Never override: the rest, which is the executor's.

Threads: one thread spins the executor, and every callback runs on it. What arrives on threads
of the backend's own is handed over with `call_soon`. `publish`, `call_soon` and the destroying
of what was created may be called from any thread; `call_soon` from a signal handler too.

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
"""

import logging
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, Protocol, TypeVar

from attrs import field, frozen

from rosbase.clock import Clock, SystemClock
from rosbase.executor import Executor, ExecutorTimer
from rosbase.imu_sender import ImuSender, message_sender
from rosbase.lifecycle import ManagedNode
from rosbase.messages import Imu
from rosbase.parameters import Parameter, ParameterSpec, ParameterValue
from rosbase.qos import QoSProfile

__all__ = ["Backend", "BackendOptions", "Publisher", "Subscription", "Timer", "timer_period_ns"]

MessageT = TypeVar("MessageT")


class Publisher(Protocol):
    """Sends messages to a topic."""

    @property
    def topic(self) -> str:
        """The full name of the topic, such as `/imu/data`."""
        ...

    def publish(self, message: Any) -> object:
        """Hands the message to every subscription. From any thread; does not wait for them.

        Raises:
            TypeError: The message is not of the topic's type.
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
        """How many messages were lost because the callback was slower than the publisher."""
        ...


class Timer(Protocol):
    """Calls back again and again. The names are those of rclpy's timer."""

    def cancel(self) -> None:
        """Stops it, until `reset`."""
        ...

    def reset(self) -> None:
        """Starts it again: the next call is one period from now."""
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
        """Starts with an executor that nobody spins yet."""
        self.node_name = node_name
        """The name under which the world sees it, its namespace in front if there is one."""
        self.clock = clock
        """The clock for stamps, timers and deadlines."""
        self.executor = Executor(clock)
        """What runs callbacks, on the thread that spins it."""
        self.call_soon = self.executor.call_soon
        """Has the spinning thread call a function. From any thread, and from signal handlers."""
        self.spin_once = self.executor.spin_once
        """Handles one callback, waiting for one so many seconds; tells whether there was one.
        What it raises is raised here."""
        self.spin_until = self.executor.spin_until
        """Handles callbacks as they come, until a deadline on the monotonic clock."""

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
        """Ends a publisher of this backend; harmless when it has ended."""

    @abstractmethod
    def destroy_subscription(self, subscription: Subscription) -> None:
        """Ends a subscription: its callback is not called again. Harmless when it has ended."""

    @abstractmethod
    def declare_parameter(self, spec: ParameterSpec) -> Parameter:
        """Makes a parameter known, with its override if there is one, else its default.

        Raises:
            ParameterError: It is declared already, or the override is not a value of it.
        """

    @abstractmethod
    def get_parameter(self, name: str) -> Parameter:
        """The parameter as it is now.

        Raises:
            ParameterError: It has not been declared.
        """

    @abstractmethod
    def close(self) -> None:
        """Ends everything that was created. Idempotent; nothing is called back afterwards."""

    # May implement.

    log_handler: logging.Handler | None = None
    """Given every record of the backend's manager or lone node, beside the console, from any
    thread; where the application has set up no logging, its level is the least for both. It
    must raise nothing, also after `close`. Set before the constructor returns."""

    def expose_lifecycle(self, node: ManagedNode) -> None:  # noqa: B027 - nothing by default
        """Lets the outside see and drive the lifecycle of a node of this backend.

        Called once for each, when it is built; the node is unconfigured then.
        """

    def imu_sender(self, publisher: Publisher, template: Imu) -> ImuSender:
        """What publishes samples that are like `template` but for their stamp and numbers.

        A backend that can send them without building a message for each overrides it. What it
        gives may be called from any thread, one at a time.
        """
        return message_sender(publisher.publish, template)

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        """A timer with absolute deadlines; calls that were missed are skipped, not caught up.

        The first call is one period from now.

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
