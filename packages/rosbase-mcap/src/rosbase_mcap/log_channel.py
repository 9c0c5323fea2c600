"""Records of the log as messages, as `/rosout` has them on ROS 2."""

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rosbase import DurabilityPolicy, QoSProfile
from rosbase.contracts.message_format import message_format
from rosbase.messages import Time
from rosbase.messages.rcl_interfaces import Log
from rosbase_mcap.channel_table import QOS, Channels
from rosbase_mcap.qos_text import profiles_text

__all__ = ["LOG_TOPIC", "LogChannel", "no_output"]

LOG_TOPIC = "/rosout"
# As in rcl.
_PROFILE = QoSProfile(1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_MOST_LEVEL = 50


class _Speaker(threading.local):
    """Whether a thread speaks for the recorder, and not for the program."""

    is_recorder = False


_speaker = _Speaker()


@contextmanager
def no_output() -> Iterator[None]:
    """Mark log lines in this block as the recorder's, which are no output of the program.

    A replay has a recorder of its own, with a logger of its own.
    """
    before, _speaker.is_recorder = _speaker.is_recorder, True
    try:
        yield
    finally:
        _speaker.is_recorder = before


class LogChannel:
    """Records the log. Any thread calls it."""

    def __init__(self, channels: Channels) -> None:
        form = message_format(Log)
        self._encode = form.encode
        metadata = {QOS: profiles_text([_PROFILE])}
        self._record = channels.channel(LOG_TOPIC, form.type_name, form.schema, metadata)

    def take(self, record: logging.LogRecord) -> None:
        """Record what a logger of Python says, except for `no_output`."""
        if _speaker.is_recorder:
            return
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
            level: Number of its level in `logging`, which is also its number in ROS.
            name: Name of the logger.
            text: The text.
            place: File, function and line in it.
        """
        file, function, line = place
        level = min(max(level, 0), _MOST_LEVEL)
        message = Log(Time.as_stamp(stamp_ns), level, name, text, file, function, line)
        self._record(stamp_ns, stamp_ns, self._encode(message))
