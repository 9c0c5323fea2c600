"""Find list elements like the one that a mapping reads, which the mapping does not read.

If a device sends four samples and the mapping reads the first, three of four are lost. If it sends
two sensors and the mapping reads the first, a change of their order is a wrong number.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

from rosbase.mapping.following import MISSING, follow, matching
from rosbase.mapping.known_keys import condition_places, plain_of
from rosbase.mapping.paths import EACH, Steps, Way, Where, show_steps
from rosbase.mapping.rejects import Reject

__all__ = ["Covered", "Guard", "covered_indices", "elements_at", "guards_of", "surplus_at"]

Covered: TypeAlias = dict[Steps, frozenset[int]]
"""The indices that a mapping names in a list, by the way to the list."""


class Guard(NamedTuple):
    """An index on a way, with the other indices that the mapping names in the same list."""

    to_list: Steps
    rest: Steps
    """The way from the element to the number; empty if the element is the number."""
    covered: frozenset[int]
    first: int
    """The first index at which a quantity is; elements before it belong to the whole list."""


def covered_indices(ways: Iterable[Steps]) -> Covered:
    """Return the indices in these ways and in their conditions, by list."""
    covered: Covered = {}
    for steps in ways:
        named = [(place, path) for place, c in condition_places(steps) for path in c.paths]
        for place, path in [*named, ((), plain_of(steps))]:
            for at, step in enumerate(path):
                if isinstance(step, int):
                    to_list = (*place, *path[:at])
                    covered[to_list] = covered.get(to_list, frozenset()) | {step}
    return covered


def guards_of(
    way: Way, covered: Covered, read: Iterable[Steps], *, is_whole: bool
) -> Iterator[Guard]:
    """Return a guard for each index on the way to a number.

    Args:
        way: The way to the number.
        covered: The indices that the whole mapping names.
        read: The ways to the numbers of all quantities.
        is_whole: Whether the last index comes from a path to a whole list, which needs no guard.
    """
    steps = way.steps
    indices = covered_indices(map(plain_of, read))
    for at, step in enumerate(steps[:-1] if is_whole else steps):
        if isinstance(step, int):
            to_list = plain_of(steps[:at])
            first = min(indices[to_list])
            yield Guard(steps[:at], steps[at + 1 :], covered[to_list], first)


def surplus_at(value: object, guards: Sequence[Guard]) -> Reject | None:
    """Return a `Reject` if a list holds more of the same than the mapping reads."""
    for guard in guards:
        found = follow(value, guard.to_list)
        if isinstance(found, list) and _holds_more(found, guard):
            where = show_steps(guard.to_list) or "the top"
            return Reject("surplus", f"{len(found)} elements at {where}{_cure(found, guard)}")
    return None


def elements_at(value: object, steps: Steps) -> list[object] | Reject:
    """Return the elements for a `[*]` after these steps; empty if they lead to no list.

    Conditions directly before the `[*]` select among the elements.
    """
    if steps and isinstance(steps[-1], Where):
        found = follow(value, steps[:-1])
        if isinstance(found, list):
            return matching(found, steps[-1])
    found = follow(value, steps)
    return found if isinstance(found, (list, Reject)) else []


def _cure(elements: list[object], guard: Guard) -> str:
    if guard.rest or not all(isinstance(step, (str, int)) for step in guard.to_list):
        return ""
    last = show_steps((*guard.to_list, len(elements) - 1))
    return f"; if they are one sample, say so in mapping.select, such as {last}!=null"


def _holds_more(elements: list[object], guard: Guard) -> bool:
    if not guard.rest:
        # Numbers side by side, as in [t, ax, ay, az, gx, gy, gz, temp]. Anything may follow them,
        # except the same numbers once more, with or without those before the first.
        count, size, head = len(elements), max(guard.covered) + 1, guard.first
        return count > size and not (count % size and (count - head) % (size - head))
    others = (element for at, element in enumerate(elements) if at not in guard.covered)
    return any(_leads_somewhere(element, guard.rest) for element in others)


def _leads_somewhere(value: object, steps: Steps) -> bool:
    if EACH in steps:
        at = steps.index(EACH)
        found = elements_at(value, steps[:at])
        return isinstance(found, Reject) or any(_leads_somewhere(e, steps[at + 1 :]) for e in found)
    found = follow(value, steps)
    return found is not MISSING and found is not None
