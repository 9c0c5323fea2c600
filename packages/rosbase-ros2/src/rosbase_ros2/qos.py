"""What a topic's `qos` means: a depth, or a profile of rclpy."""

from typing import Any

from rclpy.qos import QoSProfile

from rosbase.errors import BackendError

__all__ = ["to_profile"]


def to_profile(qos: Any, topic: str) -> QoSProfile:
    """The profile: a whole number is the depth of a reliable, volatile topic.

    Raises:
        BackendError: It is neither.
    """
    if isinstance(qos, QoSProfile):
        return qos
    if isinstance(qos, int) and not isinstance(qos, bool) and qos >= 1:
        return QoSProfile(depth=qos)
    raise BackendError(
        f"the qos of {topic!r} is a depth from 1 up or an rclpy QoSProfile, not {qos!r}"
    )
