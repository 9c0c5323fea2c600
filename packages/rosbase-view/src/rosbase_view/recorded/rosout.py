"""The log of a recording, from `/rosout`. Pure."""

from rosbase import WireError
from rosbase.control.shapes import LogRecord
from rosbase_view.reports import Heard

__all__ = ["LOG", "record_of"]

LOG = "rcl_interfaces/msg/Log"
"""Type of the messages of the log."""


def record_of(heard: Heard) -> LogRecord | None:
    """Return a record of the log; None for a message that cannot be read."""
    try:
        message = heard.message
        stamp = message["stamp"]
        return {
            "pid": heard.topic[1],
            "stamp_ns": stamp["sec"] * 1_000_000_000 + stamp["nanosec"],
            # ROS and `logging` have the same levels.
            "level": message["level"],
            "name": message["name"],
            "text": message["msg"],
        }
    except (WireError, KeyError):
        # A type of that name with other fields.
        return None
