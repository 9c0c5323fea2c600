"""State of a child process as the program sees it; in a replay, as the recording has it."""

from collections.abc import Callable
from typing import Any, Generic, TypeVar, overload

from rosbase.entries.current import is_replay_next, running_conductor

__all__ = ["Observed", "is_replay", "observed"]

ValueT = TypeVar("ValueT", bool, int, int | None)


class Observed(Generic[ValueT]):
    """An attribute that changes by itself, such as whether a child is alive."""

    _name: str

    def __set_name__(self, owner: type, name: str) -> None:
        """Note its name."""
        self._name = name

    @overload
    def __get__(self, of: None, owner: type) -> "Observed[ValueT]": ...

    @overload
    def __get__(self, of: object, owner: type) -> ValueT: ...

    def __get__(self, of: object | None, owner: type) -> Any:
        """Return the value that the program sees."""
        if of is None:
            return self
        value = vars(of)[self._name]
        return observed(lambda: value)

    def __set__(self, of: object, value: ValueT) -> None:
        """Set the value."""
        vars(of)[self._name] = value


def observed(read: Callable[[], ValueT]) -> ValueT:
    """Return what a function reads of a child; in a replay, what it read when it was recorded."""
    conductor = running_conductor()
    if conductor is None:
        return read()
    seen: Any = conductor.fact(read)
    return seen  # type: ignore[no-any-return]  # JSON has all of these types


def is_replay() -> bool:
    """Return whether the program is replayed, so that it has no children."""
    conductor = running_conductor()
    return is_replay_next() or (conductor is not None and conductor.is_replay)
