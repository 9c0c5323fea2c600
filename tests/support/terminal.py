"""A command on a terminal of its own, and what it wrote there."""

import os
import pty
import re
import select
import signal
import subprocess
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from support.waiting import wait_until

__all__ = ["Terminal", "assert_harmless", "on_terminal"]

# What the command itself writes: it begins a line anew, and gives each record a colour.
_OURS = re.compile(r"\r\x1b\[K")
_COLOURS = re.compile(r"(?m)^\x1b\[(?:0|31|32|33)m(?=\[[A-Z]+\] )|\x1b\[0m$")


class Terminal:
    """What a command has written so far to its terminal: both its streams."""

    def __init__(self, command: Sequence[str]) -> None:
        self._own_end, far_end = pty.openpty()
        self.process = subprocess.Popen(command, stdin=far_end, stdout=far_end, stderr=far_end)
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

    def end(self, signum: int = signal.SIGINT) -> bytes:
        """Ends the command; gives everything that it wrote."""
        if self.process.poll() is None:
            self.process.send_signal(signum)
        self.process.wait(20)
        self._thread.join(20)
        os.close(self._own_end)
        return self.shown


@contextmanager
def on_terminal(*command: str) -> Iterator[Terminal]:
    terminal = Terminal(command)
    try:
        yield terminal
    finally:
        if terminal.process.poll() is None:
            terminal.end(signal.SIGKILL)


def assert_harmless(written: bytes) -> list[str]:
    """Nothing in it but lines of what can be seen; gives those lines."""
    text = _OURS.sub("\n", written.decode()).replace("\r\n", "\n")
    lines = _COLOURS.sub("", text).split("\n")
    for line in lines:
        assert line.isprintable(), f"{line!r} does more than to be read"
    return lines
