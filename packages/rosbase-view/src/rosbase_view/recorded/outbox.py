"""Messages that were played and not taken yet: bounded, however slow the view is."""

from collections import deque
from collections.abc import Iterable, Sequence

from rosbase.control.shapes import LogRecord
from rosbase_view.known import MOST_RECORDS
from rosbase_view.recorded.past import Window
from rosbase_view.reports import Counted, Heard, Logged, Report, TopicKey
from rosbase_view.source import Gaze, Pace

__all__ = ["Outbox"]

_MOST_MESSAGES = 2_000
_MOST_BYTES = 16 * 1024 * 1024


class Outbox:
    """Keeps messages and counts. Nothing is lost: when it is full, the player waits."""

    def __init__(self, topics: Iterable[TopicKey]) -> None:
        """Begin empty.

        Args:
            topics: Topics whose messages are counted.
        """
        self.gaze = Gaze()
        """Topics and nodes that the user looks at."""
        self._heard: list[Heard] = []
        self._bytes = 0
        self._counts = dict.fromkeys(topics, 0)
        self._last_ns = dict.fromkeys(self._counts, 0)
        self._past: Sequence[tuple[TopicKey, Window]] = ()
        self._records: deque[LogRecord] = deque(maxlen=MOST_RECORDS)
        self._is_first = False

    @property
    def is_full(self) -> bool:
        """Whether the player should wait."""
        return len(self._heard) >= _MOST_MESSAGES or self._bytes >= _MOST_BYTES

    def add(self, heard: Heard) -> None:
        """Take a message, and count it."""
        self._counts[heard.topic] += 1
        self._last_ns[heard.topic] = heard.stamp_ns or 0
        self.show(heard)

    def show(self, heard: Heard) -> None:
        """Take a message that was there before, so it is not counted."""
        if heard.topic not in self.gaze.topics:
            return
        if self.gaze.pace is Pace.NEWEST:
            self._keep(one for one in self._heard if one.topic != heard.topic)
        self._heard.append(heard)
        self._bytes += len(heard.data)

    def clear(self) -> None:
        """Forget the messages: they are of a time that is left."""
        self._keep(())
        self._counts = dict.fromkeys(self._counts, 0)
        self._past = ()
        self._records.clear()

    def begin(self, past: Sequence[tuple[TopicKey, Window]]) -> None:
        """Take what was before the time from which it is played on."""
        self._past, self._is_first = past, True

    def add_record(self, record: LogRecord) -> None:
        """Take a record of the log."""
        self._records.append(record)

    def take_past(self, now_ns: int) -> Sequence[Report]:
        """Return what was before, and the log.

        Args:
            now_ns: Where the recording is.
        """
        known: set[TopicKey] = set()
        found: list[Report] = []
        for topic, one in self._past:
            age_s = max(0, now_ns - one.last_ns) / 1e9
            is_first = topic not in known
            found.append(Counted(topic, one.count, one.seconds, age_s, is_first=is_first))
            known.add(topic)
        if self._records or self._is_first:
            found.append(Logged(list(self._records), is_first=self._is_first))
        self._past, self._is_first = (), False
        self._records.clear()
        return found

    def take_heard(self) -> Sequence[Heard]:
        """Return the messages."""
        heard = self._heard
        self._keep(())
        return heard

    def take_counts(self, now_ns: int, seconds: float) -> Sequence[Counted]:
        """Return how many messages there were.

        Args:
            now_ns: Where the recording is.
            seconds: How much of it was played since the last call.
        """
        found = [
            Counted(topic, count, seconds, max(0, now_ns - self._last_ns[topic]) / 1e9)
            for topic, count in self._counts.items()
        ]
        self._counts = dict.fromkeys(self._counts, 0)
        return found

    def _keep(self, messages: Iterable[Heard]) -> None:
        self._heard = list(messages)
        self._bytes = sum(len(one.data) for one in self._heard)
