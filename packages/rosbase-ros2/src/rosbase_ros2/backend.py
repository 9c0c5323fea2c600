"""The `ros2` backend: nodes of rclpy, handled on the main-loop thread."""

import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack

import rclpy

from rosbase import (
    Backend,
    BackendOptions,
    NodeConnection,
    SystemClock,
    check_node_name,
)
from rosbase.entries.conductor import conductor_of
from rosbase_ros2.deadline import Deadline
from rosbase_ros2.delivery import await_delivery
from rosbase_ros2.formats import plugin_conversions
from rosbase_ros2.given import name_strange_files, name_strange_parameters, own_first
from rosbase_ros2.host import Host
from rosbase_ros2.node import RosNode
from rosbase_ros2.process import Process
from rosbase_ros2.starting import (
    prepare_machine,
    ros_arguments,
    start_node,
    start_other_node,
    without_node_name,
)
from rosbase_ros2.written import RosArguments

__all__ = ["Ros2Backend"]

# How long the last messages may take to arrive, of all publishers together.
_LAST_MESSAGES_S = 0.5
# How long the callbacks of rclpy may take to end, of all nodes together.
_END_S = 1.0


class Ros2Backend(RosNode, Backend):
    """A connection to ROS 2: one rclpy context, and the node of a manager or a standalone node.

    Each lifecycle node of the manager is another node of the same context. Every node has a
    thread that receives its messages and answers its services.
    """

    def __init__(self, options: BackendOptions) -> None:
        """Start a node, with the arguments after `--ros-args` on the command line.

        Raises:
            BackendError: ROS refuses the arguments or the name, or cannot start on this machine.
            ParameterError: An override of a quality of service is invalid.
        """
        is_recorded = conductor_of(options.clock) is not None
        clock = options.clock if is_recorded else SystemClock()
        Backend.__init__(self, clock, options.node_name)
        context = rclpy.Context()
        warning, words = prepare_machine(), ros_arguments(sys.argv)
        arguments = RosArguments(words)
        node = start_node(context, options, arguments)
        process = Process(
            context,
            options,
            self.executor,
            words,
            arguments,
            plugin_conversions(),
            self.new_ends,
            self.conductor,
        )
        process.find_log_file()
        self._others: list[RosNode] = []
        try:
            self.network = str(context.get_domain_id())
            self.set_up(process, node, self._end_with_context)
            with arguments.for_rcl() as taken:
                self._host = Host(self._logger.info, without_node_name(taken))
        except BaseException:
            for spinner in process.spinners:
                spinner.close(Deadline(_END_S))
            node.destroy_node()
            context.try_shutdown()
            raise
        if warning:
            self._logger.warning(warning)
        if words or options.parameter_overrides:
            # When the constructors have built their nodes and declared their parameters.
            self.executor.call_aside(self._name_strange)

    def open_node(self, name: str, *, is_lifecycle: bool) -> NodeConnection:
        """Open a node of its own for a lifecycle node; others share this one."""
        if not is_lifecycle:
            return Backend.open_node(self, name, is_lifecycle=False)
        check_node_name(name)
        self._process.check_open()
        prefix = f"{name}."
        values = own_first(self._process.options.parameter_overrides, prefix)
        node = start_other_node(self._process.context, name, values)
        other = RosNode()
        try:
            other.set_up(self._process, node, _nothing, prefix)
        except BaseException:
            node.destroy_node()
            raise
        self._others.append(other)
        return other

    def begin_run(self, request_stop: Callable[[], object]) -> None:
        """End the run when the program shuts rclpy down, in any way."""
        self._host.begin_run(request_stop, self._spinner)
        if not self._process.context.ok():
            request_stop()

    def end_run(self) -> None:
        """Shut rclpy down: `rclpy.ok()` is false from now on.

        A context that rosbase has initialised stays while another manager needs it.
        """
        self._host.end_run()

    def close(self) -> None:
        """Close everything, in bounded time; published messages are delivered first."""
        process = self._process
        if process.is_closed:
            return
        process.is_closed = True
        nodes: list[RosNode] = [*self._others, self]
        with ExitStack() as last:
            # Each of them, whatever happens before; the last one first.
            last.callback(self.executor.close)
            last.callback(self._host.close)
            last.callback(process.context.try_shutdown)
            last.callback(_destroy, nodes)
            publishers = [publisher for node in nodes for publisher in node.stop_sending()]
            if process.context.ok():
                await_delivery(publishers, _LAST_MESSAGES_S, SystemClock())
            process.taps.close()
            for node in nodes:
                node.stop_receiving()

    def _end_with_context(self) -> None:
        self._host.shut_down("the context of the node has been shut down")

    def _name_strange(self) -> None:
        """Warn of what was given from outside and concerns no node of this process."""
        nodes: list[RosNode] = [self, *self._others]
        claimed = tuple(f"{other.node.get_name()}." for other in self._others)
        name_strange_files(
            self._process.arguments.files,
            {f"/{n.node_name}": n.given_names for n in nodes},
            self._warn,
        )
        name_strange_parameters(nodes, claimed)


def _destroy(nodes: Sequence[RosNode]) -> None:
    """Destroy the nodes in order, each whatever happens to the others; hanging ones remain."""
    for node in nodes:
        node.begin_end()
    deadline = Deadline(_END_S)
    with ExitStack() as each:
        for node in reversed(nodes):
            each.callback(node.destroy, deadline)


def _nothing() -> None:
    """Do nothing: the first node ends the run."""
