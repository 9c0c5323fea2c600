"""One subscription, from start to stop: tells which messages are frames, and hands them over."""

import threading
from collections import deque

from imu_mqtt.topic_lock import TopicLock
from rosbase import (
    OnFrame,
    Stamper,
    Tally,
    TransportContext,
    TransportError,
    hand_over,
    printable,
)

__all__ = ["MAX_PAYLOAD_BYTES", "Subscription"]

MAX_PAYLOAD_BYTES = 65_536
"""Maximum length of a payload; longer ones are refused. Known IMUs stay under 500 bytes."""

_REMEMBERED = 100
# Of what is read together, so much is kept until all of it is there.
_MOST_KEPT_BYTES = 512 * 1024
_BLANK = b"\0 \t\r\n"
# What another device sends, or once sent, must not hide that ours is silent.
_NO_SIGN_OF_LIFE = frozenset({"bad_topic", "other_topic", "retained"})


class Subscription:
    """Takes messages on the network thread, in the order of their arrival."""

    def __init__(
        self,
        on_frame: OnFrame,
        tally: Tally,
        context: TransportContext,
        stamper: Stamper,
        *,
        is_filter: bool,
    ) -> None:
        """Start with no message seen.

        Args:
            on_frame: Gets the frames.
            tally: Counts everything.
            context: For the log.
            stamper: Stamps the frames.
            is_filter: Whether it has a wildcard. Then the first topic that gives a sample is read,
                until it gives none for the context's `stale_timeout_s`.
        """
        self._on_frame: OnFrame | None = on_frame
        self._tally = tally
        self._context = context
        self._stamper = stamper
        # What was read together, with its topics, until all of it is there.
        self._kept: list[tuple[bytes, str]] = []
        self._kept_bytes = 0
        self._lock = TopicLock(context.stale_timeout_s, context.logger) if is_filter else None
        self._has_named_bad_topic = False
        # Hashes, because a hundred long payloads would be some megabytes.
        self._recent: deque[int] = deque(maxlen=_REMEMBERED)
        # Held while a frame is handed over.
        self._delivering = threading.RLock()
        self._is_answered = threading.Event()
        self._refusal: TransportError | None = None

    def answer(self, refusal: TransportError | None = None) -> bool:
        """Note the broker's answer, or that there is no broker.

        Return whether the subscription may go on: only the first answer counts.
        """
        if self._lock is not None:
            self._lock.begin_anew(self._context.clock.monotonic_ns())
        if self._is_answered.is_set():
            return False
        self._refusal = refusal
        self._is_answered.set()
        return True

    def await_answer(self, timeout_s: float) -> TransportError | None:
        """Wait for the broker's answer; return the reason if it refuses."""
        self._is_answered.wait(timeout_s)
        return self._refusal

    def end(self, timeout_s: float) -> bool:
        """Stop handing over; return whether the last `on_frame` returned in time."""
        self._on_frame = None
        # From within `on_frame` it is held already, by this thread.
        if not self._delivering.acquire(timeout=timeout_s):
            return False
        self._delivering.release()
        return True

    def take(
        self,
        payload: bytes,
        read_ns: int,
        *,
        topic: str,
        retained: bool,
        redelivered: bool,
        fault: str,
        size: int,
    ) -> None:
        """Keep a message until the ones that came with it are there, or count why it is no frame.

        Args:
            payload: Its payload; empty if it was too long to be kept.
            read_ns: The moment of the read, from the stamper, for `deliver`.
            topic: The topic where it was published.
            retained: Whether the broker has kept it from an earlier time.
            redelivered: Whether the broker sends it again, as it says.
            fault: Why it cannot be a frame, if its packet shows that already.
            size: The length of the payload in bytes.
        """
        tally = self._tally
        tally.received_bytes += size
        reason = self._refuses(payload, topic, retained, redelivered, fault, read_ns)
        if reason not in _NO_SIGN_OF_LIFE:
            tally.last_data_ns = read_ns
        if reason:
            tally.count_error(reason)
            return
        self._kept.append((payload, topic))
        self._kept_bytes += len(payload)
        if self._kept_bytes > _MOST_KEPT_BYTES:
            self.deliver(read_ns)

    @property
    def kept(self) -> int:
        """Number of frames that wait for `deliver`."""
        return len(self._kept)

    def deliver(self, read_ns: int) -> None:
        """Stamp the frames that were read together, at that moment, and hand them over."""
        kept, self._kept, self._kept_bytes = self._kept, [], 0
        stamp_ns = self._stamper.one(read_ns) if len(kept) == 1 else None
        if stamp_ns is not None:
            self._hand_over(*kept[0], stamp_ns, read_ns)
        elif kept:
            stamps = self._stamper.many([read_ns] * len(kept))
            for (frame, topic), dated_ns in zip(kept, stamps, strict=True):
                if dated_ns is not None:
                    self._hand_over(frame, topic, dated_ns, read_ns)

    def _hand_over(self, frame: bytes, topic: str, stamp_ns: int, read_ns: int) -> None:
        lock = self._lock
        # A message read together with it may have locked another topic.
        if lock is not None and not lock.admits(topic, read_ns):
            self._tally.count_error("other_topic")
            return
        with self._delivering:
            on_frame = self._on_frame
            if on_frame is None:
                return
            self._tally.frames += 1
            is_sample = hand_over(on_frame, frame, stamp_ns, self._context.logger)
            if is_sample and lock is not None:
                lock.note_sample(topic, read_ns)

    def _refuses(
        self,
        payload: bytes,
        topic: str,
        retained: bool,
        redelivered: bool,
        fault: str,
        now_ns: int,
    ) -> str:
        """Return why a message is no frame, in one word; empty if it is one."""
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
        """Log one such topic. A publisher can invent as many as it likes."""
        if not self._has_named_bad_topic:
            self._has_named_bad_topic = True
            named = printable(topic) or "an empty one"
            self._context.logger.warning(f"dropping messages to a topic MQTT forbids: {named}")
