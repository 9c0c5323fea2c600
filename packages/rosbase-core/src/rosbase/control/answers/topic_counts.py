"""A stream of the numbers of messages of many topics, for whoever looks at all of them."""

from collections import deque
from collections.abc import Callable, Iterable
from itertools import count
from typing import Any

from rosbase.contracts.tap import Tap
from rosbase.control.answers.ends import FoundTopic
from rosbase.control.json_text import to_json
from rosbase.control.streams import Stream

__all__ = ["TopicCounts"]

_NS_PER_S = 1_000_000_000


class TopicCounts(Stream):
    """Counts the messages of topics; one event each period, of the topics that had any.

    The publishing thread only notes a number and the time. Numbers are exact, whatever the client
    reads, and take the same memory at any rate.
    """

    def __init__(
        self, topics: Iterable[FoundTopic], every_ns: int, now_ns: Callable[[], int]
    ) -> None:
        """Begin to count.

        Args:
            topics: The topics to count.
            every_ns: Time between two events.
            now_ns: The monotonic clock.
        """
        self._now_ns = now_ns
        self._every_ns = every_ns
        self._window_begin_ns = now_ns()
        self.due_ns = self._window_begin_ns + every_ns
        self._topics = [_Counted(topic, now_ns) for topic in topics]
        self.ok = {"topics": {one.name: one.type_name for one in self._topics}}

    def take(self) -> tuple[str, bytes] | None:
        """Return the numbers once the period is over, as JSON: many topics come often."""
        now_ns = self._now_ns()
        assert self.due_ns is not None
        if now_ns < self.due_ns:
            return None
        seconds = (now_ns - self._window_begin_ns) / _NS_PER_S
        self._window_begin_ns = now_ns
        # Late events are left out, not caught up.
        self.due_ns += (1 + (now_ns - self.due_ns) // self._every_ns) * self._every_ns
        found = ",".join([text for one in self._topics if (text := one.take(now_ns))])
        return f'{{"seconds":{seconds:.9f},"topics":{{{found}}}}}', b""

    def close(self) -> None:
        """Count no more."""
        for one in self._topics:
            one.tap.close()


class _Counted:
    """A topic, with the number of its messages so far."""

    def __init__(self, topic: FoundTopic, now_ns: Callable[[], int]) -> None:
        self.name, self.type_name = topic.name, topic.type_name
        self._head = f'{to_json(topic.name)}:{{"count":'
        self._total = 0
        # Numbers and times of the last two messages: two threads that publish at the same moment
        # may note theirs in another order.
        self._newest: deque[tuple[int, int]] = deque([(0, 0)], maxlen=2)
        append, serial = self._newest.append, count(1).__next__

        def note(_message: Any) -> None:
            append((serial(), now_ns()))

        self.tap: Tap = topic.backend.add_tap(topic.name, note)

    def take(self, now_ns: int) -> str:
        """Return the facts of the messages since the last call as JSON; empty without any."""
        total, last_ns = max(self._newest[0], self._newest[-1])
        number = total - self._total
        if number <= 0:
            return ""
        self._total = total
        return f'{self._head}{number},"age_ns":{max(0, now_ns - last_ns)}}}'
