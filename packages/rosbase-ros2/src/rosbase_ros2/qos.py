"""Conversion of a topic's `qos_profile`: a depth, a profile of rosbase, or one of rclpy."""

import sys
from typing import Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

import rosbase
from rosbase import as_profile

__all__ = ["from_profile", "queue_depth", "to_profile"]


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


def from_profile(profile: QoSProfile) -> rosbase.QoSProfile | None:
    """Return a profile of rclpy as one of rosbase; None if rosbase has no such policies."""
    try:
        return rosbase.QoSProfile(
            max(1, profile.depth),
            history=rosbase.HistoryPolicy[profile.history.name],
            reliability=rosbase.ReliabilityPolicy[profile.reliability.name],
            durability=rosbase.DurabilityPolicy[profile.durability.name],
        )
    except KeyError:
        return None


def queue_depth(profile: QoSProfile) -> int:
    """Return how many messages may wait for the callback; unlimited if the history keeps all."""
    return sys.maxsize if profile.history is HistoryPolicy.KEEP_ALL else max(1, profile.depth)
