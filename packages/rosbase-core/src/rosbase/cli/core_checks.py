"""The core's checks for `rosbase doctor`: the interpreter, the date, and the plugins."""

import platform
import sys
from collections.abc import Iterable
from datetime import datetime, timezone

from rosbase.cli.list_plugins import what_of
from rosbase.clock import Clock, date_fault
from rosbase.contracts.checks import Finding, Outcome
from rosbase.errors import NotInstalledError
from rosbase.imu.settings import judged_plugins
from rosbase.plugins import BLOCK_VARIABLE, PluginRecord, PluginRegistry
from rosbase.plugins.our_packages import OURS, how_to_install
from rosbase.roles.connection import BACKEND_VARIABLE, backend_name

__all__ = ["check_clock", "check_plugins", "check_python"]

# No release of rosbase is older.
_EARLIEST_S = 1_704_067_200  # 2024-01-01
_SET_CLOCK = "set it: sudo timedatectl set-ntp true, or sudo date -s 'YYYY-MM-DD HH:MM'"


def check_python() -> Iterable[Finding]:
    """Report the interpreter and its platform; warn if they have not been tested."""
    implementation, system = platform.python_implementation(), platform.system()
    what = f"{implementation} {platform.python_version()} on {platform.platform()}"
    yield Finding(Outcome.OK, f"{what}, {sys.executable}")
    if implementation != "CPython":
        yield Finding(
            Outcome.WARN, f"rosbase is not tested on {implementation}", "use CPython 3.10 or newer"
        )
    if system != "Linux":
        yield Finding(
            Outcome.WARN,
            f"rosbase is not tested on {system or 'this system'}",
            "use Linux if something does not work: serial ports and child processes need POSIX",
        )


def check_clock(clock: Clock) -> Iterable[Finding]:
    """Report the date of this machine; warn if stamps made from it would be wrong."""
    now_ns = clock.now_ns()
    if fault := date_fault(now_ns):
        yield Finding(Outcome.WARN, f"{fault}: stamps are zero", _SET_CLOCK)
        return
    date = f"{datetime.fromtimestamp(now_ns / 1e9, tz=timezone.utc):%Y-%m-%d %H:%M:%S} UTC"
    if now_ns < _EARLIEST_S * 1e9:
        text = f"the date of this machine is {date}: its clock was never set"
        yield Finding(Outcome.WARN, text, _SET_CLOCK)
    else:
        yield Finding(Outcome.OK, f"the date of this machine is {date}")


def check_plugins(registry: PluginRegistry) -> Iterable[Finding]:
    """Report each plugin, missing packages, and whether the backend is installed."""
    for record in judged_plugins(registry):
        yield _finding_of(record)
    for what, package in registry.missing.items():
        yield Finding(Outcome.SKIP, f"{what} is not installed", how_to_install(package))
    try:
        registry.backend(backend_name())
    except NotInstalledError as error:
        advice = f"set {BACKEND_VARIABLE} to one of {', '.join(registry.backends)}, or unset it"
        yield Finding(Outcome.FAIL, f"{BACKEND_VARIABLE}: {error}", advice)


def _finding_of(record: PluginRecord) -> Finding:
    text = f"{record.full_name} {record.version}, {record.status}: {what_of(record)}"
    match record.status:
        case "active" if record.descriptors:
            return Finding(Outcome.OK, text)
        case "active":
            return Finding(
                Outcome.WARN,
                text,
                "does its module have a hook that is marked with @hookimpl and yields?",
            )
        case "blocked":
            return Finding(Outcome.SKIP, text, f"take it out of {BLOCK_VARIABLE} to use it again")
    name = record.distribution
    repair = f"pip install --force-reinstall {name}"
    if name in OURS.values():
        # pip installs a folder again without being forced to.
        repair = f"in a clone of rosbase: pip install ./packages/{name}; from an index: {repair}"
    return Finding(
        Outcome.FAIL,
        text,
        f"repair it ({repair}), remove it (pip uninstall {name}),"
        f" or leave it out ({BLOCK_VARIABLE}={record.full_name})",
    )
