"""Watch a stream of events of one or more programs, such as the messages of a topic."""

from __future__ import annotations

import select

from rosbase.control.client import Stream
from rosbase.control.gathering import connect_to
from rosbase.control.time_limit import TimeLimit
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from typing import Any

__all__ = ["Heard", "Watch"]


class Heard:
    """A message of a topic."""

    __slots__ = ("_schema", "data", "dropped", "pid", "stamp_ns", "type")

    def __init__(
        self, pid: int, answer: dict[str, Any], event: dict[str, Any], data: bytes
    ) -> None:
        self.pid = pid
        """Process that has published or received it."""
        self.type: str = answer["type"]
        """Type of the message, such as `sensor_msgs/msg/Imu`."""
        self._schema: str = answer["schema"]
        self.stamp_ns: int = event["stamp_ns"]
        """When it was published, in nanoseconds since 1970."""
        self.dropped: int = event["dropped"]
        """How many messages this reader has missed so far, because it was too slow."""
        self.data = data
        """The message as CDR."""

    @property
    def message(self) -> dict[str, Any]:
        """The fields of the message by name; messages within it are dicts as well."""
        # A reader of bytes alone needs none of it.
        from rosbase.wire.plain import decoder

        found: dict[str, Any] = decoder(self.type, self._schema)(self.data)
        return found


# Streams end so when their programs end in order, or when all has been said.
_IN_ORDER = ("the program ends", "done")
_LOOK_S = 0.5


class Watch:
    """The events of one request to several programs."""

    def __init__(self, pids: Iterable[int], ask: str, arguments: dict[str, Any]) -> None:
        """Ask each of them.

        Raises:
            ControlError: One refuses, or does not answer.
        """
        self._streams: dict[int, Stream] = {}
        self._poll = select.poll()
        self._faults: list[str] = []
        self._next_look = TimeLimit(0.0)
        self.look: Callable[[], object] | None = None
        """Called twice a second, to `add` programs that start later.

        With it, the events of `pid_events` do not end by themselves.
        """
        try:
            for pid in pids:
                self.add(pid, ask, arguments)
        except BaseException:
            self.close()
            raise

    def add(self, pid: int, ask: str, arguments: dict[str, Any]) -> None:
        """Ask one more program.

        Raises:
            ControlError: It refuses, or does not answer.
        """
        connection = connect_to(pid)
        try:
            stream = Stream(connection, ask, arguments)
        except BaseException:
            connection.close()
            raise
        self._streams[connection.fileno()] = stream
        self._poll.register(connection, select.POLLIN)

    def check_ends(self) -> None:
        """Check that the streams that have ended were complete.

        Raises:
            ControlError: A program was killed or has crashed, or could not go on with its stream.
        """
        if self._faults:
            raise ControlError("; ".join(self._faults), "failed")

    @property
    def streams(self) -> list[Stream]:
        """The streams that have not ended."""
        return list(self._streams.values())

    def close(self) -> None:
        """End all of them."""
        for stream in self._streams.values():
            stream.close()
        self._streams.clear()

    def events(self, timeout_s: float | None) -> Iterator[tuple[Any, bytes]]:
        """Yield the events with the bytes behind them, until all streams or the time end.

        Raises:
            ControlError: As from `check_ends`, at the end.
        """
        for _, event, data in self._events(timeout_s):
            yield event, data
        self.check_ends()

    def pid_events(self) -> Iterator[Any]:
        """Yield the events, each with the `pid` of its program, until all streams end."""
        for stream, event, _ in self._events(None):
            yield {**event, "pid": stream.connection.pid}

    def heard(self, timeout_s: float | None) -> Iterator[Heard]:
        """Yield the messages of a topic, until all streams or the time end.

        Raises:
            ControlError: As from `check_ends`, at the end.
        """
        for stream, event, data in self._events(timeout_s):
            yield Heard(stream.connection.pid, stream.answer, event, data)
        self.check_ends()

    def _events(self, timeout_s: float | None) -> Iterator[tuple[Stream, Any, bytes]]:
        limit = TimeLimit(timeout_s)
        ready = list(self._streams)
        while True:
            for fd in ready:
                stream = self._streams[fd]
                for event, data in stream.events():
                    yield stream, event, data
                    # Messages may come faster than the reader takes them.
                    if limit.is_over:
                        return
                if stream.ended is not None:
                    self._end(fd, stream, stream.ended)
            if not self._streams and self.look is None:
                return
            ready = self._wait(limit)
            # Of messages that came in time, a machine that stalls still passes one on.
            if limit.is_over and not ready:
                return

    def _end(self, fd: int, stream: Stream, reason: str) -> None:
        if reason not in _IN_ORDER:
            pid = str(stream.connection.pid)
            self._faults.append(reason if pid in reason else f"process {pid}: {reason}")
        self._poll.unregister(fd)
        del self._streams[fd]
        stream.close()

    def _wait(self, limit: TimeLimit) -> list[int]:
        """Read what comes next; return the streams that may have events."""
        if self.look is None:
            ready = [fd for fd, _ in self._poll.poll(limit.left_ms)]
        else:
            known = set(self._streams)
            if self._next_look.is_over:
                self._next_look.restart(_LOOK_S)
                self.look()
            found = self._poll.poll(self._next_look.left_ms)
            # Of a new one, events may have come with its answer.
            ready = [fd for fd in self._streams if fd not in known]
            ready += [fd for fd, _ in found if fd in known]
        for fd in ready:
            self._streams[fd].read()
        return ready
