"""What `rosbase doctor` is told of ROS 2: rclpy, its middleware, and the domain."""

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from attrs import frozen

from rosbase import Finding, Outcome
from rosbase_ros2.imports import NO_SUCH_MIDDLEWARE, no_such_middleware

__all__ = ["check_ros"]

# Starting ROS takes a second; on a machine with much to do, several.
_PROBE_S = 12.0
_INDEX = "share/ament_index/resource_index/rmw_typesupport"
# Has an entry there, and is none: it loads one of the others.
_NO_MIDDLEWARE = "rmw_implementation"
_DOMAINS = range(233)
# The ports of the others may be those that Linux gives to anybody.
_SAFE_DOMAINS = range(102)
_INSTALL = "pip install 'ros-jazzy-rclpy[fastrtps]'; where ROS is installed: source its setup.bash"


def check_ros() -> Iterable[Finding]:
    """Whether a node can be started, by which middleware, and in which domain."""
    domain = _check_domain(os.environ.get("ROS_DOMAIN_ID", ""))
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
        advice = f"unset it, install it, or name one that is there: {there}"
        yield Finding(Outcome.FAIL, no_such_middleware(named), advice)
    elif answer.rclpy_failure:
        yield Finding(Outcome.FAIL, answer.rclpy_failure, _INSTALL)
    elif answer.failure:
        advice = "look at the variables ROS_*, RMW_*, FASTRTPS_* and FASTDDS_* of the environment"
        yield Finding(Outcome.FAIL, f"no node can be started: {answer.failure}", advice)
    else:
        chosen = f"is {named}" if named else "is not set"
        yield Finding(Outcome.OK, "rclpy is there, and a node can be started")
        yield Finding(
            Outcome.OK,
            f"the middleware is {answer.middleware}; RMW_IMPLEMENTATION {chosen}; there: {there}",
        )


def _check_domain(text: str) -> Finding:
    if not text:
        return Finding(Outcome.OK, f"the domain is 0; ROS_DOMAIN_ID is not set{_range()}")
    number = int(text) if text.strip().isdecimal() else -1
    if number not in _DOMAINS:
        advice = f"unset it, or set it to a number from 0 to {_SAFE_DOMAINS[-1]}"
        return Finding(Outcome.FAIL, f"ROS_DOMAIN_ID is {text!r}, which is no domain", advice)
    if number not in _SAFE_DOMAINS:
        return Finding(
            Outcome.WARN,
            f"the domain is {number}, whose ports another program may happen to have",
            f"set ROS_DOMAIN_ID to a number from 0 to {_SAFE_DOMAINS[-1]}, on every machine",
        )
    return Finding(Outcome.OK, f"the domain is {number}, as ROS_DOMAIN_ID says{_range()}")


def _range() -> str:
    """Which machines are seen, if that is not the usual."""
    if os.environ.get("ROS_LOCALHOST_ONLY") == "1":
        return "; nodes of this machine alone are seen: ROS_LOCALHOST_ONLY is 1"
    limit = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE")
    return f"; ROS_AUTOMATIC_DISCOVERY_RANGE is {limit}" if limit else ""


def _middlewares() -> list[str]:
    """The RMW implementations that are installed, as the index of ROS has them."""
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep), sys.prefix]
    indexes = [Path(prefix, _INDEX) for prefix in prefixes if prefix]
    names = {entry.name for index in indexes if index.is_dir() for entry in index.iterdir()}
    return sorted(names - {_NO_MIDDLEWARE})


@frozen
class _Answer:
    """What the child process says, and the status that it ended with."""

    status: int = 0
    middleware: str = ""
    rclpy_failure: str = ""
    """Why rclpy cannot be imported."""
    failure: str = ""
    """Why else there is no node."""


def _ask_child(environment: Mapping[str, str]) -> _Answer:
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-m", "rosbase_ros2.probe"],
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
