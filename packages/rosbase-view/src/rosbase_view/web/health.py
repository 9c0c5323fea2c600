"""The health of a board, from what its program tells on `/diagnostics`. Pure."""

from collections.abc import Mapping
from typing import Any

from attrs import frozen

from rosbase.text.printable import printable

__all__ = ["DIAGNOSTICS", "TOPIC", "Health", "Status"]

DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
TOPIC = "/diagnostics"
"""Topic that the tools of ROS read (REP-107)."""

_LEVELS = ("OK", "WARN", "ERROR", "STALE")
_MOST = 20
# A publisher reports once a second.
_FRESH_NS = 5_000_000_000


@frozen
class Status:
    """A line of the health: `OK`, `WARN`, `ERROR` or `STALE`, whose it is, and why."""

    level: str
    name: str
    message: str


class Health:
    """The newest status of each name."""

    def __init__(self) -> None:
        """Begin with none."""
        self._found: dict[str, tuple[Status, int]] = {}

    def take(self, message: Mapping[str, Any], now_ns: int) -> None:
        """Take a DiagnosticArray, at a monotonic time."""
        for one in message["status"]:
            status = Status(_level(one["level"]), printable(one["name"]), printable(one["message"]))
            self._found.pop(status.name, None)
            self._found[status.name] = (status, now_ns)
        while len(self._found) > _MOST:
            del self._found[next(iter(self._found))]

    def statuses(self, now_ns: int | None) -> list[Status]:
        """Return what was told, by name; what was not told again for five seconds is stale.

        Args:
            now_ns: Monotonic time; None for a recording, which may stand still.
        """
        return [
            status
            if now_ns is None or now_ns - told_ns <= _FRESH_NS
            else Status("STALE", status.name, f"silent; before: {status.message}")
            for status, told_ns in (self._found[name] for name in sorted(self._found))
        ]


def _level(value: Any) -> str:
    number = value[0] if isinstance(value, bytes) else int(value)
    return _LEVELS[number] if number < len(_LEVELS) else "ERROR"
