"""Refuse mappings that read one number of a payload as two things."""

from collections.abc import Mapping, Sequence
from itertools import combinations

from rosbase.errors import MappingError
from rosbase.mapping.paths import Condition, Each, Step, Steps, Where, show_condition, show_steps

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
            for one, other in combinations(components, 2):
                if _may_meet(one, other):
                    raise MappingError(f"two components of {name} are both at {show_steps(one)}")
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


def _may_meet(one: Steps, other: Steps) -> bool:
    """Return whether both ways can lead to the same value."""
    places, other_places = _places(one), _places(other)
    if len(places) != len(other_places):
        return False
    for (where, step), (other_where, other_step) in zip(places, other_places, strict=True):
        if not _may_be_same(step, other_step) or _are_apart(where, other_where):
            return False
    return True


def _places(steps: Steps) -> list[tuple[Where | None, Step | None]]:
    """Return the steps, each with the condition before it; the last step is None."""
    places: list[tuple[Where | None, Step | None]] = []
    where: Where | None = None
    for step in steps:
        if isinstance(step, Where):
            where = step
        else:
            places.append((where, step))
            where = None
    return [*places, (where, None)]


def _may_be_same(one: Step | None, other: Step | None) -> bool:
    if isinstance(one, Each) or isinstance(other, Each):
        return isinstance(one, (Each, int)) and isinstance(other, (Each, int))
    # An integer is an index of a list, or the same digits as the key of an object.
    return one == other or (None not in (one, other) and str(one) == str(other))


def _are_apart(one: Where | None, other: Where | None) -> bool:
    """Return whether the conditions never hold in the same place."""
    return (
        one is not None
        and other is not None
        and any(a.contradicts(b) for a in one.conditions for b in other.conditions)
    )
