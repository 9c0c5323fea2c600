"""From a frame to messages: read, check, date, publish. Runs on the transport's reader thread."""

from collections.abc import Iterable

from rosbase.imu.checks.checksum import NO_CHECKSUM, compile_checksum, verified
from rosbase.imu.checks.device_clock import DeviceClock
from rosbase.imu.checks.device_dates import DeviceDates
from rosbase.imu.checks.never_there import NeverThere
from rosbase.imu.checks.suite import Checks, CheckSettings
from rosbase.imu.checks.undated import Undated
from rosbase.imu.counts import Counts
from rosbase.imu.diagnosis.explanations import Explanations
from rosbase.imu.diagnosis.payload import mapped_by
from rosbase.imu.mapping import Sample, SampleReader
from rosbase.imu.outlet import Outlet
from rosbase.imu.rejects import REJECT_LOG_S
from rosbase.imu.settings import ReaderSettings
from rosbase.logger import RosbaseLogger
from rosbase.mapping.assembly import Batch
from rosbase.mapping.rejects import Reject
from rosbase.mapping.spreading import Spreading

__all__ = ["Pipeline"]

_LONGEST_SHOWN = 80


class Pipeline:
    """Publishes the samples in frames, and counts and logs dropped ones."""

    def __init__(
        self, settings: ReaderSettings, outlet: Outlet, counts: Counts, logger: RosbaseLogger
    ) -> None:
        """Compile the mapping and prepare the checks.

        Args:
            settings: Mapping and checks.
            outlet: Publishes samples, and counts them.
            counts: Counts the frames that are dropped.
            logger: Logs dropped samples, at a limited rate.
        """
        self._outlet = outlet
        self._counts = counts
        self._logger = logger
        self._read_sample = _sample_reader(settings)
        self._checks = Checks(settings.checks, settings.mapping)
        self._judge = self._checks.judge
        self._dates = _dates(settings.checks) if settings.uses_device_time else None
        self._undated = Undated()
        self._spreading = Spreading()
        self._explanations = Explanations(settings.transport.hints, mapped_by(settings.mapping))
        self._never_there = NeverThere(settings.asked_for)

    def redirect(self, outlet: Outlet) -> None:
        """Publish samples through another outlet from now on. Call it from any thread."""
        self._outlet = outlet

    @property
    def finding(self) -> str:
        """Fault of the published samples, in one line; empty if none."""
        of_dates = self._dates.finding if self._dates else ""
        found = (self._checks.finding, of_dates, self._undated.finding)
        return "; ".join([finding for finding in found if finding])

    def explain(self, reason: str) -> str:
        """Return the explanation of a reason for which frames are refused."""
        return self._explanations.of(reason)

    def take(self, frame: bytes, stamp_ns: int) -> bool:
        """Publish the samples in a frame; return whether there are any.

        Args:
            frame: The frame, from the transport.
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
        if isinstance(sample, Reject):
            self._drop(sample, frame)
            return False
        refusal = self._judge(sample, stamp_ns)
        if refusal is None and self._dates is not None:
            stamp_ns, refusal = self._date(self._dates, sample, frame, stamp_ns)
        if refusal is not None:
            self._drop(refusal, frame)
            return False
        if sample.left_out:
            self._note(sample.left_out, frame)
        if self._never_there.is_waiting:
            self._name_missing(sample, frame)
        self._outlet.publish(sample, stamp_ns)
        return True

    def _date(
        self, dates: DeviceDates, sample: Sample, frame: bytes, arrived_ns: int
    ) -> tuple[int, Reject | None]:
        """Return the stamp of a sample, and the reason if it must be dropped."""
        verdict = dates.judge(sample, arrived_ns)
        if verdict is None:
            return arrived_ns, None
        if isinstance(verdict, int):
            self._undated.add(None)
            return verdict, None
        if verdict.reason != "time_unusable":
            return arrived_ns, verdict
        self._note((verdict,), frame)
        return arrived_ns, None

    def _note(self, left_out: Iterable[Reject], frame: bytes) -> None:
        """Count and log the quantities that a sample leaves out."""
        for reject in left_out:
            if reject.reason == "time_unusable":
                self._counts.time_unusable += 1
                self._undated.add(reject)
                number = self._counts.time_unusable
            else:
                number = self._counts.leave_out(reject.reason)
            if self._logger.due(f"left out {reject.reason}", REJECT_LOG_S):
                why = self._explanations.explain(reject, frame).text
                self._logger.warning(f"used only part of {_told(frame, reject, why, number)}")

    def _name_missing(self, sample: Sample, frame: bytes) -> None:
        for quantity in self._never_there.add(sample):
            why = self._explanations.explain(Reject("missing_group", quantity), frame).text
            self._logger.warning(f"{quantity} is mapped, but no sample has had it: {why}")

    def _drop(self, reject: Reject, frame: bytes) -> None:
        self._counts.add(reject.reason)
        # One line per reason and interval: a noisy line must not become a noisy log.
        if self._logger.due(f"reject {reject.reason}", REJECT_LOG_S):
            cause = self._explanations.explain(reject, frame)
            number = self._counts.by_reason[reject.reason]
            say = self._logger.info if cause.is_harmless else self._logger.warning
            say(f"dropped {_told(frame, reject, cause.text, number)}")


def _told(frame: bytes, reject: Reject, why: str, number: int) -> str:
    shown = frame if len(frame) <= _LONGEST_SHOWN else frame[:_LONGEST_SHOWN] + b"..."
    return f"{shown!r}: {reject.reason} ({why}); {number} so far"


def _sample_reader(settings: ReaderSettings) -> SampleReader:
    read = settings.mapping.compile(device_time=settings.uses_device_time)
    checks = settings.checks
    if checks.checksum == NO_CHECKSUM:
        return read
    return verified(compile_checksum(checks.checksum, checks.checksum_separator), read)


def _dates(settings: CheckSettings) -> DeviceDates:
    if settings.device_clock == "off":
        return DeviceDates()
    clock = DeviceClock(settings.device_clock_limit_s)
    return DeviceDates(clock, is_strict=settings.device_clock == "arrival")
