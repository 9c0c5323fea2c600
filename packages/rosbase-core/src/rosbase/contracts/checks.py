"""The contract of checks: what `rosbase doctor` gives one, and what it finds.

A check gives findings, one after another, and may wait for what it asks. Each runs on a thread
of its own, at the same time as the others, and has some seconds: one that takes longer is left
behind, and one that raises is shown as broken, and neither harms the others.

Must: say what to do about whatever is not as it should be; leave everything as it was, because a
program may be at work meanwhile. Must not: write to stdout or stderr; end the process, which a
library may do, so one that does is asked from a child process.
"""

from collections.abc import Mapping
from enum import Enum

from attrs import Attribute, field, frozen

from rosbase.clock import Clock
from rosbase.parameters import ParameterValue
from rosbase.text.printable import one_line

__all__ = ["CheckContext", "Finding", "Outcome"]


class Outcome(Enum):
    """How something is."""

    OK = "ok"
    WARN = "warn"
    """It may be meant so, or may matter later."""
    FAIL = "fail"
    """What the user asks for cannot work."""
    SKIP = "skip"
    """It has not been looked at, or the user does without it."""


def _says_what_to_do(instance: "Finding", attribute: "Attribute[str]", value: str) -> None:
    if not value and instance.outcome in (Outcome.WARN, Outcome.FAIL):
        raise ValueError(f"the finding {instance.text!r} does not say what to do")


@frozen
class Finding:
    """One thing that a check has found, as one line, and what to do about it, as another."""

    outcome: Outcome
    text: str = field(converter=one_line)
    """What is so."""
    advice: str = field(default="", converter=one_line, validator=_says_what_to_do)
    """What the user may do, best a command. Never missing where the outcome is WARN or FAIL."""


@frozen
class CheckContext:
    """What a check is given."""

    clock: Clock
    values: Mapping[str, ParameterValue]
    """The parameters of a reader and of the installed transports, as given or by default."""
    given: frozenset[str] = frozenset()
    """The names of those that the user has given."""

    def asks_for(self, transport: str, parameter: str) -> bool:
        """Whether the user has named that transport, or the device that is this parameter of it.

        What nobody has asked for and is not there is no fault.
        """
        is_chosen = "comm_t" in self.given and self.values["comm_t"] == transport
        return is_chosen or parameter in self.given
