"""How well a reader is: a level, and one line that says why."""

import re
from enum import IntEnum

from attrs import Factory, field, frozen

__all__ = ["Health", "HealthLevel", "without_figures"]

_FIGURE = re.compile(r"-?\d+(\.\d+)?(e[+-]?\d+)?")


class HealthLevel(IntEnum):
    """The values are those of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@frozen
class Health:
    """A level, and why, in one line."""

    level: HealthLevel
    message: str
    kind: str = field(default=Factory(lambda self: without_figures(self.message), takes_self=True))
    """What the message says, without its figures: they change, and it is no other message."""

    def says_the_same_as(self, other: "Health") -> bool:
        """Return whether nothing but the figures differs."""
        return (self.level, self.kind) == (other.level, other.kind)


def without_figures(message: str) -> str:
    """Return the message with `#` in place of each number."""
    return _FIGURE.sub("#", message)
