"""Requirements of ROS on this machine, checked before it starts.

They are a domain, shared memory and a date.

If one of them is missing, rcl or DDS end the process, hang, or lose messages silently. So they are
checked before, here and by `rosbase doctor`.
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
"""Range of domains whose ports are valid port numbers (DDS-RTPS 2.3, 9.6.1.1)."""

SHARED_MEMORY = Path("/dev/shm")
"""Folder of shared memory on Linux."""

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
    """Return why the domain is invalid, in one line; empty if it is valid."""
    text = environment.get("ROS_DOMAIN_ID", "")
    if not text or read_domain(text) is not None:
        return ""
    return f"ROS_DOMAIN_ID is {text!r}, and a domain is a number from 0 to {DOMAINS[-1]}"


def clashing_ports(domain: int) -> bool:
    """Return whether the system may have given the ports of a domain to any other program."""
    try:
        first, last = map(int, _EPHEMERAL_PORTS.read_text().split())
    except (OSError, ValueError):
        # Linux's own default.
        first, last = 32768, 60999
    begin = _PORT_BASE + _PORTS_PER_DOMAIN * domain
    return begin <= last and first < begin + _USUAL_PORTS


def free_bytes(folder: Path = SHARED_MEMORY) -> int:
    """Return how many bytes of shared memory are left; 0 if there is none."""
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
    """Return why Fast DDS would lose messages for lack of shared memory; empty if it would not.

    Then it has room for the messages that a node sends, but not for those that it receives,
    and reports nothing.

    Args:
        environment: The environment of this process.
        middleware: The name of the RMW implementation.
        free: Number of bytes left.
    """
    if free < _SEGMENT_BYTES or not _is_bound_to_memory(environment):
        return ""
    short = _short_memory(environment, middleware, free)
    return short and f"{short}, or it loses messages; free some: fastdds shm clean"


def spare_shared_memory(environment: MutableMapping[str, str], middleware: str, free: int) -> str:
    """Turn off Fast DDS's shared memory where it is short; return that in one line.

    Call it before the first participant of a process is created. It takes the arguments of
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
    """Return whether the user has already chosen the transports."""
    return _is_local(environment) or bool(_chosen(environment))


def _chosen(environment: Mapping[str, str]) -> str:
    return environment.get(_TRANSPORTS, "").upper()


def _is_local(environment: Mapping[str, str]) -> bool:
    """Return whether only local nodes are visible: rmw_fastrtps sets up both transports."""
    limit = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").upper()
    return limit == "LOCALHOST" or environment.get("ROS_LOCALHOST_ONLY") == "1"


def date_refusal(now_ns: int, middleware: str) -> str:
    """Return why a middleware sends nothing at a date of this machine; empty if it does.

    Fast DDS keeps the seconds in 32 bits and refuses negative ones (`write_w_timestamp`), so
    it sends again from 2106 on. Before 1970 its threads loop forever.
    """
    seconds = (now_ns // 1_000_000_000 + 2**31) % 2**32 - 2**31
    if not middleware.startswith("rmw_fastrtps") or (seconds >= 0 and now_ns >= 0):
        return ""
    return f"{date_fault(now_ns)}: {middleware} sends nothing at such a date; set the clock"
