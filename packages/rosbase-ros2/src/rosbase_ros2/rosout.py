"""Log records on `/rosout` and in the log file of ROS, as of any ROS node.

rclpy's own logger is not used for it. That writes to the console as well, where rosbase's records
already are, and costs many times as much.
"""

import logging
from typing import Any

from rcl_interfaces.msg import Log
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile

from rosbase import printable
from rosbase.messages import Time
from rosbase_ros2.log_file import LogFile

__all__ = ["RosoutHandler"]

_TYPE = "rcl_interfaces/msg/Log"
# As of rcl's own publishers: `rcl_qos_profile_rosout_default`.
_PROFILE = QoSProfile(
    depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan=Duration(seconds=10)
)
_NS_PER_S = 1_000_000_000


class RosoutHandler(logging.Handler):
    """Publishes records under the name of a node, and appends them to the log file.

    Its level is that of the node's logger when it is made, which `--log-level` sets. With
    `--disable-rosout-logs` it publishes nothing.
    """

    def __init__(self, node: Any, file: LogFile | None = None) -> None:
        """Take the rclpy node, and the log file if there is one."""
        ros_logger = node.get_logger()
        super().__init__(int(ros_logger.get_effective_level()))
        self.publisher = (
            node.create_publisher(Log, "/rosout", _PROFILE) if _wants_logs(node) else None
        )
        """Publisher of rclpy, while there is one; it is destroyed with the node."""
        self._node_name = ros_logger.name
        self._file = file

    def emit(self, record: logging.LogRecord) -> None:
        """Publish and append one record. Call it from any thread, one at a time."""
        if self._file is not None:
            self._file.write(record)
        publisher = self.publisher
        if publisher is None:
            return
        try:
            publisher.publish(_to_ros(record, self._name_of(record)))
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


def _wants_logs(node: Any) -> bool:
    """Return whether rcl itself publishes this node's logs; rclpy has no better way to ask."""
    found = node.get_publisher_names_and_types_by_node(node.get_name(), node.get_namespace())
    return any(_TYPE in types for _, types in found)


def _to_ros(record: logging.LogRecord, node_name: str) -> Any:
    message = Log(
        # ROS knows these five only, and the tools look them up.
        level=min(50, max(10, record.levelno // 10 * 10)),
        name=node_name,
        # What the loggers hand on is printable, so it has none of what ROS cannot send.
        msg=record.getMessage(),
        file=printable(record.pathname),
        function=record.funcName or "",
        line=record.lineno,
    )
    stamp = Time.as_stamp(int(record.created * _NS_PER_S))
    message.stamp.sec, message.stamp.nanosec = stamp.sec, stamp.nanosec
    return message
