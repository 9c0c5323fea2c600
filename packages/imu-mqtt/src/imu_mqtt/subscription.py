"""One subscription, from start to stop: which messages are frames, and handing those over."""

import threading
from collections import deque

from imu_mqtt.topic_lock import TopicLock
from rosbase import OnFrame, Tally, TransportContext, TransportError, hand_over, printable

__all__ = ["MAX_PAYLOAD_BYTES", "Subscription"]

MAX_PAYLOAD_BYTES = 65_536
"""Longer payloads are refused. Known IMUs stay under 500 bytes."""

_REMEMBERED = 100
_BLANK = b"\0 \t\r\n"
# What another device sends, or once sent, must not hide that ours is silent.
_NO_SIGN_OF_LIFE = frozenset({"bad_topic", "other_topic", "retained"})


class Subscription:
    """Takes messages on the network thread, in the order of their arrival."""

    def __init__(
        self, on_frame: OnFrame, tally: Tally, context: TransportContext, *, is_filter: bool
    ) -> None:
        """Begins with no message seen.

        Args:
            on_frame: Gets the frames.
            tally: Where everything is counted.
            context: For the log.
            is_filter: Whether it has a wildcard. Of several topics the first that gives a sample
                is read, until it gives none for the context's `stale_timeout_s`.
        """
        self._on_frame: OnFrame | None = on_frame
        self._tally = tally
        self._context = context
        self._lock = TopicLock(context.stale_timeout_s, context.logger) if is_filter else None
        self._has_named_bad_topic = False
        # Hashes, because a hundred long payloads would be some megabytes.
        self._recent: deque[int] = deque(maxlen=_REMEMBERED)
        # Held while a frame is handed over.
        self._delivering = threading.RLock()
        self._is_answered = threading.Event()
        self._refusal: TransportError | None = None

    def answer(self, refusal: TransportError | None = None) -> bool:
        """Notes what the broker has said, or that nobody is there to say anything.

        Tells whether somebody may listen: only the first answer counts.
        """
        if self._lock is not None:
            self._lock.begin_anew(self._context.clock.monotonic_ns())
        if self._is_answered.is_set():
            return False
        self._refusal = refusal
        self._is_answered.set()
        return True

    def await_answer(self, timeout_s: float) -> TransportError | None:
        """Waits for the broker's answer; gives why it refuses, if it does."""
        self._is_answered.wait(timeout_s)
        return self._refusal

    def end(self, timeout_s: float) -> bool:
        """Hands over no more; tells whether the last `on_frame` returned in time."""
        self._on_frame = None
        # From within `on_frame` it is held already, by this thread.
        if not self._delivering.acquire(timeout=timeout_s):
            return False
        self._delivering.release()
        return True

    def take(
        self,
        payload: bytes,
        stamp_ns: int,
        *,
        topic: str,
        retained: bool,
        redelivered: bool,
        fault: str,
        size: int,
    ) -> None:
        """Hand a message over, or count why it is no frame.

        Args:
            payload: What is in it; empty if it was too long to be kept.
            stamp_ns: When it could be read.
            topic: Where it was published.
            retained: Whether the broker has kept it from an earlier time.
            redelivered: Whether the broker says that it sends it again.
            fault: Why it cannot be a frame, if its packet says so already.
            size: How many bytes the payload had.
        """
        tally = self._tally
        tally.received_bytes += size
        now_ns = self._context.clock.monotonic_ns()
        reason = self._refuses(payload, topic, retained, redelivered, fault, now_ns)
        if reason not in _NO_SIGN_OF_LIFE:
            tally.last_data_ns = now_ns
        if reason:
            tally.count_error(reason)
            return
        with self._delivering:
            on_frame = self._on_frame
            if on_frame is None:
                return
            tally.frames += 1
            is_sample = hand_over(on_frame, payload, stamp_ns, self._context.logger)
            if is_sample and self._lock is not None:
                self._lock.note_sample(topic, now_ns)

    def _refuses(
        self,
        payload: bytes,
        topic: str,
        retained: bool,
        redelivered: bool,
        fault: str,
        now_ns: int,
    ) -> str:
        """Why a message is no frame, in one word; empty if it is one."""
        if fault == "bad_topic":
            self._name_bad_topic(topic)
            return fault
        if self._lock is not None and not self._lock.admits(topic, now_ns):
            return "other_topic"
        if retained:
            # It was sent before anybody asked, nobody knows when.
            return "retained"
        if fault:
            return fault
        if not payload.strip(_BLANK):
            return "empty"
        if len(payload) > MAX_PAYLOAD_BYTES:
            return "overlong"
        digest = hash(payload)
        if redelivered and digest in self._recent:
            return "duplicate"
        self._recent.append(digest)
        return ""

    def _name_bad_topic(self, topic: str) -> None:
        """Log one such topic. Whoever may publish can invent as many as they like."""
        if not self._has_named_bad_topic:
            self._has_named_bad_topic = True
            named = printable(topic) or "an empty one"
            self._context.logger.warning(f"dropping messages to a topic MQTT forbids: {named}")
