"""A picture of `rosbase view`, made from what the command really writes to a terminal."""

import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from generators import terminal

__all__ = ["COLUMNS", "ROWS", "picture"]

COLUMNS, ROWS = 100, 26

_TITLE = (
    "rosbase view: topics with rates and sparklines, and below them the attitude of a simulated IMU"
)
# Until the rates and the sparklines have something to show.
_WATCHED_S = 6.0
_LIMIT_S = 30.0


@cache
def picture() -> str:
    """Return SVG of the view of an IMU reader that reads a simulated device."""
    with tempfile.TemporaryDirectory(prefix="view-") as folder:
        environment = {
            **{name: value for name, value in os.environ.items() if name != "NO_COLOR"},
            "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}",
            "ROSBASE_CONTROL_FOLDER": f"{folder}/control",
            "TERM": "xterm-256color",
            "PYTHONUTF8": "1",
        }
        with _device(environment) as path:
            reader = ("rosbase", "imu", "-p", f"device_path:={path}")
            with _running(reader, environment):
                written = _watched(("rosbase", "view"), environment)
    lines = terminal.last_screen(written, COLUMNS, ROWS)
    return terminal.draw(lines, _TITLE, attributes='class="demo"')


@contextmanager
def _device(environment: dict[str, str]) -> Iterator[str]:
    """Run `rosbase simulate`; yield the path of its device."""
    with _running(("rosbase", "simulate"), environment) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if found := re.search(r"device_path:=(\S+)", line):
                yield found[1]
                return
    raise RuntimeError("rosbase simulate names no device")


@contextmanager
def _running(
    command: tuple[str, ...], environment: dict[str, str]
) -> Iterator["subprocess.Popen[str]"]:
    process = subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=_LIMIT_S)


def _watched(command: tuple[str, ...], environment: dict[str, str]) -> bytes:
    """Run a view for a while on a terminal; return all that it wrote until then."""
    near, far = pty.openpty()
    fcntl.ioctl(far, termios.TIOCSWINSZ, struct.pack("4H", ROWS, COLUMNS, 0, 0))
    process = subprocess.Popen(command, stdin=far, stdout=far, stderr=far, env=environment)
    os.close(far)
    try:
        written = _read_until(near, re.compile(rb"\d Hz"), _LIMIT_S)
        return written + _read_until(near, None, _WATCHED_S)
    finally:
        process.kill()
        process.wait()
        os.close(near)


def _read_until(descriptor: int, wanted: "re.Pattern[bytes] | None", limit_s: float) -> bytes:
    """Read what is written until it has something, or until the time is over."""
    end_s, written = time.monotonic() + limit_s, b""
    while (left_s := end_s - time.monotonic()) > 0.0:
        if select.select([descriptor], [], [], left_s)[0]:
            written += os.read(descriptor, 65_536)
            if wanted is not None and wanted.search(written):
                return written
    if wanted is not None:
        raise RuntimeError(f"nothing like {wanted.pattern!r} in {written!r}")
    return written
