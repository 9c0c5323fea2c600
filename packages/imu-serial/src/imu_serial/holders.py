"""Programs that have a port open, as far as /proc shows them, and programs known to open ports."""

import os
from collections.abc import Iterator
from pathlib import Path

from attrs import frozen

from rosbase import printable

__all__ = ["KNOWN_TAKERS", "Process", "Taker", "holder_of", "running_takers"]

_PROC = Path("/proc")


@frozen
class Taker:
    """A program that opens ports without being told to."""

    why: str
    remedy: str


KNOWN_TAKERS = {
    "ModemManager": Taker(
        "it opens new ports for some seconds to look for modems",
        'keep it off with the udev rule ENV{ID_MM_DEVICE_IGNORE}="1", or uninstall modemmanager',
    ),
    "brltty": Taker(
        "it takes USB adapters for braille displays",
        "uninstall it, if you have none: sudo apt remove brltty",
    ),
    "gpsd": Taker(
        "it takes USB adapters for GPS receivers",
        'set USBAUTO="false" in /etc/default/gpsd, or uninstall it',
    ),
    "agetty": Taker(
        "it offers a login on this port",
        "sudo systemctl disable --now serial-getty@ and the name of the port, such as ttyS0",
    ),
}
"""Known programs by the name of their process."""


@frozen
class Process:
    """A process that is or was there."""

    pid: int
    name: str

    def __str__(self) -> str:
        return f"process {self.pid} ({self.name})"

    @property
    def advice(self) -> str:
        """Advice for the user, after a semicolon; empty for an unknown program."""
        taker = KNOWN_TAKERS.get(self.name)
        return f"; {taker.why}: {taker.remedy}" if taker else ""


# Looking at every descriptor of every process takes a while, and it usually is still the same.
_last_holders: dict[str, int] = {}


def holder_of(path: str) -> Process | None:
    """Return another process that has the port open; None if none is seen.

    Only root sees a process of another user, unless it has locked the port.
    """
    device = os.path.realpath(path)
    last = _last_holders.get(device)
    if last is not None and _has_open(last, device):
        return _process(last)
    for pid in _others():
        if _has_open(pid, device):
            _last_holders[device] = pid
            return _process(pid)
    _last_holders.pop(device, None)
    owner = _lock_owner(device)
    return None if owner is None else _process(owner)


def running_takers() -> Iterator[Process]:
    """Return the running programs of KNOWN_TAKERS that open ports by themselves."""
    for pid in _others():
        process = _process(pid)
        # There are login prompts on every machine; one matters where it has the port.
        if process.name in KNOWN_TAKERS and process.name != "agetty":
            yield process


def _others() -> Iterator[int]:
    me = os.getpid()
    for name in os.listdir(_PROC):
        if name.isdecimal() and int(name) != me:
            yield int(name)


def _process(pid: int) -> Process:
    try:
        name = (_PROC / str(pid) / "comm").read_text(errors="replace").strip()
    except OSError:
        # It has ended.
        name = ""
    return Process(pid, printable(name) or "unknown")


def _has_open(pid: int, device: str) -> bool:
    """Return whether it has the port open, and is not the simulated device behind it."""
    opened = dict(_opened(pid))
    if device not in opened.values():
        return False
    number = device.removeprefix("/dev/pts/")
    masters = (fd for fd, target in opened.items() if target in ("/dev/ptmx", "/dev/pts/ptmx"))
    return not any(_leads_to(pid, fd, number) for fd in masters)


def _opened(pid: int) -> Iterator[tuple[str, str]]:
    folder = f"{_PROC}/{pid}/fd"
    try:
        names = os.listdir(folder)
    except OSError:
        # It has ended, or is another user's.
        return
    for name in names:
        try:
            yield name, os.readlink(f"{folder}/{name}")
        except OSError:
            # It has closed it.
            continue


def _leads_to(pid: int, fd: str, number: str) -> bool:
    """Return whether a descriptor is the near end of the pseudo-terminal of that number."""
    try:
        lines = (_PROC / str(pid) / "fdinfo" / fd).read_text().splitlines()
    except OSError:
        return False
    return f"tty-index:\t{number}" in lines


def _lock_owner(device: str) -> int | None:
    """Return the process that has locked the file; /proc/locks tells everybody."""
    try:
        status = os.stat(device)
        lines = (_PROC / "locks").read_text().splitlines()
    except OSError:
        return None
    file = f"{os.major(status.st_dev):02x}:{os.minor(status.st_dev):02x}:{status.st_ino}"
    for line in lines:
        fields = line.split()
        if len(fields) > 5 and fields[5] == file and fields[4] not in ("0", "-1", str(os.getpid())):
            return int(fields[4])
    return None
