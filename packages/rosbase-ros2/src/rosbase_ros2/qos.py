"""Conversion of a topic's `qos_profile`: a depth, a profile of rosbase, or one of rclpy."""

import sys
from typing import Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from rosbase import as_profile

__all__ = ["queue_depth", "to_profile"]


def to_profile(qos_profile: Any, topic: str) -> QoSProfile:
    """Return the profile for rclpy; one of its own is returned unchanged.

    Raises:
        BackendError: It is neither a depth nor a profile.
    """
    if isinstance(qos_profile, QoSProfile):
        return qos_profile
    profile = as_profile(qos_profile, topic)
    return QoSProfile(
        # Of a history that keeps all it matters to nobody, and may be anything.
        depth=profile.depth if isinstance(profile.depth, int) else 0,
        history=HistoryPolicy[profile.history.name],
        reliability=ReliabilityPolicy[profile.reliability.name],
        durability=DurabilityPolicy[profile.durability.name],
    )


def queue_depth(profile: QoSProfile) -> int:
    """Return how many messages may wait for the callback; unlimited if the history keeps all."""
    return sys.maxsize if profile.history is HistoryPolicy.KEEP_ALL else max(1, profile.depth)
