"""Checks of ROS 2 for `rosbase doctor`: rclpy, its middleware, the domain, shared memory."""

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from attrs import frozen

from rosbase import Finding, Outcome, SystemClock, date_fault
from rosbase_ros2.imports import (
    NO_SHARED_MEMORY,
    NO_SUCH_MIDDLEWARE,
    memory_is_full,
    no_such_middleware,
    python_command,
)
from rosbase_ros2.machine import (
    SHARED_MEMORY,
    clashing_ports,
    domain_fault,
    free_bytes,
    read_domain,
    spare_shared_memory,
)

__all__ = ["check_ros"]

# Starting ROS takes a second; on a machine with much to do, several.
_PROBE_S = 12.0
_INDEX = "share/ament_index/resource_index/rmw_typesupport"
# Has an entry there, and is none: it loads one of the others.
_NO_MIDDLEWARE = "rmw_implementation"
_SAFE = "a number from 0 to 101"
_FREE_MEMORY = (
    f"`fastdds shm clean` removes what killed programs have left in {SHARED_MEMORY};"
    " in a container, give it more: docker run --shm-size=64m"
)
_INSTALL = "pip install 'ros-jazzy-rclpy[fastrtps]'; where ROS is installed: source its setup.bash"


def check_ros() -> Iterable[Finding]:
    """Report whether a node can be started, with which middleware, and in which domain."""
    domain = _check_domain()
    # A node in a domain that is none says little of anything else.
    unwanted = {"ROS_DOMAIN_ID"} if domain.outcome is Outcome.FAIL else set()
    environment = {name: text for name, text in os.environ.items() if name not in unwanted}
    yield from _check_node(environment)
    yield domain


def _check_node(environment: Mapping[str, str]) -> Iterable[Finding]:
    named = environment.get("RMW_IMPLEMENTATION", "")
    there = ", ".join(_middlewares()) or "none"
    answer = _ask_child(environment)
    if answer.status == NO_SUCH_MIDDLEWARE:
        advice = f"unset it, install it, or use one of {there}"
        yield Finding(Outcome.FAIL, no_such_middleware(named), advice)
    elif answer.status == NO_SHARED_MEMORY:
        yield Finding(Outcome.FAIL, memory_is_full(free_bytes()), _FREE_MEMORY)
    elif answer.rclpy_failure:
        yield Finding(Outcome.FAIL, answer.rclpy_failure, _INSTALL)
    elif answer.failure:
        found = f"no node can be started: {answer.failure}"
        yield Finding(Outcome.FAIL, found, _advice(answer.failure))
    else:
        chosen = f"is {named}" if named else "is not set"
        yield Finding(Outcome.OK, "rclpy is there, and a node can be started")
        yield Finding(
            Outcome.OK,
            f"the middleware is {answer.middleware}; RMW_IMPLEMENTATION {chosen}; there: {there}",
        )
        if short := spare_shared_memory(dict(environment), answer.middleware, free_bytes()):
            yield Finding(Outcome.WARN, short, _FREE_MEMORY)


def _advice(failure: str) -> str:
    """Return advice for a node that does not start."""
    if str(SHARED_MEMORY) in failure:
        return _FREE_MEMORY
    if date_fault(SystemClock().now_ns()):
        return "set the clock: sudo timedatectl set-ntp true, or sudo date -s 'YYYY-MM-DD HH:MM'"
    return "check the variables ROS_*, RMW_*, FASTRTPS_* and FASTDDS_* of the environment"


def _check_domain() -> Finding:
    text = os.environ.get("ROS_DOMAIN_ID", "")
    if not text:
        return Finding(Outcome.OK, f"the domain is 0; ROS_DOMAIN_ID is not set{_range()}")
    if fault := domain_fault(os.environ):
        return Finding(Outcome.FAIL, fault, f"unset it, or set it to {_SAFE}")
    number = read_domain(text)
    assert number is not None
    if clashing_ports(number):
        return Finding(
            Outcome.WARN,
            f"the domain is {number}, whose ports other programs may use",
            f"set ROS_DOMAIN_ID to {_SAFE}, on every machine",
        )
    if text.strip() != str(number):
        return Finding(
            Outcome.WARN,
            f"ROS_DOMAIN_ID is {text!r}, which ROS reads as {number}, as in C",
            f"write {number}, if that is what you mean",
        )
    return Finding(Outcome.OK, f"the domain is {number}, as ROS_DOMAIN_ID says{_range()}")


def _range() -> str:
    """Return which machines are seen, if that is not the usual range."""
    if os.environ.get("ROS_LOCALHOST_ONLY") == "1":
        return "; nodes of this machine alone are seen: ROS_LOCALHOST_ONLY is 1"
    limit = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE")
    return f"; ROS_AUTOMATIC_DISCOVERY_RANGE is {limit}" if limit else ""


def _middlewares() -> list[str]:
    """Return the installed RMW implementations, from the index of ROS."""
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    indexes = [Path(prefix, _INDEX) for prefix in prefixes if prefix]
    names = {entry.name for index in indexes if index.is_dir() for entry in index.iterdir()}
    return sorted(names - {_NO_MIDDLEWARE})


@frozen
class _Answer:
    """Answer of the child process, and its exit status."""

    status: int = 0
    middleware: str = ""
    rclpy_failure: str = ""
    """Reason why rclpy cannot be imported."""
    failure: str = ""
    """Other reason why there is no node."""


def _ask_child(environment: Mapping[str, str]) -> _Answer:
    try:
        done = subprocess.run(
            python_command("from rosbase_ros2.probe import main; main()"),
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
            timeout=_PROBE_S,
        )
    except subprocess.TimeoutExpired:
        return _Answer(failure=f"ROS has not started within {_PROBE_S:g} s")
    lines = done.stdout.decode(errors="replace").strip().splitlines() or ["without a word"]
    for line in lines:
        if line.startswith("{"):
            return _Answer(**json.loads(line))
    return _Answer(done.returncode, failure=f"the process ends: {lines[-1]}")
