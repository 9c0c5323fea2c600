"""Checks once a second while a device is read: whether it sends, and its own report."""

from rosbase.contracts.transport import Tally, TransportContext
from rosbase.device.device import Device, DeviceReport, ReportingDevice

__all__ = ["Watch"]

_NS_PER_S = 1_000_000_000
_NEVER_NS = 2**63 - 1
_REMARK_LOG_S = 5.0
# A board that needs longer than the limit to start would be reset again and again.
_MOST_PATIENCE = 8


class Watch:
    """Watches a device that is being read. For the reader thread only.

    The loop of the reader checks `due_ns` and `timeout_ms`, so that a read costs one
    comparison. If there is nothing to check, nothing is ever due.
    """

    def __init__(self, context: TransportContext, tally: Tally, reopen_after_s: float) -> None:
        """Start without a device.

        Args:
            context: The clock and the logger of the transport.
            tally: Counts the errors of a report.
            reopen_after_s: Seconds without data after which the device is opened again; 0: never.
        """
        self._context = context
        self._tally = tally
        self._silence_s = reopen_after_s
        self._limit_ns = self._patience_ns = int(reopen_after_s * _NS_PER_S)
        self._period_ns = (
            min(_NS_PER_S, max(1, self._limit_ns // 2)) if self._limit_ns else _NS_PER_S
        )
        self._device: Device | None = None
        self._trouble = ""
        self._begin_ns = 0
        self._received = 0
        self.is_silent = False
        """Whether the device was opened again because it was silent, and still is."""
        self.due_ns = _NEVER_NS
        """Time of the next check, on the monotonic clock."""
        self.timeout_ms: float | None = None
        """Time that the reader may wait for data before it checks `due_ns`; None: for ever."""

    def begin(self, device: Device) -> None:
        """Watch this device from now on."""
        self._device = device
        # The trouble of a silent device is not said again each time that it is opened.
        self._trouble = self._trouble if self.is_silent else ""
        self._say_in_health()
        self._received = self._tally.received_bytes
        self._begin_ns = self._context.clock.monotonic_ns()
        if self._limit_ns or isinstance(device, ReportingDevice):
            self.due_ns = 0 if self.is_silent else self._begin_ns + self._period_ns
            self.timeout_ms = self._period_ns / 1e6
        else:
            self.due_ns, self.timeout_ms = _NEVER_NS, None

    def look(self, now_ns: int) -> bool:
        """Check the device and log changes; return whether to go on reading it.

        Raises:
            TransportError: The device found out that it is lost.
        """
        device, received = self._device, self._tally.received_bytes
        is_quiet, self._received = received == self._received, received
        if self.is_silent and not is_quiet:
            self._hear()
        if isinstance(device, ReportingDevice):
            self._take(device.report(is_quiet))
        is_overdue = self._is_overdue(now_ns)
        # A device that was silent is noticed with its first data.
        self.due_ns = 0 if self.is_silent else now_ns + self._period_ns
        return not is_overdue

    def _hear(self) -> None:
        self.is_silent = False
        self._patience_ns = self._limit_ns
        self._say_in_health()
        self._context.logger.info(f"{self._name} sends again")

    def _take(self, report: DeviceReport) -> None:
        logger, tally = self._context.logger, self._tally
        tally.count_link_errors(report.errors)
        if report.remark and logger.due("remark of the device", _REMARK_LOG_S):
            logger.warning(report.remark)
        if report.trouble == self._trouble:
            return
        before, self._trouble = self._trouble, report.trouble
        self._say_in_health()
        if report.trouble:
            logger.warning(report.trouble)
        else:
            logger.info(f"resolved: {before}")

    def _is_overdue(self, now_ns: int) -> bool:
        since_ns = max(self._begin_ns, self._tally.last_data_ns or 0)
        if not self._limit_ns or now_ns - since_ns < self._patience_ns:
            return False
        self._patience_ns = min(2 * self._patience_ns, _MOST_PATIENCE * self._limit_ns)
        if not self.is_silent:
            self.is_silent = True
            self._say_in_health()
            self._context.logger.warning(f"{self._silence}; opening it again")
        return True

    def _say_in_health(self) -> None:
        self._tally.last_error = self._trouble or (self._silence if self.is_silent else "")

    @property
    def _silence(self) -> str:
        return f"{self._name} has sent nothing for {self._silence_s:g} s"

    @property
    def _name(self) -> str:
        return self._device.name if self._device is not None else ""
