"""rclpy's warnings of a topic's other end that does not match, by the logger of the node.

rclpy gives them to a logger that it gets by name, which does not reach `/rosout` here.
"""

from collections.abc import Callable
from typing import Any

from rclpy.qos import qos_policy_name_from_kind

__all__ = ["warn_of_publishers", "warn_of_subscriptions"]


def warn_of_publishers(events: Any, topic: str, get_logger: Callable[[], Any]) -> None:
    """Warn of publishers that a subscription does not match, where the program does not look."""

    def warn(event: Any) -> None:
        get_logger().warning(
            f"New publisher discovered on topic '{topic}', offering incompatible QoS."
            " No messages will be received from it."
            f" Last incompatible policy: {qos_policy_name_from_kind(event.last_policy_kind)}"
        )

    _set_defaults(events, topic, get_logger, warn)


def warn_of_subscriptions(events: Any, topic: str, get_logger: Callable[[], Any]) -> None:
    """Warn of subscriptions that a publisher does not match, where the program does not look."""

    def warn(event: Any) -> None:
        get_logger().warning(
            f"New subscription discovered on topic '{topic}', requesting incompatible QoS."
            " No messages will be sent to it."
            f" Last incompatible policy: {qos_policy_name_from_kind(event.last_policy_kind)}"
        )

    _set_defaults(events, topic, get_logger, warn)


def _set_defaults(
    events: Any, topic: str, get_logger: Callable[[], Any], warn: Callable[[Any], None]
) -> None:
    def warn_of_type(event: Any) -> None:
        get_logger().warning(
            f"Incompatible type on topic '{topic}', no messages will be sent to it."
        )

    if events.use_default_callbacks:
        events.incompatible_qos = events.incompatible_qos or warn
        events.incompatible_type = events.incompatible_type or warn_of_type
