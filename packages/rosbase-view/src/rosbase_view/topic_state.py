"""A topic as it is known: its rate, the age of its last message, and its recent past."""

from collections import deque

from rosbase.control.shapes import Topic
from rosbase_view.drawing.sparkline import Sparkline

__all__ = ["TopicState"]

_NS = 1_000_000_000
# A rate is of as many messages as that, of two seconds at least and of ten seconds at most.
_ENOUGH = 5
_LEAST_NS, _MOST_NS = 2 * _NS, 10 * _NS
# A topic whose message is late by as many periods has fallen silent.
_LATE = 2.5
# A bar of the sparkline.
_BAR_S = 0.5


class TopicState:
    """The known facts about a topic."""

    def __init__(self, topic: Topic) -> None:
        """Begin with no messages."""
        self.topic = topic
        self.sparkline = Sparkline()
        self.total = 0
        """Messages since the view began."""
        # Times of some messages, and how many there were until then.
        self._points: deque[tuple[int, int]] = deque()
        self._bar_count, self._bar_s = 0, 0.0

    def restart(self) -> None:
        """Forget all messages."""
        self.total, self.sparkline = 0, Sparkline()
        self._points.clear()
        self._bar_count, self._bar_s = 0, 0.0

    def learn(self, topic: Topic) -> None:
        """Take what a survey has found of the topic."""
        self.topic = topic

    def count(self, count: int, seconds: float, last_ns: int, now_ns: int) -> None:
        """Take the number of messages in some seconds that have just ended.

        Args:
            count: How many there were.
            seconds: Length of the window.
            last_ns: Monotonic time of the last one, if there was any.
            now_ns: Monotonic time.
        """
        self.total += count
        if count:
            self._points.append((last_ns, self.total))
        # The last one stays, for the age.
        while len(self._points) > 1 and now_ns - self._points[0][0] > _MOST_NS:
            self._points.popleft()
        self._bar_count, self._bar_s = self._bar_count + count, self._bar_s + seconds
        if self._bar_s >= _BAR_S:
            self.sparkline.add(self._bar_count / self._bar_s)
            self._bar_count, self._bar_s = 0, 0.0

    def rate_hz(self, now_ns: int) -> float | None:
        """Return the messages a second, from the times of messages; None if there was only one.

        It is 0 once the next message is late: a mean that falls slowly tells of no rate that was.
        """
        if len(self._points) < 2:
            return None if self.total == 0 or not self._is_silent(now_ns, _MOST_NS) else 0.0
        last_ns, total = self._points[-1]
        for first_ns, before in reversed(self._points):
            if last_ns - first_ns >= _LEAST_NS and total - before >= _ENOUGH:
                break
        passed_ns = last_ns - first_ns
        period_ns = passed_ns / (total - before) if total > before else 0.0
        if self._is_silent(now_ns, _LATE * period_ns + _BAR_S * _NS):
            return 0.0
        return (total - before) * _NS / passed_ns if passed_ns > 0 else None

    def age_ns(self, now_ns: int) -> int | None:
        """Return the time since the last message; None if none has come."""
        return max(0, now_ns - self._points[-1][0]) if self._points else None

    @property
    def dropped(self) -> int:
        """Messages that subscriptions have lost."""
        return sum(end.get("dropped") or 0 for end in self.topic["subscriptions"])

    def _is_silent(self, now_ns: int, limit_ns: float) -> bool:
        return bool(self._points) and now_ns - self._points[-1][0] > limit_ns
