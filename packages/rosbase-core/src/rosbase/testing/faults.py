"""Fault injection for devices of `rosbase.device`."""

import select
from collections import deque

from rosbase.device import Device, OpenDevice
from rosbase.errors import TransportError
from rosbase.runtime.wake_pipe import WakePipe

__all__ = ["Faults"]


class Faults:
    """Faults of the devices that an `OpenDevice` opens.

    Make a `DeviceTransport` with `faults.open` in place of your own `OpenDevice`. Any thread may
    set the faults, before the device is opened or while it is read. Needs Linux.
    """

    def __init__(self, open_device: OpenDevice) -> None:
        """Start without faults."""
        self.refusal: TransportError | None = None
        """Exception that opening raises, if any."""
        self.most_bytes: int | None = None
        """Maximum number of bytes of a read; the rest comes with the next read."""
        self._open_device = open_device
        self._device: _FaultyDevice | None = None

    def open(self) -> Device:
        """Open a device with these faults; an `OpenDevice`."""
        if self.refusal is not None:
            raise self.refusal
        self._device = _FaultyDevice(self._open_device(), self)
        return self._device

    def lose(self, why: str = "the test has pulled the plug") -> None:
        """Lose the open device at its next read, which comes at once."""
        self._fail(TransportError(why))

    def raise_error(self, error: Exception) -> None:
        """Raise an exception at the next read, like a faulty library."""
        self._fail(error)

    def disturb(self, junk: bytes) -> None:
        """Return these bytes from the next read, as from a disturbed line."""
        if self._device is not None:
            self._device.add(junk)

    def _fail(self, error: Exception) -> None:
        if self._device is not None:
            self._device.add(error)


class _FaultyDevice:
    """Device with the faults between it and its reader."""

    def __init__(self, inner: Device, faults: Faults) -> None:
        self.name = inner.name
        self._inner = inner
        self._faults = faults
        self._pending: deque[bytes | Exception] = deque()
        self._wakeup = WakePipe()
        # This descriptor is readable when the device is, or when a fault is pending.
        self._either = select.epoll()
        self._either.register(inner.fileno(), select.EPOLLIN)
        self._either.register(self._wakeup.fileno(), select.EPOLLIN)

    def add(self, what: bytes | Exception) -> None:
        self._pending.append(what)
        self._wakeup.wake()

    def fileno(self) -> int:
        return self._either.fileno()

    def read(self) -> bytes:
        self._wakeup.drain()
        what = self._pending.popleft() if self._pending else self._inner.read()
        if isinstance(what, Exception):
            raise what
        most = self._faults.most_bytes or len(what)
        if what[most:]:
            self._pending.appendleft(what[most:])
        if self._pending:
            self._wakeup.wake()
        return what[:most]

    def discard_input(self) -> None:
        self._pending.clear()
        self._inner.discard_input()

    def close(self) -> None:
        self._either.close()
        self._wakeup.close()
        self._inner.close()
