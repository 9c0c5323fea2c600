"""A stream of figures about the messages of a topic: their rate, size and age."""

import math
from collections import deque
from collections.abc import Callable, Sequence, Set
from itertools import count
from operator import mul, sub
from typing import Any

from rosbase.clock import SystemClock
from rosbase.contracts.message_format import MessageFormat
from rosbase.contracts.tap import Tap
from rosbase.control.answers.ends import FoundTopic
from rosbase.control.streams import Stream
from rosbase.errors import ControlError, WireError
from rosbase.messages.fields import is_frozen
from rosbase.wire.schema_text import parse_schema
from rosbase.wire.structure import MessageType

__all__ = ["TopicCount"]

_CLOCK = SystemClock()
_HEADER = "std_msgs/msg/Header"
_NS_PER_S = 1_000_000_000
# Of these, times are kept until the next look.
_MOST_TIMES = 100_000
_MOST_MESSAGES = 1_000
# In short turns, so that the main loop is not kept from Python's lock for long.
_LOOK_NS = 250_000_000
# Messages are kept only as long as they must be.
_LOOK_AT_MESSAGES_NS = 50_000_000


class TopicCount(Stream):
    """Counts messages; one event each period, with the figures of those since the last one.

    The publishing thread only notes the time. The number of messages is exact, whatever the
    client reads.
    """

    def __init__(
        self,
        type_name: str,
        form: MessageFormat | None,
        wanted: Set[str],
        every_ns: int,
        now_ns: Callable[[], int],
    ) -> None:
        """Prepare the stream; `open` begins to count.

        Args:
            type_name: Type of the messages.
            form: Their format; needed for sizes and ages.
            wanted: Figures beside the count: `interval`, `bytes`, `delay`.
            every_ns: Time between two events.
            now_ns: The monotonic clock.

        Raises:
            ControlError: The age of messages without a header is asked for.
        """
        self._now_ns = now_ns
        self._every_ns = every_ns
        self._form = form
        self._times: deque[tuple[int, int]] = deque(maxlen=_MOST_TIMES)
        self._messages: deque[tuple[int, Any]] = deque(maxlen=_MOST_MESSAGES)
        self._serial = count(1).__next__
        self._total = 0
        self._last_ns: int | None = None
        self._window_begin_ns = now_ns()
        self._intervals = _Figures()
        self._sizes = _Figures() if "bytes" in wanted else None
        self._delays = _Figures() if "delay" in wanted else None
        if self._delays is not None:
            _require_header(type_name, form)
        self._counted = 0
        self._event_ns = self._window_begin_ns + every_ns
        self._keeps = self._sizes is not None or self._delays is not None
        self.due_ns = self._next_look(self._window_begin_ns)
        self.ok = {"type": type_name}
        self._tap: Tap | None = None

    def open(self, topic: FoundTopic) -> None:
        """Begin to count on a topic."""
        self._tap = topic.backend.add_tap(
            topic.name, self._keeper() if self._keeps else self._noter()
        )

    def take(self) -> tuple[dict[str, Any], bytes] | None:
        """Return the figures once the period is over."""
        now_ns = self._now_ns()
        self._count()
        self.due_ns = self._next_look(now_ns)
        if now_ns < self._event_ns:
            return None
        event = {"n": self._total, "window": self._window(now_ns)}
        self._intervals.clear()
        self._counted, self._window_begin_ns = 0, now_ns
        # Late events are left out, not caught up.
        self._event_ns += (1 + (now_ns - self._event_ns) // self._every_ns) * self._every_ns
        self.due_ns = self._next_look(now_ns)
        return event, b""

    def close(self) -> None:
        """Count no more."""
        if self._tap is not None:
            self._tap.close()

    # On the threads that publish.

    def _noter(self) -> Callable[[Any], object]:
        append, serial, now_ns = self._times.append, self._serial, self._now_ns

        def note(_message: Any) -> None:
            append((serial(), now_ns()))

        return note

    def _keeper(self) -> Callable[[Any], object]:
        append, serial, now_ns = self._times.append, self._serial, self._now_ns
        keep, frozen = self._messages.append, {bytes: True}

        def note(message: Any) -> None:
            time_ns = now_ns()
            append((serial(), time_ns))
            kind = type(message)
            if kind not in frozen:
                frozen[kind] = is_frozen(kind)
            keep((time_ns, message if frozen[kind] else self._written(message)))

        return note

    # On the thread of the socket.

    def _next_look(self, now_ns: int) -> int:
        patience_ns = _LOOK_AT_MESSAGES_NS if self._keeps else _LOOK_NS
        return min(now_ns + patience_ns, self._event_ns)

    def _count(self) -> None:
        """Count what has come since the last look."""
        take = self._times.popleft
        noted = [take() for _ in range(len(self._times))]
        if noted:
            last = max(noted)[0]
            self._counted, self._total = self._counted + last - self._total, last
            times = [time_ns for _, time_ns in noted]
            if self._last_ns is not None:
                times.insert(0, self._last_ns)
            self._last_ns = times[-1]
            self._intervals.add(list(map(sub, times[1:], times)))
        if self._messages:
            self._measure()

    def _measure(self) -> None:
        """Measure the messages that have come since the last look."""
        take = self._messages.popleft
        kept = [take() for _ in range(len(self._messages))]
        written = [(time_ns, self._written(message)) for time_ns, message in kept]
        found = [(time_ns, data) for time_ns, data in written if data is not None]
        if self._sizes is not None:
            self._sizes.add([len(data) for _, data in found])
        if self._delays is not None:
            offset_ns = _CLOCK.now_ns() - self._now_ns()
            self._delays.add([time_ns + offset_ns - _stamp_ns(data) for time_ns, data in found])

    def _written(self, message: Any) -> bytes | None:
        if isinstance(message, bytes):
            return message
        if message is None or self._form is None:
            return None
        try:
            return self._form.encode(message)
        except (TypeError, ValueError):
            return None

    def _window(self, now_ns: int) -> dict[str, Any]:
        seconds = (now_ns - self._window_begin_ns) / _NS_PER_S
        window: dict[str, Any] = {
            "count": self._counted,
            "seconds": round(seconds, 9),
            **self._intervals.facts("", "_ns"),
        }
        for name, figures in (("bytes", self._sizes), ("delay", self._delays)):
            if figures is not None:
                unit = "" if name == "bytes" else "_ns"
                window |= figures.facts(f"{name}_", unit)
                window[f"{name}_count"] = figures.count
                if name == "bytes":
                    window["bytes"] = figures.total
                figures.clear()
        return window


class _Figures:
    """Least, greatest, mean and standard deviation of whole numbers, none of which is kept."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all numbers."""
        self.count = self.total = self._squares = 0
        self._least: int | None = None
        self._most: int | None = None

    def add(self, numbers: Sequence[int]) -> None:
        """Take some numbers."""
        if not numbers:
            return
        self.count += len(numbers)
        # Whole numbers, so that differences of large sums are exact.
        self.total += sum(numbers)
        self._squares += sum(map(mul, numbers, numbers))
        least, most = min(numbers), max(numbers)
        self._least = least if self._least is None else min(least, self._least)
        self._most = most if self._most is None else max(most, self._most)

    def facts(self, prefix: str, unit: str) -> dict[str, Any]:
        """Return the figures by their names; each is null without a number."""
        mean = std = None
        if self.count:
            mean = self.total / self.count
            std = math.sqrt(self._squares * self.count - self.total**2) / self.count
        return {
            f"{prefix}min{unit}": self._least,
            f"{prefix}max{unit}": self._most,
            f"{prefix}mean{unit}": mean,
            f"{prefix}std{unit}": std,
        }


def _require_header(type_name: str, form: MessageFormat | None) -> None:
    try:
        own = parse_schema(form.type_name, form.schema) if form is not None else None
    except WireError:
        own = None
    first = own.fields[0].element if own is not None and own.fields else None
    if not (isinstance(first, MessageType) and first.name == _HEADER):
        raise ControlError(f"{type_name} has no header, and so no age", "invalid")


def _stamp_ns(data: bytes) -> int:
    """Return the stamp of a message that begins with a header."""
    order = "little" if data[1] else "big"
    sec = int.from_bytes(data[4:8], order, signed=True)  # type: ignore[arg-type]  # one of two
    return sec * _NS_PER_S + int.from_bytes(data[8:12], order)  # type: ignore[arg-type]
