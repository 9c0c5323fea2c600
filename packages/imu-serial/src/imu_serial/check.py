"""Checks of serial ports for `rosbase doctor`: which ports exist, and who may open them.

Opening a port resets many boards, so only a port that the user has named is opened.
"""

import grp
import os
import pwd
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path

from imu_serial.address import Address
from imu_serial.config import SerialConfig
from imu_serial.holders import KNOWN_TAKERS, holder_of, running_takers
from imu_serial.network import Dialer
from imu_serial.port import Port
from imu_serial.refusals import group_name, port_names
from rosbase import (
    CheckContext,
    Clock,
    DeviceBusyError,
    DeviceNotFoundError,
    Finding,
    NotADeviceError,
    Outcome,
    ParameterError,
    TransportError,
)

__all__ = ["check_ports"]

_LATENCY_TIMERS = Path("/sys/bus/usb-serial/devices")
_LONG_LATENCY_MS = 2
_SERVE = {
    "socket": "socat TCP-LISTEN:{0.port},reuseaddr,fork FILE:/dev/ttyUSB0,b115200,raw,echo=0",
    "rfc2217": "ser2net -Y 'connection: &imu' -Y '  accepter: telnet(rfc2217),tcp,{0.port}' "
    "-Y '  connector: serialdev,/dev/ttyUSB0,115200n81,local'",
}
"""Program that serves a port at the other end, by scheme."""


def check_ports(context: CheckContext) -> Iterable[Finding]:
    """Check the port that a reader would open, and the others."""
    is_named = context.asks_for("serial", "device_path")
    try:
        config = SerialConfig.from_values(context.values)
    except ParameterError as error:
        yield Finding(Outcome.FAIL, str(error), "correct the parameters of the port")
        return
    if config.address is not None:
        if is_named:
            yield _reached(config, config.address, context.clock)
        return
    yield from _files(config, context, is_named=is_named)


def _files(config: SerialConfig, context: CheckContext, *, is_named: bool) -> Iterator[Finding]:
    path, ports = config.device_path, port_names()
    others = [port for port in ports if os.path.realpath(port) != os.path.realpath(path)]
    if is_named:
        closed = _closed(path, Outcome.FAIL)
        yield closed or _opened(config, ports)
        if not closed:
            yield from _slow(path, Outcome.WARN)
    elif os.path.exists(path):
        yield _closed(path, Outcome.FAIL) or _allowed(path)
        yield from _slow(path, Outcome.OK)
    elif context.values["comm_t"] == "serial":
        yield _nothing_named(path, others)
    for port in others:
        yield _closed(port, Outcome.WARN) or _allowed(port)
        yield from _slow(port, Outcome.OK)
    if is_named or (ports and context.values["comm_t"] == "serial"):
        yield from _takers()


def _takers() -> Iterator[Finding]:
    for process in running_takers():
        taker = KNOWN_TAKERS[process.name]
        yield Finding(Outcome.WARN, f"{process} is running: {taker.why}", taker.remedy)


def _slow(path: str, outcome: Outcome) -> Iterator[Finding]:
    """Yield the latency timer of the adapter, if it has a long one.

    A reader asks for a short one, so a long one matters if the port was opened.
    """
    name = os.path.basename(os.path.realpath(path))
    timer = _LATENCY_TIMERS / name / "latency_timer"
    try:
        latency_ms = int(timer.read_text())
    except (OSError, ValueError):
        # Not an adapter with such a timer.
        return
    if latency_ms > _LONG_LATENCY_MS:
        kept = "also for a reader" if outcome is Outcome.WARN else "until it is read"
        yield Finding(
            outcome,
            f"{path} delivers data only every {latency_ms} ms, {kept}",
            f"echo 1 | sudo tee {timer}, or permanently:"
            ' a udev rule with ATTR{latency_timer}="1"',
        )


def _reached(config: SerialConfig, address: Address, clock: Clock) -> Finding:
    try:
        link = Dialer(config, address, clock).open()
    except TransportError as error:
        return Finding(Outcome.FAIL, str(error), _advice_on_network(error, address))
    link.close()
    return Finding(Outcome.OK, f"{link.name} can be reached")


def _advice_on_network(error: TransportError, address: Address) -> str:
    if isinstance(error, NotADeviceError):
        return "correct device_path and baudrate, or the settings of the server"
    serve = _SERVE[address.scheme].format(address)
    return f"correct host and port, or serve the port there: {serve}"


def _nothing_named(path: str, others: list[str]) -> Finding:
    if not others:
        return Finding(
            Outcome.WARN,
            "this machine has no serial port",
            "plug the device in; pass it to the container or virtual machine",
        )
    return Finding(
        Outcome.WARN,
        f"{path}, the default port, is not there",
        f"set yours: -p device_path:={others[0]}",
    )


def _opened(config: SerialConfig, ports: list[str]) -> Finding:
    try:
        port = Port(config)
    except TransportError as error:
        return Finding(Outcome.FAIL, str(error), _advice_on(error, ports))
    port.close()
    return Finding(Outcome.OK, f"{port.name} can be opened")


def _advice_on(error: TransportError, ports: list[str]) -> str:
    there = f"the ports here are {', '.join(ports)}" if ports else "there is no serial port here"
    match error:
        case DeviceNotFoundError():
            return f"plug it in, and check `dmesg`; {there}"
        case DeviceBusyError():
            return "end the other program; `sudo fuser -v` and the port show it"
        case NotADeviceError():
            return f"correct device_path and baudrate; {there}"
    return "check `dmesg`; in a container, pass the device in"


def _allowed(path: str) -> Finding:
    return Finding(Outcome.OK, f"{path} exists, and this user may open it")


def _closed(path: str, outcome: Outcome) -> Finding | None:
    """Return why a port cannot be opened, as far as that can be seen without opening it."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return None
    if not stat.S_ISCHR(mode):
        return None
    if not os.access(path, os.R_OK | os.W_OK):
        return _forbidden(path, mode, outcome)
    if _is_line(path) and (holder := holder_of(path)):
        taker = KNOWN_TAKERS.get(holder.name)
        advice = taker.remedy if taker else "end that program, or use another port"
        return Finding(outcome, f"{path} is in use by {holder}", advice)
    return None


def _forbidden(path: str, mode: int, outcome: Outcome) -> Finding:
    group, user = group_name(path), _user_name()
    text = f"{user} may not open {path}, which belongs to the group {group}"
    is_for_group = mode & stat.S_IRGRP and mode & stat.S_IWGRP and group != "root"
    if not is_for_group:
        advice = f"until it is unplugged: sudo chmod a+rw {path}; permanently: a udev rule"
    elif user in _members(path):
        advice = f"{user} was added to that group: log out and in again"
    else:
        advice = f"sudo usermod -aG {group} {user}, then log out and in again"
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
    """Return whether it is a serial line or a terminal, without opening it."""
    name = os.path.basename(os.path.realpath(path))
    return os.path.realpath(path).startswith("/dev/pts/") or os.path.exists(
        f"/sys/class/tty/{name}"
    )
