"""Refuse mappings that read one value of a payload as two things."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

from rosbase.errors import MappingError
from rosbase.mapping.paths import EACH, Condition, Each, Steps, Where, show_condition, show_steps

__all__ = ["check_clashes", "check_conditions"]


def check_clashes(ways: Mapping[str, Sequence[Sequence[Steps]]]) -> None:
    """Check that no two components can be read from the same place of one payload.

    Args:
        ways: By quantity: for each alternative the ways to its components.

    Raises:
        MappingError: Two components of a quantity, or of two quantities, are in one place.
    """
    for name, alternatives in ways.items():
        for components in alternatives:
            _check_components(name, components)
    for name, other_name in combinations(ways, 2):
        others = [steps for components in ways[other_name] for steps in components]
        for one in (steps for components in ways[name] for steps in components):
            if any(_may_meet(one, other) for other in others):
                raise MappingError(
                    f"{name} and {other_name} are both at {show_steps(one)}: tell them apart by "
                    "a condition, such as [kind=acc]"
                )


def check_conditions(conditions: Sequence[Condition]) -> None:
    """Check that a payload can meet all conditions.

    Raises:
        MappingError: Two contradict each other.
    """
    for one, other in combinations(conditions, 2):
        if one.contradicts(other):
            raise MappingError(
                f"mapping.select is never met: {show_condition(one)} and {show_condition(other)}"
            )


def _check_components(name: str, components: Sequence[Steps]) -> None:
    pairs = list(combinations(components, 2))
    for one, other in pairs:
        if _may_meet(one, other):
            raise MappingError(f"two components of {name} are both at {show_steps(one)}")
    for one, other in pairs:
        short, long = sorted((one, other), key=len)
        if short == long[: len(short)]:
            raise MappingError(
                f"{name}: {show_steps(short)} is a number, and has no {show_steps(long)}"
            )
        _check_kinds(name, one, other)


def _check_kinds(name: str, one: Steps, other: Steps) -> None:
    """Check that two ways do not take one value for a list and for an object."""
    at = next(n for n, pair in enumerate(zip(one, other, strict=False)) if pair[0] != pair[1])
    kinds = {isinstance(step, (int, Each)) for step in (one[at], other[at])}
    if len(kinds) > 1 and not any(isinstance(step, Where) for step in (one[at], other[at])):
        index = next(step for step in (one[at], other[at]) if not isinstance(step, str))
        key = f'; write "{index}" in quotes if it is a key' if isinstance(index, int) else ""
        place = show_steps(one[:at]) or "the payload"
        both = f"{show_steps(one)} and {show_steps(other)}"
        raise MappingError(f"{name}: {place} is a list or an object, not both: {both}{key}")


def _may_meet(one: Steps, other: Steps) -> bool:
    """Return whether both ways can lead to the same value."""
    waiting = {(_Walk(one), _Walk(other))}
    seen: set[tuple[_Walk, _Walk]] = set()
    while waiting:
        pair = waiting.pop()
        if not any(walk.steps for walk in pair) and not _are_apart(*pair):
            return True
        if pair not in seen and not _are_apart(*pair):
            waiting |= {*_next_in_object(*pair), *_next_in_list(*pair)}
        seen.add(pair)
    return False


class _Walk(NamedTuple):
    """The rest of a way from a value, and the known facts of the value."""

    steps: Steps
    known: tuple[Condition, ...] = ()
    """Conditions that the value meets."""

    @property
    def where(self) -> Where | None:
        """The conditions that come next."""
        step = self.steps[0] if self.steps else None
        return step if isinstance(step, Where) else None

    def staying(self) -> "_Walk":
        """Return the walk if the value is an object, which must meet the conditions itself."""
        return _Walk(self.steps[1:], self.known + self.where.conditions) if self.where else self

    def into_element(self) -> "_Walk | None":
        """Return the walk from an element of the value, if it is a list and this goes on in it."""
        if not self.steps or isinstance(self.steps[0], str):
            return None
        if self.where is None:
            return _Walk(self.steps[1:])
        # Conditions before a `[*]` are met by each of its elements.
        count = 2 if self.steps[1:2] == (EACH,) else 1
        return _Walk(self.steps[count:], self.where.conditions)


def _are_apart(one: _Walk, other: _Walk) -> bool:
    """Return whether no value meets the conditions of both."""
    return any(a.contradicts(b) for a in one.known for b in other.known)


def _next_in_object(one: _Walk, other: _Walk) -> Iterator[tuple[_Walk, _Walk]]:
    """Return where both go on from a value, or end at it, if it is an object."""
    one, other = one.staying(), other.staying()
    if not one.steps and not other.steps:
        yield one, other
    if not one.steps or not other.steps or _are_apart(one, other):
        return
    key, other_key = one.steps[0], other.steps[0]
    # An integer is an index of a list, or the same digits as the key of an object.
    if EACH not in (key, other_key) and str(key) == str(other_key):
        yield _Walk(one.steps[1:]), _Walk(other.steps[1:])


def _next_in_list(one: _Walk, other: _Walk) -> Iterator[tuple[_Walk, _Walk]]:
    """Return where both go on from an element of a value, if it is a list."""
    first, second = one.into_element(), other.into_element()
    if first is None or second is None:
        return
    indices = {step for step in (one.steps[0], other.steps[0]) if isinstance(step, int)}
    if len(indices) < 2:
        yield first, second
