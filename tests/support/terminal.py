"""A command on a terminal of its own, and what it wrote there."""

import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import pyte

from support.waiting import wait_until

__all__ = ["Terminal", "assert_harmless", "on_terminal"]

# What the command itself writes: it begins its last lines anew, and gives each record a colour.
_OURS = re.compile(r"\r(?:\x1b\[\d+A)?\x1b\[[JK]")
_COLOURS = re.compile(r"(?m)^\x1b\[(?:0|31|32|33)m(?=\[[A-Z]+\] )|\x1b\[0m$")
_ROWS = 60


class Terminal:
    """What a command has written so far to its terminal: both its streams."""

    def __init__(
        self, command: Sequence[str], columns: int, environment: Mapping[str, str]
    ) -> None:
        self._own_end, far_end = pty.openpty()
        self._columns = columns
        fcntl.ioctl(far_end, termios.TIOCSWINSZ, struct.pack("4H", _ROWS, columns, 0, 0))
        self.process = subprocess.Popen(
            command,
            stdin=far_end,
            stdout=far_end,
            stderr=far_end,
            env={**os.environ, "PYTHONUTF8": "1", **environment},
        )
        os.close(far_end)
        self.shown = b""
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self) -> None:
        readable = select.poll()
        readable.register(self._own_end, select.POLLIN)
        while True:
            if readable.poll(50):
                try:
                    self.shown += os.read(self._own_end, 4_096)
                except OSError:
                    # The terminal is gone: the command has ended.
                    return
            elif self.process.poll() is not None:
                # On a busy machine the kernel may forget to say so.
                return

    def waits_for(self, part: str) -> None:
        wait_until(lambda: part.encode() in self.shown, f"{part!r} in {self.shown!r}")

    def screens(self, until: str) -> list[list[str]]:
        """What could be seen, line by line, each time before something was written anew."""
        self.waits_for(until)
        self._await_end()
        screen = pyte.Screen(self._columns, _ROWS)
        stream = pyte.Stream(screen)
        screens = []
        begin = 0
        text = self.shown.decode()
        for match in [*_OURS.finditer(text), None]:
            end = match.start() if match else len(text)
            stream.feed(text[begin:end])
            screens.append([line.rstrip() for line in screen.display])
            begin = end
        return screens

    def end(self, signum: int = signal.SIGINT) -> bytes:
        """Ends the command; gives everything that it wrote."""
        if self.process.poll() is None:
            self.process.send_signal(signum)
        self._await_end()
        return self.shown

    def close(self) -> None:
        """Ends the command if it still runs, and the terminal. Idempotent."""
        if self.process.poll() is None:
            self.process.kill()
        self._await_end()
        if self._own_end >= 0:
            os.close(self._own_end)
            self._own_end = -1

    def _await_end(self) -> None:
        self.process.wait(20)
        self._thread.join(20)


@contextmanager
def on_terminal(
    *command: str, columns: int = 100, environment: Mapping[str, str] | None = None
) -> Iterator[Terminal]:
    """A terminal of that width; without colours, if the environment does not say otherwise."""
    terminal = Terminal(command, columns, environment or {"NO_COLOR": "1"})
    try:
        yield terminal
    finally:
        terminal.close()


def assert_harmless(written: bytes) -> list[str]:
    """Nothing in it but lines of what can be seen; gives those lines."""
    text = _OURS.sub("\n", written.decode()).replace("\r\n", "\n")
    lines = _COLOURS.sub("", text).split("\n")
    for line in lines:
        assert line.isprintable(), f"{line!r} does more than to be read"
    return lines
