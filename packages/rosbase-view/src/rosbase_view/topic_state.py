"""A topic as it is known: its rate, the age of its last message, and its recent past."""

from collections import deque

from rosbase.control.shapes import Topic
from rosbase_view.drawing.sparkline import Sparkline

__all__ = ["TopicState"]

_NS = 1_000_000_000
# A rate is of as many messages as that, of a second at least and of ten seconds at most.
_ENOUGH = 5
_LEAST_S, _MOST_S = 1.0, 10.0
# A bar of the sparkline.
_BAR_S = 0.5


class TopicState:
    """What is known of a topic. Its row is drawn anew only if `revision` or its age has changed."""

    def __init__(self, topic: Topic) -> None:
        """Begin with no messages."""
        self.topic = topic
        self.sparkline = Sparkline()
        self.total = 0
        """Messages since the view began."""
        self.revision = 0
        """Grows with each change."""
        self._windows: deque[tuple[int, float]] = deque()
        self._seconds = 0.0
        self._last_ns: int | None = None
        self._bar_count, self._bar_s = 0, 0.0

    def learn(self, topic: Topic) -> None:
        """Take what a survey has found of the topic."""
        if topic != self.topic:
            self.topic = topic
            self.revision += 1

    def count(self, count: int, seconds: float, now_ns: int) -> None:
        """Take the number of messages in some seconds that have just ended."""
        self.total += count
        if count:
            self._last_ns = now_ns
        if count or any(number for number, _ in self._windows):
            self.revision += 1
        self._windows.append((count, seconds))
        self._seconds += seconds
        while self._windows and self._seconds - self._windows[0][1] >= _MOST_S:
            self._seconds -= self._windows.popleft()[1]
        self._bar_count, self._bar_s = self._bar_count + count, self._bar_s + seconds
        if self._bar_s >= _BAR_S:
            self.sparkline.add(self._bar_count / self._bar_s)
            self._bar_count, self._bar_s = 0, 0.0

    @property
    def rate_hz(self) -> float | None:
        """Messages a second; None until something was counted."""
        count, total_s = 0, 0.0
        for number, seconds in reversed(self._windows):
            if total_s >= _LEAST_S and count >= _ENOUGH:
                break
            count, total_s = count + number, total_s + seconds
        return count / total_s if total_s > 0.0 else None

    def age_ns(self, now_ns: int) -> int | None:
        """Return the time since the last message; None if none has come."""
        return None if self._last_ns is None else max(0, now_ns - self._last_ns)

    @property
    def dropped(self) -> int:
        """Messages that subscriptions have lost."""
        return sum(end.get("dropped") or 0 for end in self.topic["subscriptions"])
