"""Finds list elements that look like the one that a mapping takes, and that it does not take.

A device that sends four samples where the mapping reads the first would lose three of four in
silence; one that sends two sensors would have the wrong one read when their order changes.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

from rosbase.mapping.following import MISSING, follow, matching
from rosbase.mapping.paths import EACH, Steps, Way, Where, show_steps
from rosbase.mapping.rejects import Reject

__all__ = ["Covered", "Guard", "covered_indices", "elements_at", "guards_of", "surplus_at"]

Covered: TypeAlias = dict[Steps, frozenset[int]]
"""By the way to a list: the indices that a mapping reads in it."""


class Guard(NamedTuple):
    """An index of a path, and which other indices of the same list the mapping reads."""

    to_list: Steps
    rest: Steps
    """The way on from the element to the number; empty if the element is the number."""
    covered: frozenset[int]


def covered_indices(ways: Iterable[Steps]) -> Covered:
    """Return the indices that these ways and the conditions in them name, by list."""
    covered: Covered = {}
    for steps in ways:
        for plain in _without_conditions(steps):
            for at, step in enumerate(plain):
                if isinstance(step, int):
                    covered[plain[:at]] = covered.get(plain[:at], frozenset()) | {step}
    return covered


def _plain(steps: Steps) -> Steps:
    return tuple(step for step in steps if not isinstance(step, Where))


def _without_conditions(steps: Steps) -> Iterator[Steps]:
    """The way alone, and the ways of its conditions from the top of the payload."""
    plain: Steps = ()
    for step in steps:
        if isinstance(step, Where):
            yield from (plain + path for condition in step.conditions for path in condition.paths)
        else:
            plain = (*plain, step)
    yield plain


def guards_of(way: Way, covered: Covered, *, is_whole: bool) -> Iterator[Guard]:
    """Return what is to be looked at when a number is read.

    Args:
        way: The way to the number.
        covered: The indices that the whole mapping reads.
        is_whole: Whether the last step comes of a path to a whole list, whose length is
            checked anyhow.
    """
    steps = way.steps
    for at, step in enumerate(steps[:-1] if is_whole else steps):
        if isinstance(step, int):
            yield Guard(steps[:at], steps[at + 1 :], covered[_plain(steps[:at])])


def surplus_at(value: object, guards: Sequence[Guard]) -> Reject | None:
    """Return why a list holds more of the same than the mapping reads, if one does."""
    for guard in guards:
        found = follow(value, guard.to_list)
        if isinstance(found, list) and _holds_more(found, guard):
            return Reject("surplus", f"{len(found)} elements at {show_steps(guard.to_list)}")
    return None


def elements_at(value: object, steps: Steps) -> list[object] | Reject:
    """Return the elements of the list that the steps before a `[*]` lead to; none if it is none.

    Conditions directly before the `[*]` select among the elements.
    """
    if steps and isinstance(steps[-1], Where):
        found = follow(value, steps[:-1])
        if isinstance(found, list):
            return matching(found, steps[-1])
    found = follow(value, steps)
    return found if isinstance(found, (list, Reject)) else []


def _holds_more(elements: list[object], guard: Guard) -> bool:
    if not guard.rest:
        # Numbers side by side, as [ax, ay, az, gx, gy, gz]. What follows them may be anything,
        # but for the same once more.
        size = len(guard.covered)
        return len(elements) > size and not len(elements) % size and max(guard.covered) < size
    others = (element for at, element in enumerate(elements) if at not in guard.covered)
    return any(_leads_somewhere(element, guard.rest) for element in others)


def _leads_somewhere(value: object, steps: Steps) -> bool:
    if EACH in steps:
        at = steps.index(EACH)
        found = elements_at(value, steps[:at])
        return isinstance(found, Reject) or any(_leads_somewhere(e, steps[at + 1 :]) for e in found)
    found = follow(value, steps)
    return found is not MISSING and found is not None
