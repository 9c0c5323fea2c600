"""Health of a reader: a level, and one line that says why."""

import re
from enum import IntEnum

from attrs import Factory, field, frozen

__all__ = ["Health", "HealthLevel", "without_figures"]

_FIGURE = re.compile(r"-?\d+(\.\d+)?(e[+-]?\d+)?")


class HealthLevel(IntEnum):
    """Level of health, with the values of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@frozen
class Health:
    """Health of a reader: a level and the reason in one line."""

    level: HealthLevel
    message: str
    kind: str = field(default=Factory(lambda self: without_figures(self.message), takes_self=True))
    """Message without its numbers: if only they change, it is the same message."""

    def says_the_same_as(self, other: "Health") -> bool:
        """Return whether only the numbers differ."""
        return (self.level, self.kind) == (other.level, other.kind)


def without_figures(message: str) -> str:
    """Return the message with `#` in place of each number."""
    return _FIGURE.sub("#", message)
