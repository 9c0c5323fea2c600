"""The interface that a plugin implements if the system can wait for its device.

Must implement: all of `Device`. May implement: `report` of `ReportingDevice`. A plain class will
do; there is nothing to inherit.
"""

from collections.abc import Callable, Mapping
from typing import Protocol, TypeAlias, runtime_checkable

from attrs import field, frozen

from rosbase.logger import RosbaseLogger

__all__ = ["Device", "DeviceReport", "OpenDevice", "ReportingDevice", "give_back"]


class Device(Protocol):
    """An open device, or an open link to one. One thread at a time calls it.

    A device may have an attribute `bytes_per_s`: the maximum number of bytes per second, on a
    line that hands them over as they come, such as a UART. Then a few frames that are read
    together are stamped no further apart than on the line.
    """

    @property
    def name(self) -> str:
        """Name of the device in a line of text, such as `/dev/ttyUSB0`."""
        ...

    def fileno(self) -> int:
        """Return the descriptor, which is readable when there is data."""
        ...

    def read(self) -> bytes:
        """Return arrived data without waiting for more; empty if there is none after all.

        Called when the descriptor can be read or is at its end.

        Raises:
            TransportError: The device is lost. It will be closed and opened again.
        """
        ...

    def discard_input(self) -> None:
        """Discard arrived data that was not read. Called when reading begins.

        Raises:
            TransportError: The device is lost.
        """
        ...

    def close(self) -> None:
        """Release the device. Must not raise. Called once."""
        ...


@frozen
class DeviceReport:
    """A device's report about itself, beside its data."""

    trouble: str = ""
    """Fault of a device that can still be read, in one line; empty if there is none.

    It is `health.last_error` for as long as it is reported, and logged when it changes.
    """
    errors: Mapping[str, int] = field(factory=dict)
    """Number of bytes lost or damaged since the last report, by reason; one word each.

    Counted in `health.link_errors`.
    """
    remark: str = ""
    """A line for the log, such as about these errors. Logged at a limited rate."""


@runtime_checkable
class ReportingDevice(Device, Protocol):
    """A device that reports on itself while it is read."""

    def report(self, is_quiet: bool) -> DeviceReport:
        """Return the current fault, and the errors since the last call.

        Called about once a second, on the thread that reads, which waits meanwhile.

        Args:
            is_quiet: Whether nothing has arrived since the last call.

        Raises:
            TransportError: The device is lost. It will be closed and opened again.
        """
        ...


def give_back(device: Device, logger: RosbaseLogger) -> None:
    """Close a device. Log an exception that it should not raise: the device is gone anyway."""
    try:
        device.close()
    except Exception as error:
        # The boundary to the author's code.
        logger.error(f"closing {device.name} failed: {error!r}", exc_info=error)


OpenDevice: TypeAlias = Callable[[], Device]
"""Function that opens the device within a second or two, or raises a TransportError.

`stop` and `close` wait for it while the reader thread is opening.
"""
