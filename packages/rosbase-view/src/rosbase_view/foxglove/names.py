"""Names that clients see, which are the same in several programs. Pure."""

from collections.abc import Hashable, Mapping
from typing import Generic, TypeVar

__all__ = ["NameTable", "candidates"]

KeyT = TypeVar("KeyT", bound=Hashable)


def candidates(name: str, program: str, pid: int) -> tuple[str, ...]:
    """Return the names for a topic, node or service of a program, by preference."""
    prefix = f"/{program.strip('/')}"
    return name, f"{prefix}{name}", f"{prefix}_{pid}{name}"


class NameTable(Generic[KeyT]):
    """Gives each thing a name of its own, which it keeps as long as it is there."""

    def __init__(self) -> None:
        """Begin with no names."""
        self._names: dict[KeyT, str] = {}

    def update(self, wanted: Mapping[KeyT, tuple[str, ...]]) -> dict[str, KeyT]:
        """Return what has which name.

        Args:
            wanted: Names for each thing, by preference. A thing is left out if all of them are
                taken.
        """
        # What has gone leaves its name to what has come in the same moment.
        self._names = {key: name for key, name in self._names.items() if key in wanted}
        taken = set(self._names.values())
        for key, names in wanted.items():
            if key in self._names:
                continue
            name = next((name for name in names if name not in taken), None)
            if name is not None:
                self._names[key] = name
                taken.add(name)
        return {name: key for key, name in self._names.items()}
