"""What a topic's `qos` means: a depth, or a profile of rclpy."""

import sys
from typing import Any

from rclpy.qos import HistoryPolicy, QoSProfile

from rosbase.errors import BackendError

__all__ = ["queue_depth", "to_profile"]


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


def queue_depth(profile: QoSProfile) -> int:
    """How many messages may wait for the callback; of a history that keeps all, any number."""
    return sys.maxsize if profile.history is HistoryPolicy.KEEP_ALL else max(1, profile.depth)
