"""Faults of a device, when a test wants them: for what is built on `rosbase.device`."""

import select
from collections import deque

from rosbase.device import Device, OpenDevice
from rosbase.errors import TransportError
from rosbase.runtime.wake_pipe import WakePipe

__all__ = ["Faults"]


class Faults:
    """Says what goes wrong with the devices that an `OpenDevice` opens.

    A `DeviceTransport` is made with `faults.open` in place of what is given here. Everything may
    be set from any thread, before the device is opened or while it is read. Needs Linux.
    """

    def __init__(self, open_device: OpenDevice) -> None:
        """Nothing goes wrong yet."""
        self.refusal: TransportError | None = None
        """What opening raises, if anything."""
        self.most_bytes: int | None = None
        """How much a read gives at most; what is left comes with the next."""
        self._open_device = open_device
        self._device: _FaultyDevice | None = None

    def open(self) -> Device:
        """Opens a device that goes wrong as it is told to; an `OpenDevice`."""
        if self.refusal is not None:
            raise self.refusal
        self._device = _FaultyDevice(self._open_device(), self)
        return self._device

    def lose(self, why: str = "the test has pulled the plug") -> None:
        """The device that is open is lost, at its next read, which comes at once."""
        self._fail(TransportError(why))

    def raise_error(self, error: Exception) -> None:
        """The next read raises that, as of a library with a fault."""
        self._fail(error)

    def disturb(self, junk: bytes) -> None:
        """The next read gives that, as from a line that is disturbed."""
        if self._device is not None:
            self._device.add(junk)

    def _fail(self, error: Exception) -> None:
        if self._device is not None:
            self._device.add(error)


class _FaultyDevice:
    """A device, and what is put between it and its reader."""

    def __init__(self, inner: Device, faults: Faults) -> None:
        self.name = inner.name
        self._inner = inner
        self._faults = faults
        self._pending: deque[bytes | Exception] = deque()
        self._wakeup = WakePipe()
        # One descriptor that can be read when either the device or something pending can.
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
