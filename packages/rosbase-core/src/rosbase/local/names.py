"""Topic names, resolved as ROS 2 does (design.ros2.org/articles/topic_and_service_names)."""

import re

from rosbase.errors import BackendError

__all__ = ["resolve_topic"]

_NAME = re.compile(r"(~/|/)?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*", re.ASCII)


def resolve_topic(topic: str, node_name: str) -> str:
    """The full name: `imu/data` is `/imu/data`, `~/status` is `/<node_name>/status`.

    Raises:
        BackendError: It is not a topic name.
    """
    if not isinstance(topic, str) or not _NAME.fullmatch(topic):
        raise BackendError(f"{topic!r} is not a topic name")
    if topic.startswith("~/"):
        return f"/{node_name}/{topic[2:]}"
    return topic if topic.startswith("/") else f"/{topic}"
