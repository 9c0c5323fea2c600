"""The seconds before a time of a recording, so that a jump shows the rates and the log of then."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator

from attrs import frozen

from rosbase_view.recorded.recording import RecordedMessage, Recording

__all__ = ["SPAN_S", "Past", "Window", "read_past"]

SPAN_S = 5
"""Seconds that are read. A recording of cameras has hundreds of megabytes in them."""

_WINDOW_S = 0.5
_WINDOW_NS = int(_WINDOW_S * 1e9)
_WINDOWS = int(SPAN_S / _WINDOW_S)
# `is_left` is asked after so many messages.
_SOME = 100


@frozen
class Window:
    """Messages of a topic in a part of the past."""

    topic: str
    count: int
    seconds: float
    last_ns: int
    """When the last one was recorded; 0 if there is none."""


@frozen
class Past:
    """The windows, oldest first, and the messages of the log."""

    windows: tuple[Window, ...]
    log: tuple[RecordedMessage, ...]


def read_past(
    recording: Recording,
    to_ns: int,
    latest: Iterable[RecordedMessage],
    is_log: Callable[[str], bool],
    is_left: Callable[[], bool],
) -> Past | None:
    """Return the past of a time; None if the reader has left for another time.

    Args:
        recording: The recording.
        to_ns: The time.
        latest: The last message of each topic before it.
        is_log: Returns whether a topic is the log.
        is_left: Returns whether the past is not needed any more.
    """
    from_ns = to_ns - _WINDOWS * _WINDOW_NS
    counts: Counter[tuple[str, int]] = Counter()
    last_ns: dict[tuple[str, int], int] = {}
    log: list[RecordedMessage] = []
    for number, message in enumerate(_between(recording, from_ns, to_ns)):
        if number % _SOME == 0 and is_left():
            return None
        key = message.topic, (message.stamp_ns - from_ns) // _WINDOW_NS
        counts[key] += 1
        last_ns[key] = message.stamp_ns
        if is_log(message.topic):
            log.append(message)
    windows = [
        Window(
            topic.name, counts[topic.name, number], _WINDOW_S, last_ns.get((topic.name, number), 0)
        )
        for topic in recording.topics
        for number in range(_WINDOWS)
    ]
    # Such as a map that was published once; the last seconds' are counted above.
    old = [Window(one.topic, 1, 0.0, one.stamp_ns) for one in latest if one.stamp_ns < from_ns]
    return Past((*old, *windows), tuple(log))


def _between(recording: Recording, from_ns: int, to_ns: int) -> Iterator[RecordedMessage]:
    for message in recording.messages(from_ns):
        if message.stamp_ns >= to_ns:
            return
        yield message
