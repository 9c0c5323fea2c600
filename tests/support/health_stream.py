"""What a device sends in virtual time, and what a watch over the reader's health says meanwhile."""

from collections.abc import Callable, Iterable, Iterator
from heapq import merge
from typing import NamedTuple

from rosbase.contracts.transport import TransportHealth, TransportState
from rosbase.imu.counts import Counts
from rosbase.imu.health import Health, HealthLevel
from rosbase.imu.health_watch import HealthWatch
from rosbase.imu.rejects import NO_SIGN_OF_LIFE

__all__ = ["LOOK_S", "SAMPLE", "Event", "Said", "bytes_of", "every", "levels", "watch"]

SAMPLE = "a sample"
LOOK_S = 0.25


class Event(NamedTuple):
    """Something that arrives: a sample, a frame that is refused with a reason, or bytes."""

    at_s: float
    what: str
    pending_bytes: int = 0


class Said(NamedTuple):
    """What was said, and when."""

    at_s: float
    health: Health


def every(
    what: str | Callable[[int], str], rate_hz: float, begin_s: float, end_s: float
) -> Iterator[Event]:
    """Arrivals at a rate; what each of them is may depend on its number."""
    number = 0
    while (at_s := begin_s + number / rate_hz) < end_s:
        yield Event(at_s, what if isinstance(what, str) else what(number))
        number += 1


def bytes_of(count: int, rate_hz: float, begin_s: float, end_s: float) -> Iterator[Event]:
    """Bytes that end no frame, so many at a time."""
    for number, event in enumerate(every("", rate_hz, begin_s, end_s), start=1):
        yield event._replace(pending_bytes=number * count)


def watch(
    *streams: Iterable[Event],
    until_s: float,
    stale_timeout_s: float = 1.0,
    offset_s: float = LOOK_S,
    finding: str = "",
    lost: tuple[float, float] = (0.0, 0.0),
) -> list[Said]:
    """What each look says, beginning with the activation at 0.

    Args:
        streams: What arrives.
        until_s: When it is over.
        stale_timeout_s: The parameter.
        offset_s: When the first look is.
        finding: What is wrong with samples.
        lost: From when to when the device is away.
    """
    counts, clock = Counts(), 1_000_000_000_000
    events = list(merge(*streams))
    watching = HealthWatch(stale_timeout_s, clock, counts.snapshot({}))
    said: list[Said] = []
    last_ns, pending, at = None, 0, 0
    for look in range(int((until_s - offset_s) / LOOK_S) + 1):
        now_s = offset_s + look * LOOK_S
        while at < len(events) and events[at].at_s <= now_s:
            arrived_s, what, pending = events[at]
            if what not in NO_SIGN_OF_LIFE:
                last_ns = clock + round(arrived_s * 1e9)
            if what == SAMPLE:
                counts.published += 1
            elif what:
                counts.add(what)
            at += 1
        is_lost = lost[0] <= now_s < lost[1]
        transport = TransportHealth(
            TransportState.RECONNECTING if is_lost else TransportState.CONNECTED,
            last_data_ns=last_ns,
            last_error="/dev/imu is not there" if is_lost else "",
            pending_bytes=pending,
        )
        now_ns = clock + round(now_s * 1e9)
        said.append(Said(now_s, watching.look(now_ns, counts.snapshot({}), transport, finding)))
    return said


def levels(said: Iterable[Said]) -> list[HealthLevel]:
    """The levels, each change once."""
    changes: list[HealthLevel] = []
    for _, health in said:
        if not changes or changes[-1] is not health.level:
            changes.append(health.level)
    return changes
