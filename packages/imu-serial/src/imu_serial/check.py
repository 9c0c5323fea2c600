"""What `rosbase doctor` is told of serial ports: which there are, and who may open them.

Opening a port resets many a board, so only a port that the user has named is opened.
"""

import glob
import grp
import os
import pwd
import stat
from collections.abc import Iterable
from pathlib import Path

from imu_serial.config import SerialConfig
from imu_serial.port import Port, group_name, port_names
from rosbase import (
    CheckContext,
    DeviceBusyError,
    DeviceNotFoundError,
    Finding,
    NotADeviceError,
    Outcome,
    TransportError,
)

__all__ = ["check_ports"]


def check_ports(context: CheckContext) -> Iterable[Finding]:
    """The port that a reader would open, and the others."""
    config = SerialConfig.from_values(context.values)
    path, ports = config.device_path, port_names()
    others = [port for port in ports if os.path.realpath(port) != os.path.realpath(path)]
    if context.asks_for("serial", "device_path"):
        yield _closed(path, Outcome.FAIL) or _opened(config, ports)
    elif os.path.exists(path):
        yield _closed(path, Outcome.FAIL) or _allowed(path)
    elif context.values["comm_t"] == "serial":
        yield _nothing_named(path, others)
    for port in others:
        yield _closed(port, Outcome.WARN) or _allowed(port)


def _nothing_named(path: str, others: list[str]) -> Finding:
    if not others:
        return Finding(
            Outcome.WARN,
            "this machine has no serial port",
            "plug the device in; a container or a virtual machine must be given it, too",
        )
    return Finding(
        Outcome.WARN,
        f"{path}, which is read where no port is named, is not there",
        f"name yours: -p device_path:={others[0]}",
    )


def _opened(config: SerialConfig, ports: list[str]) -> Finding:
    try:
        port = Port(config)
    except TransportError as error:
        return Finding(Outcome.FAIL, str(error), _advice_on(error, ports))
    port.close()
    return Finding(Outcome.OK, f"{port.name} can be opened")


def _advice_on(error: TransportError, ports: list[str]) -> str:
    there = f"name one that is there: {', '.join(ports)}" if ports else "no port is there"
    match error:
        case DeviceNotFoundError():
            return f"plug it in, and see what `dmesg` says of it; {there}"
        case DeviceBusyError():
            return "end the other program, as root if you do not see it: `fuser -v` and the port"
        case NotADeviceError():
            return f"correct device_path and baudrate; {there}"
    return "see what `dmesg` says of it; in a container, give it the device"


def _allowed(path: str) -> Finding:
    return Finding(Outcome.OK, f"{path} is there, and this user may open it")


def _closed(path: str, outcome: Outcome) -> Finding | None:
    """Why a port that is there cannot be opened, as far as that is seen without opening it."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return None
    if not stat.S_ISCHR(mode):
        return None
    if not os.access(path, os.R_OK | os.W_OK):
        return _forbidden(path, mode, outcome)
    if _is_line(path) and (holder := _holder(path)):
        advice = "end that program, or read another port"
        return Finding(outcome, f"{path} is in use by {holder}", advice)
    return None


def _forbidden(path: str, mode: int, outcome: Outcome) -> Finding:
    group, user = group_name(path), _user_name()
    text = f"{user} may not open {path}, which belongs to the group {group}"
    is_for_group = mode & stat.S_IRGRP and mode & stat.S_IWGRP and group != "root"
    if not is_for_group:
        advice = f"until it is unplugged: sudo chmod a+rw {path}; for good: a rule of udev"
    elif user in _members(path):
        advice = f"{user} has come into that group meanwhile: log out, and in again"
    else:
        advice = f"sudo usermod -aG {group} {user}, then log out, and in again"
    return Finding(outcome, text, advice)


def _members(path: str) -> list[str]:
    try:
        return grp.getgrgid(os.stat(path).st_gid).gr_mem
    except (OSError, KeyError):
        return []


def _user_name() -> str:
    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return f"user {os.geteuid()}"


def _is_line(path: str) -> bool:
    """Whether it is a serial line or a terminal, as far as that is seen without opening it."""
    name = os.path.basename(os.path.realpath(path))
    return os.path.realpath(path).startswith("/dev/pts/") or os.path.exists(
        f"/sys/class/tty/{name}"
    )


def _holder(path: str) -> str:
    """Another program that has the port open; nothing, if none is seen."""
    device, me = os.path.realpath(path), str(os.getpid())
    for opened in glob.iglob("/proc/[0-9]*/fd/*"):
        process = Path(opened).parts[2]
        try:
            if process != me and os.readlink(opened) == device:
                name = Path("/proc", process, "comm").read_text(errors="replace").strip()
                return f"process {process} ({name})"
        except OSError:
            # It has ended, or has closed it.
            continue
    return ""
