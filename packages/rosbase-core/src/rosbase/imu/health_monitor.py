"""Monitor the health of an active reader, and log its changes."""

from collections.abc import Callable, Mapping

from rosbase.clock import Clock
from rosbase.contracts.transport import Transport
from rosbase.imu.counts import Counts, CountsSnapshot
from rosbase.imu.health import Health, HealthLevel
from rosbase.imu.health_watch import HealthWatch
from rosbase.imu.rejects import IGNORED, REJECT_LOG_S, SAID_BEFORE
from rosbase.logger import RosbaseLogger

__all__ = ["HealthMonitor"]


class HealthMonitor:
    """Watches a reader from activation to deactivation, on the main-loop thread."""

    def __init__(
        self,
        transport: Transport,
        counts: Counts,
        finding: Callable[[], str],
        stale_timeout_s: float,
        clock: Clock,
        logger: RosbaseLogger,
        explain: Callable[[str], str],
    ) -> None:
        """Start; call it before the transport is started.

        Args:
            transport: Source of the frames.
            counts: Counts of the frames.
            finding: Returns the fault of the published samples.
            stale_timeout_s: Seconds without a sample after which the health is not OK.
            clock: Clock of the checks.
            logger: Logs each change, and the data that the transport could not frame.
            explain: Returns the explanation of a reason.
        """
        self._transport = transport
        self._counts = counts
        self._finding = finding
        self._clock = clock
        self._logger = logger
        self._explain = explain
        self._said: dict[str, int] = dict(transport.health.frame_errors)
        begun = counts.snapshot(self._said)
        self._watch = HealthWatch(stale_timeout_s, clock.monotonic_ns(), begun, explain)
        self.health = Health(HealthLevel.OK, "waiting for the first sample")
        """Health at the last check."""

    def look(self) -> None:
        """Judge the health now, and log it if its message has changed."""
        transport = self._transport.health
        counts = self._counts.snapshot(transport.frame_errors)
        unended = self._watch.unended
        health = self._watch.look(self._clock.monotonic_ns(), counts, transport, self._finding())
        self._say_frame_errors(transport.frame_errors, counts)
        if self._watch.unended > unended:
            self._counts.add("unended")
            number = self._counts.by_reason["unended"]
            self._say("unended", f"no frame in the last {transport.pending_bytes} bytes", number)
        if not health.says_the_same_as(self.health):
            say = {
                HealthLevel.OK: self._logger.info,
                HealthLevel.WARN: self._logger.warning,
                HealthLevel.ERROR: self._logger.error,
            }[health.level]
            say(f"health {health.level.name}: {health.message}")
        self.health = health

    def _say_frame_errors(self, errors: Mapping[str, int], counts: CountsSnapshot) -> None:
        """Log the data that the transport has dropped; the pipeline logs its own drops."""
        for reason, number in errors.items():
            if reason in SAID_BEFORE:
                continue
            dropped = number - self._said.get(reason, 0)
            frames = "frame" if dropped == 1 else "frames"
            if dropped and self._say(
                reason, f"dropped {dropped} {frames}", counts.by_reason[reason]
            ):
                self._said[reason] = number

    def _say(self, reason: str, what: str, number: int) -> bool:
        """Log the message, unless its reason has just been logged; return whether it was logged."""
        if not self._logger.due(f"reject {reason}", REJECT_LOG_S):
            return False
        known = self._explain(reason)
        why = f" ({known})" if known else ""
        say = self._logger.info if reason in IGNORED else self._logger.warning
        say(f"{what}: {reason}{why}; {number} so far")
        return True
