"""The conductor that the next program of this process gets, if there is one."""

from collections.abc import Callable

from rosbase.clock import Clock
from rosbase.entries.conductor import Conductor

__all__ = ["conduct_next", "conducted"]

MakeConductor = Callable[[Clock], Conductor]

_waiting: list[MakeConductor] = []


def conduct_next(make: MakeConductor | None) -> None:
    """Record or replay the next program that opens a backend in this process, and no other.

    Args:
        make: Makes its conductor, of the clock that it would have. None takes back what nobody has
            used.
    """
    _waiting[:] = [make] if make is not None else []


def conducted(clock: Clock) -> Clock:
    """Return the clock for a program that opens a backend now: its own, or a conducted one."""
    return _waiting.pop()(clock).clock if _waiting else clock
