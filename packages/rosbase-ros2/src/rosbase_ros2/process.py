"""State that all nodes of one backend share: the rclpy context, the arguments, the main loop."""

from collections.abc import Sequence
from typing import Any

from attrs import define, field

from rosbase import BackendError, BackendOptions, Executor, NewEnds, Tap, one_line
from rosbase.entries.conductor import Conductor
from rosbase_ros2.conversion import Conversions
from rosbase_ros2.log_file import LogFile
from rosbase_ros2.shared_node import SharedNode
from rosbase_ros2.spinner import Spinner
from rosbase_ros2.starting import is_enabled
from rosbase_ros2.taps import Taps
from rosbase_ros2.written import RosArguments

__all__ = ["Process"]


@define
class Process:
    """The part of a backend that its nodes have in common."""

    context: Any
    """Context of rclpy."""
    options: BackendOptions
    executor: Executor
    """Runs the callbacks of the program, on the main loop."""
    words: Sequence[str]
    """Arguments for ROS on the command line."""
    arguments: RosArguments
    """The same arguments, with the values written in them."""
    conversions: Conversions
    new_ends: NewEnds
    """Tells of new publishers and subscriptions."""
    conductor: Conductor | None = None
    """Records the program; None for most programs."""
    log_file: LogFile | None = field(init=False, default=None)
    """Log file of ROS, if there is one."""
    nodes: list[SharedNode] = field(init=False, factory=list)
    """Nodes of rclpy."""
    spinners: list[Spinner] = field(init=False, factory=list)
    """Threads of the nodes."""
    taps: Taps = field(init=False)
    """Taps of the nodes."""
    is_closed: bool = field(init=False, default=False)

    def __attrs_post_init__(self) -> None:
        self.taps = Taps(self.nodes, self._fail_tap)

    def find_log_file(self) -> None:
        """Find the log file, which rcl opens with the first node."""
        if is_enabled("external-lib-logs", self.words):
            self.log_file = LogFile.of_this_process()

    def is_on_rclpy_thread(self) -> bool:
        """Return whether the caller is a callback of rclpy, on a thread of any node."""
        return any(spinner.is_current_thread for spinner in self.spinners)

    def _fail_tap(self, tap: Tap, error: Exception) -> None:
        """Log the exception of a tap, and close it, when nobody publishes in this call."""
        reason = f"{type(error).__name__}: {one_line(str(error))}"

        def end() -> None:
            self.nodes[0].get_logger().error(
                f"{tap.topic}: a tap has ended, because it raised {reason}"
            )
            tap.close()

        self.executor.call_soon(end)

    def check_open(self) -> None:
        """Check that the backend has not been closed.

        Raises:
            BackendError: It has.
        """
        if self.is_closed:
            raise BackendError("the backend is closed")
