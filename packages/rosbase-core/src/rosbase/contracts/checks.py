"""The contract of checks: the context that `rosbase doctor` passes to a check, and its findings.

A check yields findings, one after another, and may wait for answers. Each check runs on its own
thread, at the same time as the others, and has some seconds. A check that takes longer is left
behind, and one that raises is shown as broken. Neither harms the others.

A check must give advice for every fault, and leave everything as it was, because a program may be
running meanwhile. It must not write to stdout or stderr, or end the process. If a library may end
the process, call it in a child process.
"""

from collections.abc import Mapping
from enum import Enum

from attrs import Attribute, field, frozen

from rosbase.clock import Clock
from rosbase.parameters import ParameterValue
from rosbase.text.printable import one_line

__all__ = ["CheckContext", "Finding", "Outcome"]


class Outcome(Enum):
    """Outcome of a finding."""

    OK = "ok"
    WARN = "warn"
    """A possible problem: it may be intended, or may matter later."""
    FAIL = "fail"
    """A request of the user cannot work."""
    SKIP = "skip"
    """Not checked, or not needed by the user."""


def _says_what_to_do(instance: "Finding", attribute: "Attribute[str]", value: str) -> None:
    if not value and instance.outcome in (Outcome.WARN, Outcome.FAIL):
        raise ValueError(f"the finding {instance.text!r} does not say what to do")


@frozen
class Finding:
    """Finding of a check in one line, with one line of advice."""

    outcome: Outcome
    text: str = field(converter=one_line)
    """The finding."""
    advice: str = field(default="", converter=one_line, validator=_says_what_to_do)
    """Advice for the user, best a command. Never missing where the outcome is WARN or FAIL."""


@frozen
class CheckContext:
    """Context that a check receives."""

    clock: Clock
    values: Mapping[str, ParameterValue]
    """Parameters of a reader and of the installed transports, as given or by default."""
    given: frozenset[str] = frozenset()
    """Names of the parameters that the user has given."""

    def asks_for(self, transport: str, parameter: str) -> bool:
        """Return whether the user asked for that transport, or for the device in this parameter.

        Something that is absent is no fault if nobody asked for it.
        """
        is_chosen = "comm_t" in self.given and self.values["comm_t"] == transport
        return is_chosen or parameter in self.given
