"""Choose which of the topics under a wildcard is read. Pure: the caller gives the time."""

from rosbase import RosbaseLogger, printable

__all__ = ["LEAST_TIMEOUT_S", "TopicLock"]

LEAST_TIMEOUT_S = 1.0
"""Minimum time to hold the lock without a sample, because networks stall."""

_LOG_S = 60.0


class TopicLock:
    """Holds on to the first topic that gives a sample, so that samples of two devices do not mix.

    It lets go when another topic has a message and its own topic has given no sample for the
    timeout. Then it holds the topic that gives the next sample, the same or another.
    """

    def __init__(self, timeout_s: float, logger: RosbaseLogger) -> None:
        """Start with no topic held.

        Args:
            timeout_s: Seconds without a sample after which the lock lets go; a second at least.
            logger: Logs which topic is read.
        """
        self._timeout_s = max(timeout_s, LEAST_TIMEOUT_S)
        self._logger = logger
        self._held: str | None = None
        self._sample_ns = 0
        # What is let go and held again and again is not said each time.
        self._says = True

    def admits(self, topic: str, now_ns: int) -> bool:
        """Return whether a message of the topic may be handed over."""
        held = self._held
        if held is None or topic == held:
            return True
        passed_s = (now_ns - self._sample_ns) / 1e9
        if passed_s <= self._timeout_s:
            return False
        self._held = None
        self._says = self._logger.due(f"let go of {held}", _LOG_S)
        if self._says:
            self._logger.warning(
                f"no sample from {printable(held)} for {passed_s:.1f} s:"
                " the next topic that gives one is read"
            )
        return True

    def note_sample(self, topic: str, now_ns: int) -> None:
        """Hold on to the topic, which gave a sample."""
        self._sample_ns = now_ns
        if self._held is None:
            self._held = topic
            if self._says:
                self._logger.info(f"reading {printable(topic)}")

    def begin_anew(self, now_ns: int) -> None:
        """Restart the time without a sample, because there was no connection before."""
        self._sample_ns = now_ns
