"""The keys that a mapping knows in each object, to tell a zero that is left out from an error."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from rosbase.mapping.following import MISSING, follow
from rosbase.mapping.paths import EACH, Condition, Steps, Where

__all__ = ["Keys", "KnownKeys", "condition_places", "is_left_out", "plain_of"]


class Keys(NamedTuple):
    """The keys that a mapping knows in one object."""

    read: frozenset[str]
    """Keys on the way to a number."""
    tested: frozenset[str]
    """Keys in conditions. They say what an object is, not that it holds a reading."""

    def is_misspelt(self, key: str, found: dict[str, object]) -> bool:
        """Return whether an object without a key has it in other letter case."""
        lower = key.casefold()
        return any(other.casefold() == lower for other in self._unknown(found))

    def holds_reading(self, found: dict[str, object]) -> bool:
        """Return whether an object may be a reading: it is not about something else alone."""
        return not self._unknown(found) or not self.read.isdisjoint(found)

    def _unknown(self, found: dict[str, object]) -> set[str]:
        return found.keys() - self.read - self.tested


class KnownKeys:
    """The keys that a whole mapping knows."""

    def __init__(self, ways: Iterable[Steps], conditions: Iterable[Condition]) -> None:
        """Collect the keys.

        Args:
            ways: All ways of the mapping.
            conditions: The conditions on the payload itself.
        """
        self._read: dict[Steps, set[str]] = {}
        self._tested: dict[Steps, set[str]] = {}
        for path in (path for condition in conditions for path in condition.paths):
            _collect(self._tested, (), path)
        for steps in ways:
            _collect(self._read, (), plain_of(steps))
            for place, condition in condition_places(steps):
                for path in condition.paths:
                    _collect(self._tested, place, path)

    def along(self, steps: Steps) -> tuple[Keys, ...]:
        """Return the keys known in the object in front of each step."""
        places = [plain_of(steps[:at]) for at in range(len(steps))]
        return tuple(
            Keys(frozenset(self._read.get(p, ())), frozenset(self._tested.get(p, ())))
            for p in places
        )


def is_left_out(value: object, steps: Steps, keys: Sequence[Keys]) -> bool:
    """Return whether the steps lead to nothing as when an encoder leaves out a zero.

    Args:
        value: The value at which the steps begin.
        steps: Keys, indices and conditions; not `[*]`.
        keys: The keys known in the object in front of each step.
    """
    if not steps or not isinstance(steps[-1], str):
        return False
    for step, known in zip(steps, keys, strict=True):
        found = follow(value, (step,))
        if found is MISSING:
            return (
                isinstance(step, str)
                and isinstance(value, dict)
                and known.holds_reading(value)
                and not known.is_misspelt(step, value)
            )
        value = found
    return False


def plain_of(steps: Steps) -> Steps:
    """Return the steps without conditions."""
    return tuple(step for step in steps if not isinstance(step, Where))


def condition_places(steps: Steps) -> Iterator[tuple[Steps, Condition]]:
    """Return the conditions of a way, and the plain way to what must meet them."""
    for at, step in enumerate(steps):
        if isinstance(step, Where):
            # Before a `[*]`, each element must meet them.
            is_each = steps[at + 1 : at + 2] == (EACH,)
            place = (*plain_of(steps[:at]), *((EACH,) if is_each else ()))
            yield from ((place, condition) for condition in step.conditions)


def _collect(into: dict[Steps, set[str]], place: Steps, steps: Steps) -> None:
    for at, step in enumerate(steps):
        if isinstance(step, (str, int)):
            into.setdefault((*place, *steps[:at]), set()).add(str(step))
