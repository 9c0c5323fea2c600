"""From a frame to messages: read, check, date, publish. Runs on the transport's reader thread."""

from collections.abc import Iterable

from rosbase.imu.counts import Counts
from rosbase.imu.date_order import DateOrder
from rosbase.imu.mapping import Sample, SampleReader
from rosbase.imu.outlet import Outlet
from rosbase.imu.plausibility import Plausibility
from rosbase.imu.rejects import IGNORED, REASONS, REJECT_LOG_S
from rosbase.imu.settings import ReaderSettings
from rosbase.imu.undated import Undated
from rosbase.logger import RosbaseLogger
from rosbase.mapping.assembly import Batch
from rosbase.mapping.rejects import Reject
from rosbase.mapping.spreading import Spreading

__all__ = ["Pipeline"]


class Pipeline:
    """Publishes the samples in frames, and counts and logs what it drops."""

    def __init__(
        self, settings: ReaderSettings, outlet: Outlet, counts: Counts, logger: RosbaseLogger
    ) -> None:
        """Compiles the mapping and prepares the checks.

        Args:
            settings: Which mapping and which checks.
            outlet: Publishes samples.
            counts: Counts what becomes of each frame.
            logger: Logs what is dropped, at a limited rate.
        """
        self._outlet = outlet
        self._counts = counts
        self._logger = logger
        self._read_sample: SampleReader = settings.mapping.compile(
            device_time=settings.uses_device_time
        )
        self._date_order = DateOrder() if settings.uses_device_time else None
        self._plausibility = None if settings.plausibility == "off" else Plausibility()
        self._refuses_implausible = settings.plausibility == "reject"
        self._spreading = Spreading()
        self._undated = Undated()
        for note in settings.without_effect:
            logger.warning(note)

    @property
    def finding(self) -> str:
        """What is wrong with samples that are published, in one line; empty if nothing."""
        found = self._plausibility.finding if self._plausibility else ""
        return found or self._undated.finding

    def take(self, frame: bytes, stamp_ns: int) -> bool:
        """Publish the samples in a frame; tell whether there are any.

        Args:
            frame: As the transport hands it over.
            stamp_ns: When its first bytes were read, in nanoseconds since the epoch.
        """
        found = self._read_sample(frame)
        if not isinstance(found, Batch):
            return self._pass_on(found, frame, stamp_ns)
        stamps = self._spreading.stamps(len(found.samples), stamp_ns, found.interval_ns)
        passed = [
            self._pass_on(sample, frame, stamp)
            for sample, stamp in zip(found.samples, stamps, strict=True)
        ]
        return any(passed)

    def _pass_on(self, sample: Sample | Reject, frame: bytes, stamp_ns: int) -> bool:
        """Publish one sample of a frame, or drop it."""
        refusal = sample if isinstance(sample, Reject) else self._check(sample, stamp_ns)
        if refusal is not None:
            self._drop(refusal, frame)
            return False
        assert isinstance(sample, Sample)
        if sample.left_out:
            self._note(sample.left_out, frame)
        date_ns = sample.device_time_ns
        if self._outlet.publish(sample, stamp_ns if date_ns is None else date_ns):
            self._counts.published += 1
        else:
            self._counts.add("not_active")
        return True

    def _check(self, sample: Sample, stamp_ns: int) -> Reject | None:
        """Why the sample is to be dropped, if it is."""
        if self._plausibility is not None and sample.linear_acceleration is not None:
            self._plausibility.add(sample.linear_acceleration)
            if self._refuses_implausible and self._plausibility.finding:
                return Reject("implausible", self._plausibility.finding)
        if self._date_order is None or sample.device_time_ns is None:
            return None
        self._undated.add(None)
        return self._date_order.judge(sample, sample.device_time_ns, stamp_ns)

    def _note(self, left_out: Iterable[Reject], frame: bytes) -> None:
        """Count and log what a sample goes out without."""
        for reject in left_out:
            if reject.reason == "time_unusable":
                self._counts.time_unusable += 1
                self._undated.add(reject)
                number = self._counts.time_unusable
            else:
                number = self._counts.leave_out(reject.reason)
            if self._logger.due(f"left out {reject.reason}", REJECT_LOG_S):
                self._logger.warning(f"used only part of {_told(frame, reject, number)}")

    def _drop(self, reject: Reject, frame: bytes) -> None:
        self._counts.add(reject.reason)
        # One line per reason and interval: a noisy line must not become a noisy log.
        if self._logger.due(f"reject {reject.reason}", REJECT_LOG_S):
            number = self._counts.by_reason[reject.reason]
            say = self._logger.info if reject.reason in IGNORED else self._logger.warning
            say(f"dropped {_told(frame, reject, number)}")


def _told(frame: bytes, reject: Reject, number: int) -> str:
    shown = frame if len(frame) <= 80 else frame[:80] + b"..."
    why = reject.detail or REASONS[reject.reason]
    return f"{shown!r}: {reject.reason} ({why}); {number} so far"
