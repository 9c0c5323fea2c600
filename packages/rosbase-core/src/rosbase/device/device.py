"""What the author of a transport writes when the system can wait for the device.

Must implement: all of `Device`. May implement: `report` of `ReportingDevice`. A plain class will
do; there is nothing to inherit.
"""

from collections.abc import Callable, Mapping
from typing import Protocol, TypeAlias, runtime_checkable

from attrs import field, frozen

from rosbase.logger import RosbaseLogger

__all__ = ["Device", "DeviceReport", "OpenDevice", "ReportingDevice", "give_back"]


class Device(Protocol):
    """A device, or a link to one, that is open. One thread at a time calls it.

    A device may have an attribute `bytes_per_s`: how many bytes a second come at most, on a line
    that hands them over as they come, such as a UART. A few frames that are read together are
    then stamped no farther apart than they were on the line.
    """

    @property
    def name(self) -> str:
        """What people call it in a line of text, such as `/dev/ttyUSB0`."""
        ...

    def fileno(self) -> int:
        """The descriptor that can be read when there is something."""
        ...

    def read(self) -> bytes:
        """What has arrived, without waiting for more; empty if there is nothing after all.

        Called when the descriptor can be read or is at its end.

        Raises:
            TransportError: The device is lost. It is closed then, and opened anew.
        """
        ...

    def discard_input(self) -> None:
        """Forgets what has arrived and was not read. Called when reading begins.

        Raises:
            TransportError: The device is lost.
        """
        ...

    def close(self) -> None:
        """Gives the device back. Raises nothing. Called once."""
        ...


@frozen
class DeviceReport:
    """What a device knows of itself beside its data."""

    trouble: str = ""
    """What is wrong although the device can be read, in one line; empty if nothing is.

    It is `health.last_error` for as long as it is reported, and logged when it changes.
    """
    errors: Mapping[str, int] = field(factory=dict)
    """Bytes that were lost or damaged since the last report: how many, by reason; one word each.

    Counted in `health.link_errors`.
    """
    remark: str = ""
    """A line for the log, such as about these errors. Logged at a limited rate."""


@runtime_checkable
class ReportingDevice(Device, Protocol):
    """A device that reports on itself while it is read."""

    def report(self, is_quiet: bool) -> DeviceReport:
        """Return what is wrong at this moment, and what went wrong since the last call.

        Called about once a second, on the thread that reads, which waits meanwhile.

        Args:
            is_quiet: Whether nothing has arrived since the last call.

        Raises:
            TransportError: The device is lost. It is closed then, and opened anew.
        """
        ...


def give_back(device: Device, logger: RosbaseLogger) -> None:
    """Closes a device. What that raises although it should not is logged: it is gone anyhow."""
    try:
        device.close()
    except Exception as error:
        # The boundary to the author's code.
        logger.error(f"closing {device.name} failed: {error!r}", exc_info=error)


OpenDevice: TypeAlias = Callable[[], Device]
"""Opens the device, within a second or two, or raises the TransportError that says why not.

`stop` and `close` wait for it where the reader thread is opening.
"""
