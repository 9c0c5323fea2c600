"""The queue between the threads on which messages arrive and the one that handles them."""

import threading
from collections import deque
from collections.abc import Callable
from typing import Any

__all__ = ["QueuedSubscription"]


class QueuedSubscription:
    """Last messages of a topic, from any thread, waiting for the callback on one."""

    __slots__ = (
        "_callback",
        "_closed",
        "_dropped",
        "_lock",
        "_queue",
        "_schedule",
        "depth",
        "topic",
    )

    def __init__(
        self,
        topic: str,
        callback: Callable[[Any], object],
        depth: int,
        schedule: Callable[[Callable[[], object]], None],
    ) -> None:
        self.topic = topic
        self.depth = depth
        self._callback = callback
        self._queue: deque[Any] = deque(maxlen=depth)
        self._schedule = schedule
        # Guards the queue together with the count; held for a few instructions.
        self._lock = threading.Lock()
        self._dropped = 0
        self._closed = False

    @property
    def dropped(self) -> int:
        """Number of messages lost because the callback was slower than the publisher."""
        return self._dropped

    def deliver(self, message: Any) -> None:
        """Queue a message, from any thread; drop the oldest if the queue is full."""
        with self._lock:
            needs_call = self._put(message)
        if needs_call:
            self._schedule(self.handle_one)

    def _put(self, message: Any) -> bool:
        """Queue a message, with the lock held; return whether it needs a call of `handle_one`."""
        if self._closed:
            return False
        queue = self._queue
        # One call is under way for each message in the queue, so a full queue needs no more.
        is_full = len(queue) == queue.maxlen
        if is_full:
            self._dropped += 1
        queue.append(message)
        return not is_full

    def handle_one(self) -> None:
        """Call the callback with the oldest message. For the spinning thread."""
        with self._lock:
            if self._closed or not self._queue:
                return
            message = self._queue.popleft()
        self._callback(message)

    def resize(self, depth: int) -> None:
        """Keep the last `depth` messages from now on."""
        with self._lock:
            self.depth = depth
            self._queue = deque(self._queue, maxlen=depth)

    def close(self) -> None:
        """Stop calling the callback."""
        with self._lock:
            self._closed = True
            self._queue.clear()
