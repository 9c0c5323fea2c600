"""Log records on `/rosout` and in the log file of ROS, as of any ROS node.

rclpy's own logger is not used for it. That writes to the console as well, where rosbase's records
already are, and costs many times as much. Its records come here, for the node's one publisher.
"""

import logging
from typing import Any

from rcl_interfaces.msg import Log
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile

from rosbase import SystemClock, printable
from rosbase.messages import Time
from rosbase_ros2.log_file import LogFile
from rosbase_ros2.shared_node import OwnGroup, SharedNode

__all__ = ["RosoutHandler"]

# As of rcl's own publishers: `rcl_qos_profile_rosout_default`.
_PROFILE = QoSProfile(
    depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan=Duration(seconds=10)
)
_NS_PER_S = 1_000_000_000


class RosoutHandler(logging.Handler):
    """Publishes records under the name of a node, and appends them to the log file.

    It takes the level of the node's logger when it is made, which `--log-level` sets.
    """

    def __init__(
        self, node: SharedNode, file: LogFile | None = None, *, is_published: bool = True
    ) -> None:
        """Publish the records of rosbase and of the node's own logger.

        Args:
            node: The rclpy node.
            file: The log file, if there is one.
            is_published: False with `--disable-rosout-logs`.
        """
        ros_logger = node.get_logger()
        super().__init__(int(ros_logger.get_effective_level()))
        self.publisher = _create_publisher(node) if is_published else None
        """Publisher of rclpy, while there is one; it is destroyed with the node."""
        self._node_name = ros_logger.name
        self._file = file
        self._machine = SystemClock()
        node.log_listeners.append(self._relay)

    def emit(self, record: logging.LogRecord) -> None:
        """Publish and append one record. Call it from any thread, one at a time."""
        if self._file is not None:
            self._file.write(record)
        self._publish(
            int(record.created * _NS_PER_S),
            # ROS knows these five only, and the tools look them up.
            level=min(50, max(10, record.levelno // 10 * 10)),
            name=self._name_of(record),
            # What the loggers hand on is printable, so it has none of what ROS cannot send.
            msg=record.getMessage(),
            file=printable(record.pathname),
            function=record.funcName or "",
            line=record.lineno,
        )

    def _relay(
        self, level: int, name: str, message: str, file: str, function: str, line: int
    ) -> None:
        """Publish a record of the node's own logger, which has written it everywhere else."""
        self._publish(
            self._machine.now_ns(),
            level=level,
            name=name,
            msg=message,
            file=file,
            function=function,
            line=line,
        )

    def _publish(self, time_ns: int, **fields: Any) -> None:
        publisher = self.publisher
        if publisher is None:
            return
        stamp = Time.as_stamp(time_ns)
        try:
            message = Log(**fields)
            message.stamp.sec, message.stamp.nanosec = stamp.sec, stamp.nanosec
            publisher.publish(message)
        except Exception:
            # The node or its context is gone. A record must not end whoever logs it.
            pass

    def _name_of(self, record: logging.LogRecord) -> str:
        """Return the node's name, or the name of a logger below it."""
        is_below = record.name.startswith(f"{self._node_name}.")
        return record.name if is_below else self._node_name

    def close(self) -> None:
        """Stop publishing. Later records still go to the file."""
        self.publisher = None
        super().close()


def _create_publisher(node: SharedNode) -> Any:
    return node.create_publisher(Log, "/rosout", _PROFILE, callback_group=OwnGroup())
