"""A stream of the messages of a topic."""

from collections import deque
from collections.abc import Callable
from itertools import count
from typing import Any

from rosbase.clock import SystemClock
from rosbase.contracts.message_format import MessageFormat
from rosbase.contracts.tap import Tap
from rosbase.control.answers.backlog import Backlog
from rosbase.control.answers.ends import FoundTopic, format_facts
from rosbase.control.streams import Stream
from rosbase.messages.fields import is_frozen

__all__ = ["TopicEcho"]

# While messages come, the thread of the socket looks so often, instead of being woken by each: a
# turn of the thread costs as much as ten messages.
_BATCH_NS = 50_000_000
_date_ns = SystemClock.now_ns


class TopicEcho(Stream):
    """Messages as events, the newest of them if the client is slow; first those that are kept.

    The publishing thread only appends the message. It is written as bytes on the socket's thread,
    unless it can be changed meanwhile.
    """

    def __init__(
        self, form: MessageFormat, limit: int, every_ns: int, now_ns: Callable[[], int]
    ) -> None:
        """Prepare the stream; `open` begins to hear.

        Args:
            form: The format of the messages.
            limit: How many wait, if there is room for their bytes; older ones are dropped.
            every_ns: Shortest time between two messages; those between are left out.
            now_ns: The monotonic clock.
        """
        self.ok = format_facts(form)
        self._encode = form.encode
        self._every_ns = every_ns
        self._now_ns = now_ns
        self._waiting = Backlog(limit)
        self._kept: deque[Any] = deque(maxlen=limit)
        self._serial = count(1).__next__
        self._last_serial = 0
        self._taken = 0
        # Whether a message was taken since the last look.
        self._has_taken = False
        self._next_ns = 0
        # By class: whether its objects stay as they are.
        self._frozen: dict[type, bool] = {bytes: True}
        self._tap: Tap | None = None

    def open(self, topic: FoundTopic) -> None:
        """Begin to hear the topic."""
        on_message = self._hear_some if self._every_ns else self._hear
        self._tap = topic.backend.add_tap(topic.name, on_message)
        # After that, so that none is missed; what both have is heard once.
        heard = [id(message) for message in self._waiting.messages()]
        kept = topic.backend.kept_messages(topic.name)
        self._kept.extend(message for message in kept if id(message) not in heard)

    def take(self) -> tuple[str, bytes] | None:
        """Return the next message."""
        while self._kept:
            data = self._written(self._kept.popleft())
            if data is not None:
                return '{"stamp_ns":null,"dropped":0}', data
        while True:
            try:
                serial, stamp_ns, message = self._waiting.take()
            except IndexError:
                if self._is_over_for_now():
                    return None
                continue
            self._has_taken = True
            self._taken += 1
            self._last_serial = max(self._last_serial, serial)
            self.dropped = self._last_serial - self._taken
            data = self._written(message)
            if data is not None:
                # As JSON: there may be thousands in a second.
                return f'{{"stamp_ns":{stamp_ns},"dropped":{self.dropped}}}', data

    def close(self) -> None:
        """Hear nothing any more."""
        if self._tap is not None:
            self._tap.close()
        self._waiting.close()

    def _is_over_for_now(self) -> bool:
        """Decide when to look again; return False if something has come meanwhile."""
        if self._every_ns >= _BATCH_NS:
            # Messages are so far apart that a look between them would find none.
            return not self._waiting
        now_ns = self._now_ns()
        if self._has_taken:
            self._has_taken = False
            self.due_ns = now_ns + _BATCH_NS
        elif self.due_ns is None or now_ns >= self.due_ns:
            # Nothing has come for a while: whoever appends from now on wakes.
            self.due_ns = None
            return not self._waiting
        return True

    def _written(self, message: Any) -> bytes | None:
        """Return a message as bytes; None if it has none."""
        if message is None or type(message) is bytes:
            return message
        try:
            return self._encode(message)
        except (TypeError, ValueError):
            # It could not be sent anywhere; whoever publishes it is told when that is tried.
            return None

    # On the threads that publish.

    def _hear(self, message: Any) -> None:
        if not self._frozen.get(type(message)) and not self._stays(message):
            message = self._written(message)
        is_urgent = self._waiting.append(self._serial(), _date_ns(), message)
        if self.due_ns is None or is_urgent:
            self.wake()

    def _stays(self, message: Any) -> bool:
        kind = type(message)
        self._frozen[kind] = is_frozen(kind)
        return self._frozen[kind]

    def _hear_some(self, message: Any) -> None:
        now_ns = self._now_ns()
        if now_ns >= self._next_ns:
            self._next_ns = now_ns + self._every_ns
            self._hear(message)
