"""The conductor for the next program of this process, and the one of the running program."""

from collections.abc import Callable

from rosbase.clock import Clock
from rosbase.entries.conductor import Conductor

__all__ = ["conduct_next", "conducted", "is_replay_next", "running_conductor", "set_running"]

MakeConductor = Callable[[Clock], Conductor]

_waiting: list[tuple[MakeConductor, bool]] = []
_running: list[Conductor] = []


def conduct_next(make: MakeConductor | None, *, is_replay: bool = False) -> None:
    """Record or replay the next program that opens a backend in this process, and no other.

    Args:
        make: Makes its conductor, of the clock that it would have. None takes back what nobody has
            used.
        is_replay: Whether the program is replayed.
    """
    _waiting[:] = [(make, is_replay)] if make is not None else []


def is_replay_next() -> bool:
    """Return whether the next program that opens a backend is replayed."""
    return any(is_replay for _, is_replay in _waiting)


def conducted(clock: Clock) -> Clock:
    """Return the clock for a program that opens a backend now: its own, or a conducted one."""
    if not _waiting:
        return clock
    make, _ = _waiting.pop()
    return make(clock).clock


def set_running(conductor: Conductor | None) -> None:
    """Note the conductor of the program that runs, for things that know no clock; None for none."""
    _running[:] = [] if conductor is None else [conductor]


def running_conductor() -> Conductor | None:
    """Return the conductor of the program that runs; None if it has none."""
    for conductor in _running:
        return conductor
    return None
