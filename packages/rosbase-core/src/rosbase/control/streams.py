"""Streams of events that follow an answer, taken only as fast as the client reads them."""

from collections.abc import Callable
from typing import Any

__all__ = ["Stream"]


class Stream:
    """Base class of streams. An answerer returns one, and the socket's thread takes its events.

    A stream holds what waits, and bounds it: the session calls `take` only while the client
    reads. So a client that stops reading costs what the stream holds, and no more. Whatever the
    stream leaves out, it counts in `dropped`.

    On other threads a stream does as little as it can, such as appending to a bounded deque and
    calling `wake`.
    """

    ok: dict[str, Any]
    """Answer of the request, before the first event. Set it in the constructor."""
    data: bytes = b""
    """Bytes behind the answer."""
    dropped = 0
    """Number of events that were lost, because the client did not read them."""
    due_ns: int | None = None
    """Instant on the monotonic clock at which `take` is called even if nobody wakes the stream.

    Only the socket's thread sets it: in the constructor and in `take`.
    """
    ended = ""
    """Reason of the end; empty while there may be more events."""
    _is_woken = False
    _wake: Callable[["Stream"], object] | None = None

    def take(self) -> tuple[dict[str, Any] | str, bytes] | None:
        """Return the next event and the bytes behind it; None if there is none now.

        An event that is a text is JSON already, of ASCII alone and without a line end.

        Called on the thread of the socket: after `wake`, at `due_ns`, and again until it returns
        None or the client stops reading.
        """
        return None

    def close(self) -> None:
        """Release what the stream holds, such as a tap. Called once, on the socket's thread."""

    def wake(self) -> None:
        """Have `take` called soon. Call it from any thread.

        The thread of the socket is woken once, however often this is called before it comes.
        Waking a thread costs some ten microseconds of a processor. A stream of many events sets
        `due_ns` in `take` instead, and calls this only while that is None.
        """
        if not self._is_woken and self._wake is not None:
            self._is_woken = True
            self._wake(self)

    def end(self, reason: str) -> None:
        """End the stream when `take` has returned None. Call it from any thread."""
        self.ended = reason
        self.wake()
