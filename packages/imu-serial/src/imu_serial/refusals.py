"""Explain why a port cannot be opened, in the user's words."""

import errno
import grp
import os
import re

from serial.tools import list_ports

from imu_serial.holders import holder_of, running_takers
from rosbase import (
    DeviceBusyError,
    DeviceNotFoundError,
    DevicePermissionError,
    NotADeviceError,
    TransportError,
    one_line,
    printable,
)

__all__ = ["explain", "group_name", "in_use", "is_multiplexer", "is_name", "port_names", "shown"]

_OF_WINDOWS = re.compile(r"(\\\\[.?]\\)?COM\d+:?", re.IGNORECASE)
_OF_MACOS = re.compile(r"/dev/(cu|tty)\..+")
_HOST_AND_PORT = re.compile(r"[\w.-]+:\d+", re.ASCII)
_PATTERN = re.compile(r"[*?\[]")
_MULTIPLEXERS = frozenset({"/dev/ptmx", "/dev/pts/ptmx"})
_WITH_RATE = re.compile(r"(.+)[:,@](\d{3,8})", re.ASCII)


def shown(path: str) -> str:
    """Return the name of a port, fit for a line of text."""
    return printable(path) or repr(path)


def is_name(path: str) -> bool:
    """Return whether the name is a possible file name."""
    try:
        return bool(path) and b"\0" not in os.fsencode(path)
    except UnicodeEncodeError:
        return False


def is_multiplexer(path: str) -> bool:
    """Return whether each opening of a file makes a new pseudo-terminal, without a sender."""
    return os.path.realpath(path) in _MULTIPLEXERS


def explain(path: str, baudrate: int, error: Exception) -> TransportError:
    """Return the error that tells the user what to do."""
    name = shown(path)
    # termios.error is no OSError.
    code = error.errno if isinstance(error, OSError) else (*error.args, None)[0]
    match code:
        case errno.ENOENT | errno.ENODEV | errno.ENXIO:
            return _absent(name, path)
        case errno.EACCES | errno.EPERM:
            return DevicePermissionError(
                f"{name} may not be opened by this user; it belongs to the group {group_name(path)}"
            )
        case errno.EAGAIN | errno.EBUSY:
            return in_use(path)
        case errno.ENOTDIR | errno.EISDIR | errno.ELOOP | errno.ENOTTY:
            return NotADeviceError(f"{name} is not a serial port")
    if isinstance(error, ValueError):
        return NotADeviceError(f"{name} does not take {baudrate} baud: {error}")
    reason = os.strerror(code) if isinstance(code, int) else one_line(str(error))
    return TransportError(f"{name} cannot be opened: {reason}")


def in_use(path: str) -> DeviceBusyError:
    """Return the error that says which program has the port open."""
    text = f"{shown(path)} is in use by"
    holder = holder_of(path)
    if holder is not None:
        return DeviceBusyError(f"{text} {holder}{holder.advice}")
    suspects = [f"; perhaps {taker}{taker.advice}" for taker in running_takers()]
    return DeviceBusyError(f"{text} another program{''.join(suspects[:1])}")


def group_name(path: str) -> str:
    """Return the group of a port."""
    try:
        return grp.getgrgid(os.stat(path).st_gid).gr_name
    except (OSError, KeyError):
        return "of another user"


def port_names() -> list[str]:
    """Return the paths of the existing ports; rarely used ones on the board come last."""
    names = [port.device for port in list_ports.comports()]
    return sorted(names, key=lambda name: (name.startswith("/dev/ttyS"), name))


def _absent(name: str, path: str) -> TransportError:
    rated = _WITH_RATE.fullmatch(path)
    if rated and os.path.exists(rated[1]):
        return NotADeviceError(
            f"{name} is not there, but {rated[1]} is; the rate goes into baudrate:={rated[2]}"
        )
    if _OF_WINDOWS.fullmatch(path):
        return NotADeviceError(f"{name} is a name that ports have on Windows; {_ports_here()}")
    if _OF_MACOS.fullmatch(path):
        return NotADeviceError(f"{name} is a name that ports have on macOS; {_ports_here()}")
    if path.startswith("~") or "$" in path:
        return NotADeviceError(f"{name} has a ~ or a $, which only a shell replaces; write it out")
    if _PATTERN.search(path):
        return NotADeviceError(f"{name} is a pattern, not the name of a port; {_ports_here()}")
    if "/" not in path:
        if _HOST_AND_PORT.fullmatch(path):
            return NotADeviceError(f"{name} is not a port; over a network it is socket://{path}")
        return NotADeviceError(f"{name} is not a path; {_ports_here(f'/dev/{path}')}")
    text = f"{name} is not there; is the device plugged in?"
    if path.startswith(("/dev/ttyUSB", "/dev/serial/")):
        thief = next((taker for taker in running_takers() if taker.name == "brltty"), None)
        text += f" {thief} is running{thief.advice}" if thief else ""
    return DeviceNotFoundError(text)


def _ports_here(wanted: str = "") -> str:
    if os.path.exists(wanted):
        return f"write {wanted}"
    there = port_names()
    return f"here there are {', '.join(there)}" if there else "this machine has no serial port"
