"""Quality of service: how many messages a topic keeps, and which subscriptions they reach. Pure.

Names, numbers and defaults are those of ROS 2
(https://docs.ros.org/en/jazzy/Concepts/Intermediate/About-Quality-of-Service-Settings.html).
"""

import sys
from enum import Enum
from typing import Any

from attrs import field, frozen

from rosbase.errors import BackendError

__all__ = [
    "DurabilityPolicy",
    "HistoryPolicy",
    "QoSProfile",
    "ReliabilityPolicy",
    "as_profile",
    "mismatch",
    "qos_profile_sensor_data",
]


class ReliabilityPolicy(Enum):
    """Whether a message that got lost on the way is sent again."""

    RELIABLE = 1
    BEST_EFFORT = 2


class DurabilityPolicy(Enum):
    """Whether a publisher keeps its last messages for subscriptions that come later."""

    TRANSIENT_LOCAL = 1
    VOLATILE = 2


class HistoryPolicy(Enum):
    """Whether there is a limit to what is kept."""

    KEEP_LAST = 1
    KEEP_ALL = 2


def _is_depth(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 1


@frozen
class QoSProfile:
    """Profile that a publisher offers or a subscription asks for; by default as in ROS 2.

    `QoSProfile(1, durability=DurabilityPolicy.TRANSIENT_LOCAL)` makes a latched topic, as in
    ROS 1: a late subscription gets the last message first.

    Raises:
        ValueError: The depth is not a whole number from 1 up, or a policy is unknown.
    """

    depth: int = field(default=10)
    """Number of messages to keep, if not all: for the callback, and for late subscriptions."""
    # Compared by number, so members of rclpy's enumerations work too.
    reliability: ReliabilityPolicy = field(
        kw_only=True, default=ReliabilityPolicy.RELIABLE, converter=ReliabilityPolicy
    )
    durability: DurabilityPolicy = field(
        kw_only=True, default=DurabilityPolicy.VOLATILE, converter=DurabilityPolicy
    )
    history: HistoryPolicy = field(
        kw_only=True, default=HistoryPolicy.KEEP_LAST, converter=HistoryPolicy
    )

    def __attrs_post_init__(self) -> None:
        if self.history is HistoryPolicy.KEEP_LAST and not _is_depth(self.depth):
            raise ValueError(f"a depth is a whole number from 1 up, not {self.depth!r}")

    @property
    def queue_depth(self) -> int:
        """Number of messages that may be kept: `depth`, or unlimited if the history keeps all."""
        return sys.maxsize if self.history is HistoryPolicy.KEEP_ALL else self.depth

    @property
    def is_latched(self) -> bool:
        """Whether messages are kept for subscriptions that come later."""
        return self.durability is DurabilityPolicy.TRANSIENT_LOCAL


qos_profile_sensor_data = QoSProfile(5, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Profile for data that the next message outdates: a short queue, and nothing is sent again."""


def as_profile(qos_profile: Any, topic: str) -> QoSProfile:
    """Return the profile: a whole number is the depth of a reliable, volatile topic.

    Raises:
        BackendError: It is neither a depth nor a profile.
    """
    if isinstance(qos_profile, QoSProfile):
        return qos_profile
    if _is_depth(qos_profile):
        return QoSProfile(qos_profile)
    raise BackendError(
        f"the qos_profile of {topic!r} is a depth from 1 up or a QoSProfile of rosbase,"
        f" not {qos_profile!r}"
    )


def mismatch(offered: QoSProfile, asked: QoSProfile) -> str:
    """Return why a subscription gets nothing from a publisher; empty if it does. The rule is DDS's.

    Args:
        offered: The publisher's profile.
        asked: The subscription's.
    """
    if _falls_short(offered.reliability, asked.reliability, ReliabilityPolicy.RELIABLE):
        return "it asks for RELIABLE and the publisher offers BEST_EFFORT"
    if _falls_short(offered.durability, asked.durability, DurabilityPolicy.TRANSIENT_LOCAL):
        return "it asks for TRANSIENT_LOCAL and the publisher offers VOLATILE"
    return ""


def _falls_short(offered: Enum, asked: Enum, stronger: Enum) -> bool:
    return asked is stronger and offered is not stronger
