"""What this machine must offer before ROS starts: a domain, shared memory and a date.

Where one of them is missing, rcl or DDS end the process, hang, or lose messages without a word.
So they are looked at before, here and by `rosbase doctor`.
"""

import os
import re
import sys
from collections.abc import Mapping, MutableMapping
from pathlib import Path

from rosbase import date_fault

__all__ = [
    "DOMAINS",
    "SHARED_MEMORY",
    "clashing_ports",
    "date_refusal",
    "domain_fault",
    "free_bytes",
    "memory_fault",
    "read_domain",
    "spare_shared_memory",
]

DOMAINS = range(233)
"""Where the ports of a domain are numbers of ports (DDS-RTPS 2.3, 9.6.1.1)."""

SHARED_MEMORY = Path("/dev/shm")
"""Where Linux has it."""

_TRANSPORTS = "FASTDDS_BUILTIN_TRANSPORTS"
_WITHOUT_MEMORY = ("UDPV4", "UDPV6")
_PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
# Of Fast DDS 2.14: a participant takes 550 kB for what it sends, and has no use for shared memory
# with less; then 52 kB for each way by which it is reached, and without one it hears nothing.
_SEGMENT_BYTES = 2**19
_NEEDED_BYTES = 2**20
_MEGABYTE = 1e6

_PORT_BASE, _PORTS_PER_DOMAIN = 7400, 250
# The ports of the first fifty participants of a domain: two each, behind those for discovery.
_USUAL_PORTS = 10 + 2 * 50
_EPHEMERAL_PORTS = Path("/proc/sys/net/ipv4/ip_local_port_range")

# As `strtoul` reads it with base 0; rcl overlooks a sign and what stands behind the number.
_DOMAIN = re.compile(r"\s*\+?(0x[0-9a-f]+|0[0-7]*|[1-9][0-9]*)\s*", re.ASCII | re.IGNORECASE)


def read_domain(text: str) -> int | None:
    """Return the domain that `ROS_DOMAIN_ID` names, as rcl reads it; None if it names none."""
    found = _DOMAIN.fullmatch(text)
    if found is None or len(found[1]) > 20:
        return None
    digits = found[1].lower()
    base = 16 if digits.startswith("0x") else 8 if digits.startswith("0") else 10
    number = int(digits, base)
    return number if number in DOMAINS else None


def domain_fault(environment: Mapping[str, str]) -> str:
    """Return why there is no such domain, in one line; empty if there is."""
    text = environment.get("ROS_DOMAIN_ID", "")
    if not text or read_domain(text) is not None:
        return ""
    return f"ROS_DOMAIN_ID is {text!r}, and a domain is a number from 0 to {DOMAINS[-1]}"


def clashing_ports(domain: int) -> bool:
    """Whether the system may have given the ports of a domain to any other program."""
    try:
        first, last = map(int, _EPHEMERAL_PORTS.read_text().split())
    except (OSError, ValueError):
        # Linux's own default.
        first, last = 32768, 60999
    begin = _PORT_BASE + _PORTS_PER_DOMAIN * domain
    return begin <= last and first < begin + _USUAL_PORTS


def free_bytes(folder: Path = SHARED_MEMORY) -> int:
    """Return how many bytes shared memory has left; 0 if there is none to be had."""
    if sys.platform != "linux":
        # Elsewhere it is no folder.
        return sys.maxsize
    try:
        state = os.statvfs(folder)
    except OSError:
        return 0
    # A file system that does not count its files says 0 of 0.
    return state.f_bavail * state.f_frsize if state.f_favail or not state.f_files else 0


def memory_fault(environment: Mapping[str, str], middleware: str, free: int) -> str:
    """Return why Fast DDS would lose messages for want of shared memory; empty if it would not.

    It has room for what a node sends then, but not for what it receives, and tells nobody.

    Args:
        environment: The environment of this process.
        middleware: The name of the RMW implementation.
        free: How many bytes are left.
    """
    if free < _SEGMENT_BYTES or not _is_bound_to_memory(environment):
        return ""
    short = _short_memory(environment, middleware, free)
    return short and f"{short}, or it loses messages; free some: fastdds shm clean"


def spare_shared_memory(environment: MutableMapping[str, str], middleware: str, free: int) -> str:
    """Have Fast DDS do without shared memory where that is short; return that in one line.

    To be called before the first participant of a process; the arguments are those of
    `memory_fault`.
    """
    short = _short_memory(environment, middleware, free)
    if short and not _is_bound_to_memory(environment):
        environment[_TRANSPORTS] = "UDPv4"
    return short and f"{short}: it uses UDP alone"


def _short_memory(environment: Mapping[str, str], middleware: str, free: int) -> str:
    if free >= _NEEDED_BYTES or not middleware.startswith("rmw_fastrtps"):
        return ""
    if any(environment.get(name) for name in _PROFILES):
        # The user has said how, in more detail than can be judged here.
        return ""
    if _chosen(environment) in _WITHOUT_MEMORY and not _is_local(environment):
        return ""
    return (
        f"{SHARED_MEMORY} has {free / _MEGABYTE:.1f} MB left, and Fast DDS needs"
        f" {_NEEDED_BYTES / _MEGABYTE:.0f} MB"
    )


def _is_bound_to_memory(environment: Mapping[str, str]) -> bool:
    """Whether it is not for us to choose the transports."""
    return _is_local(environment) or bool(_chosen(environment))


def _chosen(environment: Mapping[str, str]) -> str:
    return environment.get(_TRANSPORTS, "").upper()


def _is_local(environment: Mapping[str, str]) -> bool:
    """Whether this machine's nodes alone are to be seen: rmw_fastrtps sets up both transports."""
    limit = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").upper()
    return limit == "LOCALHOST" or environment.get("ROS_LOCALHOST_ONLY") == "1"


def date_refusal(now_ns: int, middleware: str) -> str:
    """Return why a middleware sends nothing at a date of this machine; empty if it does.

    Fast DDS keeps the seconds in 32 bits and refuses negative ones (`write_w_timestamp`), so it
    sends again from 2106 on. Before 1970 its threads turn in circles.
    """
    seconds = (now_ns // 1_000_000_000 + 2**31) % 2**32 - 2**31
    if not middleware.startswith("rmw_fastrtps") or (seconds >= 0 and now_ns >= 0):
        return ""
    return f"{date_fault(now_ns)}: {middleware} sends nothing at such a date; set the clock"
