"""Records of the log as messages, as `/rosout` has them on ROS 2."""

import logging

from rosbase import DurabilityPolicy, QoSProfile
from rosbase.contracts.message_format import message_format
from rosbase.messages import Time
from rosbase.messages.rcl_interfaces import Log
from rosbase_mcap.channel_table import QOS
from rosbase_mcap.qos_text import profiles_text
from rosbase_mcap.recorder import Recorder

__all__ = ["LOG_TOPIC", "LogChannel"]

LOG_TOPIC = "/rosout"
# That of rcl.
_PROFILE = QoSProfile(1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_MOST_LEVEL = 50


class LogChannel:
    """Records the log. Any thread calls it."""

    def __init__(self, recorder: Recorder) -> None:
        form = message_format(Log)
        self._encode = form.encode
        metadata = {QOS: profiles_text([_PROFILE])}
        self._record = recorder.channel(LOG_TOPIC, form.type_name, form.schema, metadata)

    def take(self, record: logging.LogRecord) -> None:
        """Record what a logger of Python says."""
        below = (record.exc_text, record.stack_info)
        text = "\n".join([record.getMessage(), *(lines for lines in below if lines)])
        place = (record.pathname, record.funcName or "", record.lineno)
        self.write(int(record.created * 1e9), record.levelno, record.name, text, place)

    def write(
        self,
        stamp_ns: int,
        level: int,
        name: str,
        text: str,
        place: tuple[str, str, int] = ("", "", 0),
    ) -> None:
        """Record a line.

        Args:
            stamp_ns: Its date, in nanoseconds since 1970.
            level: Number of its level, as `logging` has it; those of ROS are the same.
            name: Name of the logger.
            text: The text.
            place: File, function and line in it.
        """
        file, function, line = place
        level = min(max(level, 0), _MOST_LEVEL)
        message = Log(Time.as_stamp(stamp_ns), level, name, text, file, function, line)
        self._record(stamp_ns, stamp_ns, self._encode(message))
