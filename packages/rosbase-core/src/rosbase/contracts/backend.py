"""The backend contract: connects a manager or a standalone node to the outside world.

Must implement: `create_publisher`, `create_subscription`, `destroy_publisher`,
`destroy_subscription`, `declare_parameter`, `get_parameter`, `set_parameters`,
`parameter_names`, `describe_parameter`, `add_on_set_parameters_callback`,
`add_post_set_parameters_callback`, `close`.

May implement, if the backend reaches beyond this process: `delivers_in_process`, `network`,
`log_handler`, `log_name`, `has_console_log`, `begin_run`, `end_run`, `open_node`,
`expose_lifecycle`, `prepared_sender`, `create_timer`, `destroy_timer`, `timer_now_ns`,
`create_service`, `create_client`, `destroy_service`, `destroy_client`, `add_tap`,
`kept_messages`, `graph`, `message_format`, `find_type`, `take_over`.

May set, before the constructor returns: `node_name`, `clock`.

Never override, because the constructor sets them: `executor`, `call_soon`, `spin_once`,
`spin_until`, `is_in_virtual_time`, `new_ends`, `connections`, `conductor`.

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

Services: names follow the rules for topics. A type is a class with the classes `Request` and
`Response`. The spinning thread may call a service in any callback, also in the callback of a
service. While it waits, it runs the calls from `executor.call_urgently`, and nothing else. So
requests come by that, and an answer is set on the thread on which it arrives. Every call ends: with
the answer, or with a ServiceError within its timeout, whatever the service does. An exception of a
callback is logged, and the spinning goes on. A backend may have no services.

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

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

from attrs import field, frozen

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.names import check_node_name
from rosbase.contracts.new_ends import NewEnds
from rosbase.contracts.node_connection import NodeConnection, Publisher, Subscription, Timer
from rosbase.contracts.node_view import NodeView
from rosbase.entries.conductor import conductor_of
from rosbase.errors import BackendError
from rosbase.parameters import ParameterValue
from rosbase.runtime.executor import Executor, ExecutorTimer

__all__ = ["Backend", "BackendOptions", "Publisher", "Subscription", "Timer", "timer_period_ns"]


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


class Backend(NodeConnection):
    """A connection to the outside world, for one manager or one standalone node.

    It is the connection of their own node, and opens connections for the manager's other nodes.
    """

    delivers_in_process = False
    """Whether messages reach this process's own subscriptions without leaving it.

    Listening costs next to nothing then.
    """

    network = ""
    """Part of the middleware that programs share, such as the number of a ROS domain.

    Programs of one backend hear each other only if they are in the same one.
    """

    def __init__(self, clock: Clock, node_name: str) -> None:
        """Start with an executor that nobody spins yet.

        Raises:
            BackendError: ROS would refuse the name for a node.
        """
        check_node_name(node_name)
        self.node_name = node_name
        self.clock = clock
        self.connections: list[NodeConnection] = [self]
        """Its own, and those that were opened for nodes; the roles add them."""
        self.new_ends = NewEnds()
        """Tells of each new publisher and subscription. The backend calls `tell`."""
        self.conductor = conductor_of(clock)
        """Records or replays the program; None for most programs."""
        conductor = self.conductor
        self.executor = conductor.make_executor() if conductor else Executor(clock)
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
        machine = getattr(clock, "machine", clock)
        self.is_in_virtual_time = not isinstance(machine, SystemClock)
        """Whether deadlines follow a test's clock instead of this machine's."""

    @abstractmethod
    def close(self) -> None:
        """Close everything that was created, and end every thread of the backend.

        Idempotent, and bounded in time. Published messages arrive, if the other side takes
        them within a moment. Afterwards no callback is called, and destroying is harmless.
        """

    # May implement.

    def begin_run(self, request_stop: Callable[[], object]) -> None:
        """Note that a manager or standalone node begins to spin.

        Args:
            request_stop: Ends the program in order, for a backend that can end it. Call it from
                any thread.
        """

    def end_run(self) -> None:
        """End whatever else keeps the program running on the same middleware.

        Called when a manager or standalone node ends: before its clean-up if it was
        stopped from outside the program, otherwise after `close`. Also called when a
        signal ends its constructor.
        """

    def create_timer(self, period_s: float, callback: Callable[[], object]) -> Timer:
        """Create a timer with absolute deadlines; missed calls are skipped, not caught up."""
        return self.executor.create_timer(timer_period_ns(period_s), callback)

    def destroy_timer(self, timer: Timer) -> None:
        """Destroy a timer of this backend. Do nothing if it has ended."""
        if isinstance(timer, ExecutorTimer):
            timer.destroy()

    def timer_now_ns(self) -> int:
        """Return the time that timers follow, in nanoseconds from an arbitrary start.

        Intervals are measured with it, such as the age of a message. It may be called from any
        thread. It goes back only if the backend's own time does, such as simulated time that
        starts again.
        """
        return self.clock.monotonic_ns()

    def take_over(self, topic: str, *, depth: int = 0) -> Callable[[Any], None]:
        """Publish a topic in place of the program, as a replay of recorded topics does.

        From now on, publishers of the program reach nobody on it. The returned function delivers a
        message to all subscriptions, whatever their profiles, and to taps.

        Args:
            topic: Its full name.
            depth: Number of messages that are kept for subscriptions that come later.

        Raises:
            BackendError: This backend cannot, as by default.
        """
        raise BackendError(f"{topic}: messages cannot be replayed on this backend")

    def open_node(self, name: str, *, is_lifecycle: bool) -> NodeConnection:
        """Open the connection of a node that the manager registers under that name.

        By default the node shares this connection, and its parameters have its name in front,
        such as `camera.fps`. A lifecycle node has also a log and private topics (`~/image`) of
        its own name. A backend that other programs see may override it, and show them each
        lifecycle node as a node of its own. `close` closes the connections of all nodes.

        Raises:
            BackendError: ROS would refuse the name for a lifecycle node, or the backend is
                closed.
        """
        return NodeView(self, name, is_lifecycle=is_lifecycle)


def timer_period_ns(period_s: float) -> int:
    """Return the period of a timer in nanoseconds.

    Raises:
        ValueError: The period is not a positive, finite number of seconds.
    """
    if not (math.isfinite(period_s) and period_s > 0):
        raise ValueError(f"a timer's period is a positive number of seconds, not {period_s!r}")
    return max(1, int(period_s * 1e9))
