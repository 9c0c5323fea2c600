"""A serial driver, at the ioctl: what a pseudo-terminal, which has no modem lines, does not do."""

import array
import errno
import fcntl
import struct
import termios
from collections.abc import Callable
from typing import Any

import pytest

__all__ = ["FakeDriver"]

_TIOCGICOUNT = 0x545D
_FLAGS = 4
_NUMBERS = {"frame": 6, "overrun": 7, "parity": 8, "brk": 9, "buf_overrun": 10}


class FakeDriver:
    """Answers the requests for modem lines, latency and counts; passes on all others."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        # As the kernel leaves them when a port is opened.
        self.modem = termios.TIOCM_DTR | termios.TIOCM_RTS
        self.requests: list[tuple[int, int]] = []
        """Each change of modem lines: the request, and which lines."""
        self.flags = 0x10000000
        self.counts = [0] * 20
        self.refuses: set[int] = set()
        """Requests that this driver does not know."""
        self._real: Callable[..., Any] = fcntl.ioctl
        monkeypatch.setattr(fcntl, "ioctl", self._ioctl)

    def count(self, **numbers: int) -> None:
        """Lets the driver see so many errors more."""
        for name, number in numbers.items():
            self.counts[_NUMBERS[name]] += number

    def _ioctl(self, fd: int, request: int, argument: Any = 0, *more: Any) -> Any:
        if request in self.refuses:
            raise OSError(errno.ENOTTY, "Inappropriate ioctl for device")
        if request in (termios.TIOCMBIS, termios.TIOCMBIC):
            (lines,) = struct.unpack("I", argument)
            self.requests.append((request, lines))
            self.modem = self.modem | lines if request == termios.TIOCMBIS else self.modem & ~lines
            return argument
        if request == _TIOCGICOUNT:
            return struct.pack("20i", *self.counts)
        if request in (termios.TIOCGSERIAL, termios.TIOCSSERIAL):
            return self._latency(request, argument)
        return self._real(fd, request, argument, *more)

    def _latency(self, request: int, settings: "array.array[int]") -> int:
        if request == termios.TIOCGSERIAL:
            settings[_FLAGS] = self.flags
        else:
            self.flags = settings[_FLAGS]
        return 0
