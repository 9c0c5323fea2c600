"""Quality of service that users set from outside, for rclpy's `QoSOverridingOptions`.

The parameter `qos_overrides./imu/data.publisher.reliability` overrides that policy of every
publisher of the topic. A name with `.subscription.` overrides it for every subscription.
Overrides without effect are named: at once if they cannot have any, else when a similar name is
used, or at the end.
"""

from collections.abc import Callable, Mapping
from typing import Any

from rclpy import qos
from rclpy.qos import QoSPolicyKind
from rclpy.qos_overriding_options import QoSOverridingOptions

from rosbase import ParameterError, did_you_mean

__all__ = ["PREFIX", "QoSOverrides"]

PREFIX = "qos_overrides."
"""Prefix of such parameters."""

_WORDS = {
    "durability": qos.DurabilityPolicy,
    "history": qos.HistoryPolicy,
    "reliability": qos.ReliabilityPolicy,
}
_POLICIES = (*_WORDS, "depth")
_ENDS = ("publisher", "subscription")


class QoSOverrides:
    """Overrides that one node was given."""

    def __init__(self, given: Mapping[str, Any], warn: Callable[[str], object]) -> None:
        """Read the overrides.

        Args:
            given: The parameters that the node was given from outside.
            warn: Called with a line about an override without effect.

        Raises:
            ParameterError: A value is invalid for its policy.
        """
        self._warn = warn
        self._kinds: dict[tuple[str, str], dict[str, QoSPolicyKind]] = {}
        self._created: set[tuple[str, str]] = set()
        self._said: set[tuple[str, str]] = set()
        for name in sorted(given):
            if name.startswith(PREFIX):
                self._read(name, given[name])

    @property
    def is_unused(self) -> bool:
        """Return whether an override's topic has not been created, and it has not been named."""
        return bool(self._unused())

    def options(self, topic: str, end: str) -> QoSOverridingOptions | None:
        """Return which policies of a new publisher or subscription are overridden, if any.

        Args:
            topic: The full name of the topic.
            end: `publisher` or `subscription`.
        """
        self._created.add((topic, end))
        kinds = self._kinds.get((topic, end))
        return QoSOverridingOptions(list(kinds.values())) if kinds else None

    def name_near_misses(self) -> None:
        """Warn of overrides whose topic has not been created, if one with a similar name has."""
        for topic, end in self._unused():
            free = [name for name, kind in self._created - self._kinds.keys() if kind == end]
            if hint := did_you_mean(topic, free):
                self._name((topic, end), f"there is no {end} of {topic}{hint}")

    def name_unused(self) -> None:
        """Warn of overrides whose topic was never created. Called at the end."""
        for topic, end in self._unused():
            self._name((topic, end), f"there was no {end} of {topic}")

    def _read(self, name: str, value: Any) -> None:
        topic, end, policy = ([*name.removeprefix(PREFIX).split("."), "", ""])[:3]
        fault = ""
        if not topic.startswith("/"):
            fault = f"the topic is given by its full name; did you mean /{topic}?"
        elif end not in _ENDS:
            fault = f"{end!r} is not publisher or subscription{did_you_mean(end, _ENDS)}"
        elif policy not in _POLICIES or name.count(".") != 3:
            known = ", ".join(sorted(_POLICIES))
            fault = f"the policy is one of {known}{did_you_mean(policy, _POLICIES)}"
        if fault:
            self._warn(f"parameter {name} has no effect: {fault}")
            return
        _check_value(name, policy, value)
        self._kinds.setdefault((topic, end), {})[name] = QoSPolicyKind[policy.upper()]

    def _unused(self) -> list[tuple[str, str]]:
        return sorted(self._kinds.keys() - self._created - self._said)

    def _name(self, where: tuple[str, str], fault: str) -> None:
        self._said.add(where)
        for name in self._kinds[where]:
            self._warn(f"parameter {name} has no effect: {fault}")


def _check_value(name: str, policy: str, value: Any) -> None:
    """Refuse a value that rclpy would refuse when the publisher or subscription is created."""
    if policy == "depth":
        if type(value) is not int or value < 1:
            raise ParameterError(f"parameter {name} is a whole number from 1 up, not {value!r}")
        return
    words = [word.lower() for word in _WORDS[policy].__members__ if word != "UNKNOWN"]
    if not isinstance(value, str) or value.lower() not in words:
        raise ParameterError(f"parameter {name} is one of {', '.join(words)}, not {value!r}")
